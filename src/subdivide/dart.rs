//! Where a crease ends inside the surface: a *dart*.
//!
//! The vertex moves as a smooth one, but its sharp edge does not, so neither
//! (2.2) nor (2.3) holds, and no closed form is known. Both the limit point and
//! the tangent plane are the outcome of steps on the vertex, its `n` edge and
//! its `n` face neighbours, which depend on themselves alone.

use glam::DVec3;

/// Steps after which a mask has settled: what else it has shrinks by 0.66 a
/// step at the most, whatever the valence.
const STEPS: usize = 120;

/// Steps after which the neighbours lie on the tangent plane.
const FLAT: usize = 60;

/// Weights of the vertex, its edge neighbours from the sharp edge on, and its
/// face neighbours.
#[derive(Clone, Debug)]
pub(super) struct Mask {
    centre: f64,
    edges: Vec<f64>,
    faces: Vec<f64>,
}

impl Mask {
    /// The limit mask for `n` faces: the one that a step leaves as it is.
    pub fn new(n: usize) -> Mask {
        let wide = n as f64;
        let mut mask = Mask {
            centre: 1.0,
            edges: vec![0.0; n],
            faces: vec![0.0; n],
        };
        for _ in 0..STEPS {
            let before = |k: usize| (k + n - 1) % n;
            let after = |k: usize| (k + 1) % n;
            let own = mask.centre;
            let mut next = Mask {
                centre: own * (1.0 - 7.0 / (4.0 * wide)),
                edges: vec![own * 1.5 / (wide * wide); n],
                faces: vec![own * 0.25 / (wide * wide); n],
            };
            for k in 0..n {
                let weight = mask.edges[k];
                if k == 0 {
                    next.centre += 0.5 * weight;
                    next.edges[0] += 0.5 * weight;
                } else {
                    next.centre += 0.375 * weight;
                    next.edges[k] += 0.375 * weight;
                    for edge in [before(k), after(k)] {
                        next.edges[edge] += 0.0625 * weight;
                    }
                    for face in [before(k), k] {
                        next.faces[face] += 0.0625 * weight;
                    }
                }
                let quarter = 0.25 * mask.faces[k];
                next.centre += quarter;
                next.faces[k] += quarter;
                next.edges[k] += quarter;
                next.edges[after(k)] += quarter;
            }
            mask = next;
        }
        mask
    }

    /// The weighted sum.
    pub fn weigh(
        &self,
        centre: DVec3,
        edge: impl Fn(usize) -> DVec3,
        face: impl Fn(usize) -> DVec3,
    ) -> DVec3 {
        let mut sum = self.centre * centre;
        for (k, (&at_edge, &at_face)) in self.edges.iter().zip(&self.faces).enumerate() {
            sum += at_edge * edge(k) + at_face * face(k);
        }
        sum
    }
}

/// Normal of the tangent plane, of any length, from the edge and the face
/// neighbours relative to the vertex.
///
/// The neighbours close in on the plane by the ratio of two eigenvalues a step,
/// slowly only at valences far beyond use.
pub(super) fn normal(edges: &[DVec3], faces: &[DVec3]) -> DVec3 {
    let n = faces.len();
    let wide = n as f64;
    let mask = Mask::new(n);
    let (mut centre, mut edges, mut faces) = (DVec3::ZERO, edges[..n].to_vec(), faces.to_vec());
    for _ in 0..FLAT {
        // Relative to the limit point, and as wide as before.
        let limit = mask.weigh(centre, |k| edges[k], |k| faces[k]);
        let at = |p: DVec3| 2.0 * (p - limit);
        centre = at(centre);
        edges.iter_mut().chain(&mut faces).for_each(|p| *p = at(*p));
        let sums: [DVec3; 2] = [edges.iter().sum(), faces.iter().sum()];
        let smooth = |k: usize| {
            let (before, after) = ((k + n - 1) % n, (k + 1) % n);
            let around = edges[before] + edges[after] + faces[before] + faces[k];
            0.375 * (centre + edges[k]) + 0.0625 * around
        };
        let edge = |k: usize| match k {
            0 => 0.5 * (centre + edges[0]),
            _ => smooth(k),
        };
        let face = |k: usize| 0.25 * (centre + edges[k] + faces[k] + edges[(k + 1) % n]);
        let next = ((0..n).map(edge).collect(), (0..n).map(face).collect());
        centre = (1.0 - 7.0 / (4.0 * wide)) * centre
            + 1.5 / (wide * wide) * sums[0]
            + 0.25 / (wide * wide) * sums[1];
        (edges, faces) = next;
    }
    let cross = |k: usize| (edges[k] - centre).cross(edges[(k + 1) % n] - centre);
    (0..n).map(cross).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps on scalars: the weighted sum is the same after each.
    #[test]
    fn the_mask_is_one_that_steps_leave_alone() {
        for n in [2, 3, 4, 5, 7, 20, 50] {
            let mask = Mask::new(n);
            let sum = mask.centre + mask.edges.iter().chain(&mask.faces).sum::<f64>();
            assert!((sum - 1.0).abs() < 1e-13, "{n}: {sum}");
            let at = |seed: usize| DVec3::splat(((seed * 7919) % 101) as f64 / 101.0);
            let (edges, faces) = (|k: usize| at(k + 3), |k: usize| at(k + 60));
            let before = mask.weigh(at(1), edges, faces);
            let wide = n as f64;
            let sums: [DVec3; 2] = [(0..n).map(edges).sum(), (0..n).map(faces).sum()];
            let centre = (1.0 - 7.0 / (4.0 * wide)) * at(1)
                + (1.5 * sums[0] + 0.25 * sums[1]) / (wide * wide);
            let edge = |k: usize| match k {
                0 => 0.5 * (at(1) + edges(0)),
                _ => {
                    let sides = edges((k + n - 1) % n) + edges((k + 1) % n);
                    let around = sides + faces(k) + faces((k + n - 1) % n);
                    0.375 * (at(1) + edges(k)) + around / 16.0
                }
            };
            let face = |k: usize| 0.25 * (at(1) + edges(k) + faces(k) + edges((k + 1) % n));
            let after = mask.weigh(centre, edge, face);
            assert!(before.distance(after) < 1e-14, "{n}");
        }
    }
}
