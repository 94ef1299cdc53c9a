//! A map of the wall thickness: the part in small pieces, with a number at
//! each corner.

use glam::DVec3;
use rayon::prelude::*;

use crate::field::Field;
use crate::mesh::{FaceId, Part, TriMesh};
use crate::walls::thickness::thickness_at;

/// Pieces that the map cuts a part into, about.
const PIECES: f64 = 40_000.0;

/// How far the points of a piece lie inside its corners, as a share of the way
/// to its middle: on an edge the next wall would be nearest.
const INSET: f64 = 0.15;

/// Wall thickness over a whole part.
#[derive(Clone, Debug)]
pub struct ThicknessMap {
    /// The part in pieces, each with corners of its own.
    pub mesh: TriMesh,
    /// One a vertex, in part units; not a number on coping, and where no wall
    /// faces the point.
    pub thickness: Vec<f64>,
}

impl ThicknessMap {
    pub(super) fn measure(part: &Part, field: &Field) -> ThicknessMap {
        let (mesh, faces) = pieces(part);
        let at_corners = |(piece, &face): (usize, &FaceId)| {
            let corners = mesh.corners(FaceId(piece as u32));
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let wall = !part.coping()[face.index()];
            corners.map(|corner| {
                let measured = || thickness_at(field, face, corner.lerp(middle, INSET));
                wall.then(measured).flatten().unwrap_or(f64::NAN)
            })
        };
        let values: Vec<[f64; 3]> = faces.par_iter().enumerate().map(at_corners).collect();
        ThicknessMap {
            mesh,
            thickness: values.into_flattened(),
        }
    }
}

/// The part in small pieces with corners of their own, and the triangle that
/// each comes from.
fn pieces(part: &Part) -> (TriMesh, Vec<FaceId>) {
    let largest = part.area() / PIECES;
    let mut mesh = TriMesh::default();
    let mut faces = Vec::new();
    for face in part.mesh().faces() {
        let [a, b, c] = part.corners(face);
        let share = part.mesh().triangle_area(face) / largest;
        let n = share.sqrt().ceil().max(1.0) as usize;
        let at = |i: usize, j: usize| {
            a + (b - a) * (i as f64 / n as f64) + (c - a) * (j as f64 / n as f64)
        };
        let mut push = |corners: [DVec3; 3]| {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
            faces.push(face);
        };
        for i in 0..n {
            for j in 0..n - i {
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (mesh, faces)
}
