//! Sharp edges between cross-section and inner shell.
//!
//! The contour's vertices have to stay in their cells, so where the far edge of
//! a strip passes just beside a cell, triangles cut it off. As in the shape
//! optimisation of the paper's section 4.3, vertices may leave their cells here;
//! unlike there, they go to the edge at once, because its place is known, and
//! go back where triangles would cut each other.

use glam::DVec3;
use rayon::prelude::*;

use crate::dual_contour::Numbers;
use crate::mesh::{TriMesh, is_thin, self_intersections};

use super::patch::{OnRim, Patch};

/// Distances below this, over the thickness, are none.
const NONE: f64 = 1e-6;

/// Vertices are moved by this at most, in cells.
const REACH: f64 = 0.75;

/// Vertices this far below the shell and off the cross-section, in cells,
/// belong to the edge between the two: a crease that just missed its cell.
const OFF: f64 = 0.3;

/// Triangles lower than this, over their longest side, are not made.
const THIN: f64 = 1e-4;

/// Times that vertices are put back before all are.
const ROUNDS: usize = 5;

/// What a vertex lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Spot {
    /// Inner shell, off the cross-section.
    Shell,
    /// Cross-section, or beside it, off the shell; the place beyond it on the
    /// far edge.
    Strip(DVec3),
    Other,
}

/// Moves vertices of the cross-section beside the inner shell to its far edge;
/// the mesh cuts itself nowhere, before and after. Vertices of the patch, the
/// first ones, stay. Returns how many moved.
pub(super) fn sharpen(
    patch: &Patch,
    mesh: &mut TriMesh,
    thickness: f64,
    cell: f64,
    numbers: Numbers,
) -> usize {
    let own = patch.mesh.positions.len();
    let spots: Vec<Spot> = mesh.positions[own..]
        .par_iter()
        .map(|&p| spot(patch, p, thickness, cell))
        .collect();
    let of = |v: u32| {
        let new = (v as usize).checked_sub(own);
        new.map_or(Spot::Other, |i| spots[i])
    };
    // Edges from the cross-section to the shell that pass the far edge by.
    let mut moved: Vec<(u32, DVec3)> = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            for (strip, shell) in [(from, to), (to, from)] {
                if let (Spot::Strip(target), Spot::Shell) = (of(strip), of(shell)) {
                    moved.push((strip, numbers.round_point(target)));
                }
            }
        }
    }
    moved.sort_by_key(|&(v, _)| v);
    moved.dedup_by_key(|&mut (v, _)| v);

    let home = mesh.positions.clone();
    for &(v, target) in &moved {
        mesh.positions[v as usize] = target;
    }
    for _ in 0..ROUNDS {
        let pairs = self_intersections(mesh);
        let cutting = pairs.iter().flat_map(|&(f, g)| [f, g]);
        let thin = mesh.faces().skip(patch.mesh.triangles.len());
        let thin = thin.filter(|&f| is_thin(mesh.corners(f), THIN));
        let mut back: Vec<u32> = cutting
            .chain(thin)
            .flat_map(|f| mesh.triangles[f.index()])
            .filter(|&v| mesh.positions[v as usize] != home[v as usize])
            .collect();
        if back.is_empty() && pairs.is_empty() {
            return moved.len();
        }
        back.sort_unstable();
        for &v in &back {
            mesh.positions[v as usize] = home[v as usize];
        }
        moved.retain(|(v, _)| back.binary_search(v).is_err());
    }
    mesh.positions = home;
    0
}

fn spot(patch: &Patch, p: DVec3, thickness: f64, cell: f64) -> Spot {
    let foot = patch.foot(p, 0);
    let none = NONE * thickness;
    let depth = thickness - foot.distance;
    let slack = if depth > none { OFF * cell } else { none };
    let strip = |edge: u32| {
        let e = &patch.rim.edges[edge as usize];
        let [a, b] = [e.from, e.to].map(|v| patch.position(v));
        let along = (b - a).normalize_or_zero();
        let base = a + (p - a).dot(along) * along;
        let off = (p - a).dot(e.outward).abs();
        (off < slack).then(|| base + thickness * e.down)
    };
    let over = match foot.rim {
        Some(OnRim::Edge(e)) => strip(e),
        Some(OnRim::Vertex(v)) => {
            let v = patch.position(v);
            Some(v + thickness * (p - v).normalize_or_zero())
        }
        None => patch.strips_of(foot.face).find_map(strip),
    };
    match over {
        None if depth.abs() < none => Spot::Shell,
        // Where strips lean towards each other, the far edge is nearer.
        Some(target) if depth > none && depth < REACH * cell => {
            let there = patch.foot(target, foot.face).distance;
            if there > thickness - none {
                Spot::Strip(target)
            } else {
                Spot::Other
            }
        }
        _ => Spot::Other,
    }
}
