//! Triangles without area whose tip lies on their longest edge.
//!
//! Such a cap stands where a vertex of one face lies on an edge of another: it
//! closes the mesh in name only. It has no normal, so it belongs to no wall, tells
//! nothing of inside and outside, and turned by a placement it gets any normal at
//! all. Flipping its longest edge gives its tip to the triangle beyond, as if that
//! had been split there.

use std::collections::VecDeque;

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Repair, Work, gaps};
use crate::mesh::TriMesh;
use crate::mesh::error::PartWarning;

/// A cap is lower than this share of its shortest edge.
const LOW: f64 = 1e-3;

/// Gives the tips of caps to the triangles beyond their longest edges, which their
/// pieces then stand behind. Moves the surface by no more than the noise of single
/// precision; leaves caps whose neighbours do not pair up, and those where a piece
/// would have no area either.
pub(super) fn flip(work: &mut Work) -> Option<Repair> {
    let mesh = &mut work.mesh;
    let noise = gaps::noise(mesh);
    let mut open: VecDeque<u32> = (0..mesh.triangles.len() as u32)
        .filter(|&t| tip(mesh, t, noise).is_some())
        .collect();
    if open.is_empty() {
        return None;
    }
    let mut caps: FxHashSet<u32> = open.iter().copied().collect();
    let mut runs = Runs::of(mesh);
    let mut places = Vec::new();
    while let Some(t) = open.pop_front() {
        if !caps.contains(&t) {
            continue;
        }
        let Some((beyond, pieces)) = flipped(mesh, &runs, t, noise) else {
            continue;
        };
        let [[c, a, _], [_, b, _]] = pieces;
        places.push(mesh.positions[c as usize]);
        runs.drop(a, b);
        for (t, piece) in [t, beyond].into_iter().zip(pieces) {
            mesh.triangles[t as usize] = piece;
            runs.note(t, piece);
        }
        work.origin[t as usize] = work.origin[beyond as usize];
        caps.remove(&t);
        // A chain of caps over one edge goes from the outermost on.
        let beside = [[a, c], [c, b]].map(|[from, to]| runs.once(from, to));
        open.extend(beside.into_iter().flatten().filter(|t| caps.contains(t)));
    }
    if places.is_empty() {
        return None;
    }
    // Pieces go behind the triangle that they are of.
    work.insert(Vec::new());
    let triangles = places.len();
    Some(Repair::at(PartWarning::Flipped { triangles }, places))
}

/// The corner of a cap that lies on the edge across.
fn tip(mesh: &TriMesh, t: u32, noise: f64) -> Option<usize> {
    let p = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
    let side = |k: usize| p[(k + 1) % 3].distance(p[(k + 2) % 3]);
    let k = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b)))?;
    let shortest = side((k + 1) % 3).min(side((k + 2) % 3));
    let height = (p[1] - p[0]).cross(p[2] - p[0]).length() / side(k);
    (height <= noise.min(LOW * shortest)).then_some(k)
}

/// The triangle beyond the longest edge of a cap, and what the two become; the
/// first piece is that in the cap's place.
fn flipped(mesh: &TriMesh, runs: &Runs, t: u32, noise: f64) -> Option<(u32, [[u32; 3]; 2])> {
    let k = tip(mesh, t, noise)?;
    let [c, a, b] = [0, 1, 2].map(|i| mesh.triangles[t as usize][(k + i) % 3]);
    let beyond = runs.once(b, a)?;
    if runs.once(a, b)? != t || tip(mesh, beyond, noise).is_some() {
        return None;
    }
    let far = mesh.triangles[beyond as usize];
    let d = far.into_iter().find(|v| ![a, b].contains(v))?;
    if d == c || runs.has(c, d) || runs.has(d, c) {
        return None;
    }
    let normal = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a)
    };
    let pieces = [[c, a, d], [d, b, c]];
    let whole = normal(far);
    (pieces.iter())
        .all(|&piece| {
            let [p, q, r] = piece.map(|v| mesh.positions[v as usize]);
            let longest = p.distance(q).max(q.distance(r)).max(r.distance(p));
            let n = normal(piece);
            n.length() > noise * longest && n.dot(whole) > 0.5 * n.length() * whole.length()
        })
        .then_some((beyond, pieces))
}

/// Triangles by the edges that they run, in the sense that they do.
struct Runs(FxHashMap<[u32; 2], u32>);

/// An edge that several triangles run alike.
const SEVERAL: u32 = u32::MAX;

impl Runs {
    fn of(mesh: &TriMesh) -> Runs {
        let mut runs = FxHashMap::default();
        for (t, corners) in (0..).zip(&mesh.triangles) {
            for k in 0..3 {
                (runs.entry([corners[k], corners[(k + 1) % 3]]))
                    .and_modify(|other| *other = SEVERAL)
                    .or_insert(t);
            }
        }
        Runs(runs)
    }

    /// The one triangle that runs an edge.
    fn once(&self, from: u32, to: u32) -> Option<u32> {
        self.0.get(&[from, to]).copied().filter(|&t| t != SEVERAL)
    }

    fn has(&self, from: u32, to: u32) -> bool {
        self.0.contains_key(&[from, to])
    }

    /// No triangle runs an edge any more, either way.
    fn drop(&mut self, a: u32, b: u32) {
        self.0.remove(&[a, b]);
        self.0.remove(&[b, a]);
    }

    /// A triangle has other corners.
    fn note(&mut self, t: u32, corners: [u32; 3]) {
        for k in 0..3 {
            let run = (self.0.entry([corners[k], corners[(k + 1) % 3]])).or_insert(t);
            if *run != SEVERAL {
                *run = t;
            }
        }
    }
}
