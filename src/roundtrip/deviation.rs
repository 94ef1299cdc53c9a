//! The part with its distance to the solid at every point, to look at.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::field::Field;
use crate::mesh::TriMesh;

/// A mesh with a value at every vertex.
#[derive(Clone, Debug)]
pub struct DeviationMap {
    /// The part, its triangles split into smaller ones.
    pub mesh: TriMesh,
    /// Signed distance by vertex, part units: positive where the solid sticks
    /// out of the part, negative where it falls short.
    pub deviation: Vec<f64>,
}

/// Triangles of a map at most, about.
const MOST: f64 = 1e6;

/// Pieces of a row, or rows of a triangle, at most.
const MOST_PIECES: u32 = 1000;

/// Measures a part against a solid at points some `size` apart.
pub fn deviation_map(part: &TriMesh, solid: &TriMesh, size: f64) -> DeviationMap {
    // Wide triangles count by area, long ones by length.
    let length: f64 = part.faces().map(|face| longest(part.corners(face))).sum();
    let least = (2.0 * part.area() / MOST).sqrt().max(2.0 * length / MOST);
    let mesh = split(part, size.max(least));
    let solid = Field::of_mesh(solid);
    let deviation = (mesh.positions.par_iter())
        .map(|&p| solid.signed_clearance(p))
        .collect();
    DeviationMap { mesh, deviation }
}

/// Length of the longest side.
fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// Each triangle in rows from the corner opposite its shortest edge, so that
/// long ones are not cut up across.
fn split(mesh: &TriMesh, size: f64) -> TriMesh {
    let mut fine = TriMesh::default();
    for face in mesh.faces() {
        let corners = mesh.corners(face);
        let length = |i: usize| corners[i].distance(corners[(i + 1) % 3]);
        let shortest = (0..3).min_by(|&i, &j| length(i).total_cmp(&length(j)));
        let i = shortest.unwrap_or(0);
        let [b, c, a] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
        let pieces = |length: f64| ((length / size).ceil() as u32).clamp(1, MOST_PIECES);
        let rows = pieces(a.distance(b).max(a.distance(c)));
        let mut last = fine.positions.len() as u32..fine.positions.len() as u32 + 1;
        fine.positions.push(a);
        for row in 1..=rows {
            let down = f64::from(row) / f64::from(rows);
            let (left, right) = (a.lerp(b, down), a.lerp(c, down));
            let count = pieces(left.distance(right));
            let start = fine.positions.len() as u32;
            fine.positions
                .extend((0..=count).map(|k| left.lerp(right, f64::from(k) / f64::from(count))));
            let next = start..start + count + 1;
            join(last, next.clone(), &mut fine.triangles);
            last = next;
        }
    }
    fine
}

/// Triangles between two rows of points, the shorter way across each time.
fn join(upper: Range<u32>, lower: Range<u32>, out: &mut Vec<[u32; 3]>) {
    let segments = |row: &Range<u32>| f64::from((row.len() as u32 - 1).max(1));
    let (mut u, mut l) = (upper.start, lower.start);
    while u + 1 < upper.end || l + 1 < lower.end {
        let ahead = |at: u32, row: &Range<u32>| f64::from(at - row.start + 1) / segments(row);
        let on_lower =
            u + 1 == upper.end || (l + 1 < lower.end && ahead(l, &lower) <= ahead(u, &upper));
        if on_lower {
            out.push([u, l, l + 1]);
            l += 1;
        } else {
            out.push([u, l, u + 1]);
            u += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slivers_do_not_multiply() {
        // A needle: 1000 long, 0.001 high.
        let positions = vec![
            DVec3::ZERO,
            DVec3::new(1000.0, 0.0, 0.0),
            DVec3::new(0.0, 1e-3, 0.0),
            DVec3::new(0.0, 0.0, 1.0),
        ];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let needle = TriMesh {
            positions,
            triangles,
        };
        let fine = split(&needle, 2.0);
        assert!(fine.triangles.len() < 5000, "{}", fine.triangles.len());
        assert!((fine.area() / needle.area() - 1.0).abs() < 1e-9);
        assert!((fine.volume() / needle.volume() - 1.0).abs() < 1e-9);
    }
}
