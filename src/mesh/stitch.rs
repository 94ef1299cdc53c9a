//! T-junctions: vertices of one triangle in the middle of a neighbour's edge.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::TriMesh;
use super::edges::{EdgeKind, EdgeUses, kind};

/// A vertex this many roundings of its coordinates beside an edge lies on it.
const ROUNDINGS: f64 = 8.0;

/// Passes before what is still open stays open; a pass splits one edge of a
/// triangle.
const PASSES: usize = 3;

/// What was split to close T-junctions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stitches {
    /// Edges that were split.
    pub edges: usize,
    /// Of each triangle added at the end, the one that it is a piece of.
    pub pieces_of: Vec<u32>,
}

/// Closes open edges on which vertices of the triangles beyond lie, by splitting
/// their triangle at these: it moves nothing. The first piece takes the place of
/// its triangle, the others come last.
pub(crate) fn close_t_junctions(mesh: &mut TriMesh) -> Stitches {
    let mut stitches = Stitches::default();
    for _ in 0..PASSES {
        let found = splits(mesh, &mesh.edges());
        if found.is_empty() {
            break;
        }
        stitches.edges += found.len();
        for Split {
            face,
            opposite,
            path,
        } in found
        {
            for (piece, pair) in path.windows(2).enumerate() {
                let triangle = [pair[0], pair[1], opposite];
                if piece == 0 {
                    mesh.triangles[face] = triangle;
                } else {
                    mesh.triangles.push(triangle);
                    stitches.pieces_of.push(face as u32);
                }
            }
        }
    }
    stitches
}

/// An open edge and what it is split at.
struct Split {
    face: usize,
    opposite: u32,
    /// From end to end.
    path: Vec<u32>,
}

/// One edge at most of each triangle, in order of the triangles.
fn splits(mesh: &TriMesh, uses: &EdgeUses) -> Vec<Split> {
    let open: Vec<_> = uses
        .by_edge()
        .filter(|uses| kind(uses) == EdgeKind::Open)
        .collect();
    // Open edges as their triangles run them, by where they end.
    let mut ending: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let run = |uses: &[super::EdgeUse]| match uses[0] {
        one if one.forward => one.edge,
        one => [one.edge[1], one.edge[0]],
    };
    for uses in &open {
        let [from, to] = run(uses);
        ending.entry(to).or_default().push(from);
    }
    let mut found: Vec<Split> = Vec::new();
    for uses in &open {
        let [from, to] = run(uses);
        let face = uses[0].face.index();
        let corners = mesh.triangles[face];
        let opposite = corners.into_iter().find(|&v| v != from && v != to);
        if let (Some(path), Some(opposite)) = (along(mesh, &ending, from, to), opposite) {
            found.push(Split {
                face,
                opposite,
                path,
            });
        }
    }
    found.sort_by_key(|split| split.face);
    found.dedup_by_key(|split| split.face);
    found
}

/// The open edges of other triangles that run an edge backwards, end to end.
fn along(
    mesh: &TriMesh,
    ending: &FxHashMap<u32, Vec<u32>>,
    from: u32,
    to: u32,
) -> Option<Vec<u32>> {
    let at = |v: u32| mesh.positions[v as usize];
    let way = at(to) - at(from);
    let length = way.length();
    let slack =
        ROUNDINGS * f64::EPSILON * (at(from).abs().max_element() + at(to).abs().max_element());
    let share = |p: DVec3| {
        let off = p - at(from);
        let share = off.dot(way) / (length * length);
        (off - share * way).length().le(&slack).then_some(share)
    };
    let mut path = vec![from];
    let (mut here, mut done) = (from, 0.0);
    while here != to {
        let next = ending.get(&here)?.iter().copied().filter_map(|v| {
            let there = if v == to { 1.0 } else { share(at(v))? };
            (there > done && there <= 1.0).then_some((v, there))
        });
        // The nearest, so that none is passed over.
        (here, done) = next.min_by(|a, b| a.1.total_cmp(&b.1))?;
        path.push(here);
    }
    (path.len() > 2).then_some(path)
}
