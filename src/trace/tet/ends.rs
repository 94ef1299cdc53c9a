//! Ends of curves through a tetrahedron, and finding the one where a curve arrives.

use glam::DVec3;
use smallvec::SmallVec;

use super::{Port, VertexKey, Work};
use crate::mesh::FaceId;
use crate::trace::follow::seam;
use crate::trace::probe::Pair;
use crate::trace::tolerances::SAME_WAY;

/// One end of a curve through the tetrahedron.
#[derive(Clone, Debug)]
pub(super) struct CurveEnd {
    pub(super) vertex: VertexKey,
    pub(super) at: DVec3,
    /// Ports of its sheets, with the two walls of each.
    pub(super) sheets: SmallVec<[(Port, Pair); 4]>,
    pub(super) kind: EndKind,
    pub(super) done: bool,
}

#[derive(Clone, Debug)]
pub(super) enum EndKind {
    /// A seam (or fading border), its walls and the direction in which it leaves.
    Tie { walls: seam::Walls, towards: DVec3 },
    /// A coping border that starts in the plane of a coping triangle.
    Border { coping: FaceId, towards: DVec3 },
}

impl Work<'_, '_> {
    /// The unused end on a face nearest to a place.
    pub(super) fn end_near(
        &self,
        from: usize,
        at: DVec3,
        face: Option<usize>,
        border: bool,
    ) -> Option<usize> {
        let wanted = face.map(|f| self.face_keys[f]);
        self.nearest_end(from, at, |end| {
            let on_face = match (end.vertex, wanted) {
                (VertexKey::Face(k, _), Some(w)) => k == w,
                _ => false,
            };
            on_face && matches!(end.kind, EndKind::Border { .. }) == border
        })
    }

    pub(super) fn tie_end_near(&self, from: usize, at: DVec3) -> Option<usize> {
        self.nearest_end(from, at, |end| {
            matches!(end.vertex, VertexKey::Inner(..)) && matches!(end.kind, EndKind::Tie { .. })
        })
    }

    fn nearest_end(
        &self,
        from: usize,
        at: DVec3,
        fits: impl Fn(&CurveEnd) -> bool,
    ) -> Option<usize> {
        (0..self.ends.len())
            .filter(|&k| k != from && !self.ends[k].done && fits(&self.ends[k]))
            .filter(|&k| self.ends[k].at.distance(at) <= self.near)
            .min_by(|&a, &b| {
                self.ends[a]
                    .at
                    .distance(at)
                    .total_cmp(&self.ends[b].at.distance(at))
            })
    }

    /// The unused curve end at an inner vertex that points most along `back`.
    pub(super) fn ray_near(&self, from: usize, at: DVec3, back: Option<DVec3>) -> Option<usize> {
        let back = back?;
        self.best_end(from, at, |end| match &end.kind {
            EndKind::Tie { towards, .. } => Some(towards.dot(back)),
            EndKind::Border { .. } => None,
        })
    }

    pub(super) fn border_end_near(
        &self,
        from: usize,
        at: DVec3,
        back: Option<DVec3>,
    ) -> Option<usize> {
        let back = back?;
        self.best_end(from, at, |end| match &end.kind {
            EndKind::Border { towards, .. } => Some(towards.dot(back)),
            EndKind::Tie { .. } => None,
        })
    }

    fn best_end(
        &self,
        from: usize,
        at: DVec3,
        score: impl Fn(&CurveEnd) -> Option<f64>,
    ) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for (k, end) in self.ends.iter().enumerate() {
            if k == from || end.done || !matches!(end.vertex, VertexKey::Inner(..)) {
                continue;
            }
            if end.at.distance(at) > self.near {
                continue;
            }
            if let Some(s) = score(end)
                && s > SAME_WAY
                && best.is_none_or(|b| s > b.0)
            {
                best = Some((s, k));
            }
        }
        best.map(|b| b.1)
    }

    pub(super) fn place_near(&self, at: DVec3) -> Option<u16> {
        self.places
            .iter()
            .find(|p| p.1.distance(at) <= self.near)
            .map(|p| p.0)
    }
}
