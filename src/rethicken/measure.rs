//! What of the true solid's surface a mesh of it does not have.

use glam::DVec3;
use rayon::prelude::*;

use super::solid::SlabSolid;
use super::surface::BallSurface;
use crate::dual_contour::Implicit;
use crate::field::Missing;
use crate::mesh::TriMesh;

/// Points that are looked for: beside triangles, and on flat ends.
const SAMPLES: usize = 5_000;

/// Values of this share of the radius are rounding.
const ROUNDING: f64 = 1e-6;

/// Steps from a ball's surface to that of the slab, whose balls differ.
const STEPS: usize = 3;

/// Most points along an end, and up it.
const ALONG: usize = 5;

/// Looks for points of the true surface on a solid.
pub(super) fn missing(
    solid: &SlabSolid,
    surface: &BallSurface,
    mesh: &TriMesh,
    cell: f64,
) -> Missing {
    let points = [side_points(solid, surface), end_points(solid, surface)].concat();
    Missing::of(&points, mesh, cell)
}

/// Points over and under the middles of triangles, where no other slab is.
fn side_points(solid: &SlabSolid, surface: &BallSurface) -> Vec<DVec3> {
    let triangles = &surface.triangles;
    let step = triangles.len().div_ceil(SAMPLES).max(1);
    let points = |(index, corners): (u32, &[u32; 3])| {
        let [a, b, c] = corners.map(|v| surface.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let radius = corners.map(|v| surface.radii[v as usize]);
        let radius = radius.iter().sum::<f64>() / 3.0;
        let middle = (a + b + c) / 3.0;
        [normal, -normal]
            .into_iter()
            .filter_map(move |up| on_surface(solid, middle + radius * up, index, radius))
    };
    let chosen: Vec<(u32, &[u32; 3])> = (0..).zip(triangles).step_by(step).collect();
    chosen.into_par_iter().flat_map_iter(points).collect()
}

/// Points of the flat ends that nothing else covers.
fn end_points(solid: &SlabSolid, surface: &BallSurface) -> Vec<DVec3> {
    let flat = &surface.flat;
    let step = flat.len().div_ceil(SAMPLES).max(1);
    // Few ends are looked at more closely.
    let each = SAMPLES / flat.len().max(1);
    let side = (1..=ALONG).rev().find(|n| n * n <= each).unwrap_or(1);
    let share = move |i: usize| (i as f64 + 0.5) / side as f64;
    flat.par_iter()
        .step_by(step)
        .flat_map_iter(|edge| {
            let [a, b, c] =
                surface.triangles[edge.triangle as usize].map(|v| surface.positions[v as usize]);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let [from, to] = edge.ends.map(|v| surface.positions[v as usize]);
            let radii = edge.ends.map(|v| surface.radii[v as usize]);
            (0..side * side).filter_map(move |k| {
                let along = share(k % side);
                let radius = radii[0] + along * (radii[1] - radii[0]);
                let height = radius * (2.0 * share(k / side) - 1.0);
                let p = from.lerp(to, along) + height * normal;
                on_surface(solid, p, edge.triangle, radius)
            })
        })
        .collect()
}

/// The point, moved by less than the radius onto the solid's surface; none if it
/// is not near that.
fn on_surface(solid: &SlabSolid, p: DVec3, hint: u32, radius: f64) -> Option<DVec3> {
    let mut at = p;
    for _ in 0..STEPS {
        let sample = solid.sample(at, hint);
        if sample.unsigned <= ROUNDING * radius {
            return Some(at);
        }
        if sample.unsigned > 0.1 * radius {
            return None;
        }
        at -= sample.value * sample.gradient;
    }
    None
}
