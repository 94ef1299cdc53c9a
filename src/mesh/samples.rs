//! Points spread evenly over a mesh.

use glam::DVec3;

use super::{FaceId, TriMesh};

/// Steps of the R2 sequence: powers of the inverse of the plastic number.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// `count` points, as many by area everywhere, with their triangles; always
/// the same ones.
pub(crate) fn spread(mesh: &TriMesh, count: usize) -> Vec<(FaceId, DVec3)> {
    let mut sum = 0.0;
    let reached: Vec<f64> = mesh
        .faces()
        .map(|face| {
            let [a, b, c] = mesh.corners(face);
            sum += 0.5 * (b - a).cross(c - a).length();
            sum
        })
        .collect();
    if sum.is_nan() || sum <= 0.0 {
        return Vec::new();
    }
    (0..count)
        .map(|i| {
            let place = (i as f64 + 0.5) / count as f64 * sum;
            let at = reached
                .partition_point(|&r| r <= place)
                .min(reached.len() - 1);
            let face = FaceId(at as u32);
            let [mut u, mut v] = R2.map(|step| (0.5 + step * i as f64).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let [a, b, c] = mesh.corners(face);
            (face, a + u * (b - a) + v * (c - a))
        })
        .collect()
}
