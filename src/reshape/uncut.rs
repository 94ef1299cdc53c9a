//! Edits that do not make triangles pass through each other.
//!
//! An edit looks at the triangles around it alone; that another sheet passes
//! there shows in the whole. So the whole is looked at once all edits are made,
//! and where triangles cut each other that did not before, the edits are made
//! again, without those beside that place or, where a mesh of elements is made,
//! with smaller ones there, and without any if those fail too.

use glam::DVec3;

use crate::mesh::{FaceId, self_intersections};
use crate::surface::marked::MarkedMesh;

/// Tries that fail at a place before it is left as it was.
const LEFT: i32 = 2;

/// Places where edits made triangles cut each other: balls by centre, radius and
/// the try, from 1, that showed it.
#[derive(Clone, Debug, Default)]
pub struct Kept(Vec<(DVec3, f64, i32)>);

impl Kept {
    /// Whether a vertex at a place stays, with its triangles.
    pub(super) fn contains(&self, p: DVec3) -> bool {
        self.tries_at(p) > 0
    }

    /// Whether even smaller elements failed at a place: the mesh given stays there.
    pub(super) fn is_left(&self, p: DVec3) -> bool {
        self.tries_at(p) >= LEFT
    }

    /// The last try that failed beside a place; 0 where none did.
    pub(super) fn tries_at(&self, p: DVec3) -> i32 {
        let here = self.0.iter().filter(|(c, r, _)| p.distance(*c) <= *r);
        here.map(|&(_, _, n)| n).max().unwrap_or(0)
    }

    /// Keeps the surroundings of two triangles: a ball `wide` times as wide as
    /// their corners need.
    fn keep(&mut self, mesh: &MarkedMesh, pair: (FaceId, FaceId), wide: f64, attempt: i32) {
        let corners = [pair.0, pair.1].map(|f| mesh.triangles[f.index()]);
        let places = || (corners.iter().flatten()).map(|&v| mesh.vertices[v as usize].at);
        let centre = places().sum::<DVec3>() / 6.0;
        let radius = places().map(|p| p.distance(centre)).fold(0.0, f64::max);
        self.0.push((centre, wide * radius, attempt));
    }
}

/// Edits a mesh so that no more pairs of its triangles pass through each other
/// than before; as it was, if even edits far from such places do.
pub fn without_cuts(
    mesh: MarkedMesh,
    edit: impl Fn(&MarkedMesh, &Kept) -> MarkedMesh,
) -> MarkedMesh {
    const TRIES: i32 = 5;
    let (edited, more) = fewest_cuts(&mesh, TRIES, |kept| edit(&mesh, kept), |edited| edited);
    if more { mesh } else { edited }
}

/// What is made of a mesh with the fewest pairs of triangles that pass through
/// each other, or the first in `tries` that has no more of them than the mesh; and
/// whether even that has more.
pub(super) fn fewest_cuts<T>(
    mesh: &MarkedMesh,
    tries: i32,
    make: impl Fn(&Kept) -> T,
    made: impl Fn(&T) -> &MarkedMesh,
) -> (T, bool) {
    let cuts = |mesh: &MarkedMesh| self_intersections(&mesh.plain());
    let mut kept = Kept::default();
    let mut allowed = None;
    let mut best: Option<(usize, T)> = None;
    let mut attempt = 1;
    loop {
        let next = make(&kept);
        let found = cuts(made(&next));
        let count = found.len();
        if count == 0 || count <= *allowed.get_or_insert_with(|| cuts(mesh).len()) {
            return (next, false);
        }
        tracing::debug!(
            attempt,
            pairs = count,
            "triangles pass through each other: made again"
        );
        for pair in found {
            kept.keep(made(&next), pair, 1.5 * 2_f64.powi(attempt - 1), attempt);
        }
        let least = match best.take() {
            Some(best) if best.0 <= count => best,
            _ => (count, next),
        };
        if attempt >= tries {
            return (least.1, true);
        }
        best = Some(least);
        attempt += 1;
    }
}
