//! T-junctions: vertices of one triangle in the middle of a neighbour's edge.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::{Faults, Repair, Work, gaps, open_runs};
use crate::mesh::error::PartWarning;
use crate::mesh::{TriMesh, edges::EdgeUses};

/// A vertex this many roundings of its coordinates beside an edge lies on it.
const ROUNDINGS: f64 = 8.0;

/// Passes before what is still open stays open; a pass splits one edge of a
/// triangle.
const PASSES: usize = 3;

/// Closes open edges on which vertices of the triangles beyond lie, by splitting
/// their triangle at these. Vertices beside the edge by no more than the noise of
/// single precision count if that closes the mesh, or if `all` is asked for.
pub(super) fn close_t_junctions(work: &mut Work, all: bool) -> Option<Repair> {
    let first = pass(work, &rounding);
    if Faults::of(&work.mesh).open == 0 {
        return first;
    }
    let noise = gaps::noise(&work.mesh);
    let mut tried = Work {
        mesh: work.mesh.clone(),
        origin: work.origin.clone(),
        unchecked: None,
    };
    match pass(&mut tried, &|length, _| noise.min(1e-3 * length)) {
        Some(second) if all || Faults::of(&tried.mesh).open == 0 => {
            *work = tried;
            Some(match first {
                Some(first) => both(first, second),
                None => second,
            })
        }
        _ => first,
    }
}

/// Splits triangles where vertices of others lie on their open edges, to rounding;
/// pieces stand behind their triangle. How many edges were split.
pub(crate) fn close_exactly(mesh: &mut TriMesh) -> usize {
    let mut work = Work {
        origin: (0..mesh.triangles.len() as u32).collect(),
        mesh: std::mem::take(mesh),
        unchecked: None,
    };
    let repair = pass(&mut work, &rounding);
    *mesh = work.mesh;
    match repair.map(|repair| repair.what) {
        Some(PartWarning::Stitched { edges, .. }) => edges,
        _ => 0,
    }
}

/// A slack of some roundings.
fn rounding(_: f64, far: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * far
}

/// Two rounds told as one.
fn both(first: Repair, second: Repair) -> Repair {
    let count = |repair: &Repair| match repair.what {
        PartWarning::Stitched { edges, triangles } => [edges, triangles],
        _ => [0, 0],
    };
    let ([a, b], [c, d]) = (count(&first), count(&second));
    let what = PartWarning::Stitched {
        edges: a + c,
        triangles: b + d,
    };
    Repair::at(what, first.places.into_iter().chain(second.places))
}

/// How far beside an edge a vertex may lie to be on it, by the edge's length and
/// the sum of the largest coordinates of its ends.
type Slack<'a> = dyn Fn(f64, f64) -> f64 + 'a;

fn pass(work: &mut Work, slack: &Slack) -> Option<Repair> {
    let before = work.mesh.triangles.len();
    let mut places = Vec::new();
    for _ in 0..PASSES {
        let found = splits(&work.mesh, &work.mesh.edges(), slack);
        if found.is_empty() {
            break;
        }
        let mut added = Vec::new();
        for Split {
            face,
            opposite,
            path,
        } in found
        {
            places.push(work.mesh.positions[path[1] as usize]);
            for (piece, pair) in path.windows(2).enumerate() {
                let triangle = [pair[0], pair[1], opposite];
                if piece == 0 {
                    work.mesh.triangles[face] = triangle;
                } else {
                    added.push((work.origin[face], triangle));
                }
            }
        }
        work.insert(added);
    }
    (!places.is_empty()).then(|| {
        let what = PartWarning::Stitched {
            edges: places.len(),
            triangles: work.mesh.triangles.len() - before,
        };
        Repair::at(what, places)
    })
}

/// An open edge and what it is split at.
struct Split {
    face: usize,
    opposite: u32,
    /// From end to end.
    path: Vec<u32>,
}

/// One edge at most of each triangle, in order of the triangles.
fn splits(mesh: &TriMesh, uses: &EdgeUses, slack: &Slack) -> Vec<Split> {
    let open = open_runs(uses);
    // Open edges by where they end.
    let mut ending: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for &([from, to], _) in &open {
        ending.entry(to).or_default().push(from);
    }
    let mut found: Vec<Split> = Vec::new();
    for &([from, to], face) in &open {
        let corners = mesh.triangles[face];
        let opposite = corners.into_iter().find(|&v| v != from && v != to);
        let path = along(mesh, &ending, [from, to], slack);
        if let (Some(path), Some(opposite)) = (path, opposite) {
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
    [from, to]: [u32; 2],
    slack: &Slack,
) -> Option<Vec<u32>> {
    let at = |v: u32| mesh.positions[v as usize];
    let way = at(to) - at(from);
    let length = way.length();
    let far = at(from).abs().max_element() + at(to).abs().max_element();
    let slack = slack(length, far);
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
