//! How far a solid is from the true one: from its triangles to the true shell,
//! and from points of the true shell and cross-section to its triangles.

use glam::DVec3;
use rayon::prelude::*;

use super::patch::Patch;
use crate::dual_contour::Deviation;
use crate::field::Missing;
use crate::mesh::TriMesh;

/// Points of the true surface that are looked for: of the shell, and of the
/// cross-section.
const SAMPLES: usize = 5_000;

/// Distances of this share of the thickness are rounding.
const ROUNDING: f64 = 1e-6;

/// Looks for points of the true surface on a solid.
pub(super) fn missing(patch: &Patch, solid: &TriMesh, thickness: f64, cell: f64) -> Missing {
    let points = [
        strip_points(patch, thickness),
        shell_points(patch, thickness),
    ]
    .concat();
    Missing::of(&points, solid, cell)
}

/// Most points along a strip, and down it.
const ALONG: usize = 5;

/// Points of the strips that the rest of the patch leaves there.
fn strip_points(patch: &Patch, thickness: f64) -> Vec<DVec3> {
    let edges = &patch.rim.edges;
    let step = edges.len().div_ceil(SAMPLES).max(1);
    // Few strips are looked at more closely.
    let each = SAMPLES / edges.len().max(1);
    let side = (1..=ALONG).rev().find(|n| n * n <= each).unwrap_or(1);
    let share = |i: usize| (i as f64 + 0.5) / side as f64;
    let points = |e: &super::patch::RimEdge| {
        let [from, to] = [e.from, e.to].map(|v| patch.position(v));
        let (down, face) = (e.down, e.face);
        (0..side * side).filter_map(move |k| {
            let base = from.lerp(to, share(k % side));
            let p = base + share(k / side) * thickness * down;
            let foot = patch.foot(p, face);
            let own = foot.rim.is_some() && foot.point.distance(base) < ROUNDING * thickness;
            own.then_some(p)
        })
    };
    edges
        .par_iter()
        .step_by(step)
        .flat_map_iter(points)
        .collect()
}

/// Points of the shell, behind the middles of triangles.
fn shell_points(patch: &Patch, thickness: f64) -> Vec<DVec3> {
    let mesh = &patch.mesh;
    let step = mesh.triangles.len().div_ceil(SAMPLES).max(1);
    let faces: Vec<u32> = (0..mesh.triangles.len() as u32).step_by(step).collect();
    let point = |&face: &u32| {
        let corners = mesh.triangles[face as usize].map(|v| patch.position(v));
        let base = (corners[0] + corners[1] + corners[2]) / 3.0;
        let p = base - thickness * patch.normal(face);
        let foot = patch.foot(p, face);
        let own = foot.rim.is_none() && foot.point.distance(base) < ROUNDING * thickness;
        own.then_some(p)
    };
    faces.par_iter().filter_map(point).collect()
}

/// Distance from the true inner shell, at the centres of those of the triangles
/// that belong to it.
pub(super) fn deviation(
    patch: &Patch,
    triangles: &[[u32; 3]],
    mesh: &TriMesh,
    thickness: f64,
) -> Deviation {
    let errors: Vec<f64> = triangles
        .par_iter()
        .filter_map(|t| {
            let corners = t.map(|v| mesh.positions[v as usize]);
            let shell = |p: DVec3| {
                let foot = patch.foot(p, 0);
                let error = (foot.distance - thickness).abs();
                (error < 0.1 * thickness).then_some(error)
            };
            let [a, b, c] = corners.map(shell);
            (a?.max(b?).max(c?) < 0.01 * thickness)
                .then(|| shell((corners[0] + corners[1] + corners[2]) / 3.0))
                .flatten()
        })
        .collect();
    Deviation::of(errors)
}
