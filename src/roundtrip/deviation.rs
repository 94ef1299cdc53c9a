//! The part with its distance to the solid at every point, to look at.

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

/// Measures a part against a solid at points some `size` apart.
pub fn deviation_map(part: &TriMesh, solid: &TriMesh, size: f64) -> DeviationMap {
    let size = size.max((2.0 * part.area() / MOST).sqrt());
    let mut mesh = TriMesh::default();
    for face in part.faces() {
        let corners = part.corners(face);
        let [a, b, c] = corners;
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let n = ((longest / size).ceil() as u32).clamp(1, 1000);
        split(corners, n, &mut mesh);
    }
    let solid = Field::of_mesh(solid);
    let deviation = (mesh.positions.par_iter())
        .map(|&p| solid.signed_clearance(p))
        .collect();
    DeviationMap { mesh, deviation }
}

/// Appends a triangle as n x n smaller ones.
fn split([a, b, c]: [DVec3; 3], n: u32, out: &mut TriMesh) {
    let first = out.positions.len() as u32;
    // Row i has i + 1 points.
    for i in 0..=n {
        let (left, right) = (
            a.lerp(b, f64::from(i) / f64::from(n)),
            a.lerp(c, f64::from(i) / f64::from(n)),
        );
        for j in 0..=i {
            let along = if i == 0 {
                0.0
            } else {
                f64::from(j) / f64::from(i)
            };
            out.positions.push(left.lerp(right, along));
        }
    }
    let at = |i: u32, j: u32| first + i * (i + 1) / 2 + j;
    for i in 0..n {
        for j in 0..=i {
            out.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            if j < i {
                out.triangles
                    .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
}
