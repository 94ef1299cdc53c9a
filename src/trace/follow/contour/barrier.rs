//! Where a contour leaves the part, or the patch of coping that it runs on.

use glam::DVec3;

use super::{Follower, Shorten, heading};
use crate::mesh::FaceId;
use crate::trace::follow::region::{Barrier, Exit, Fence};
use crate::trace::probe::Pair;
use crate::trace::solve::{Condition, on_coping};
use crate::trace::tolerances::SAGITTA;

impl Follower<'_, '_, '_> {
    /// Where the way from the present point to `y` meets the barrier.
    pub(super) fn barrier(
        &mut self,
        y: DVec3,
        pair: Pair,
    ) -> Result<Option<(DVec3, Exit)>, Shorten> {
        let skip = if self.at_vertex() {
            self.lengths.same_point
        } else {
            0.0
        };
        match &self.region.barrier {
            Barrier::None => Ok(None),
            Barrier::Coping => match self.probe.coping_hit(self.x, y, skip) {
                None => Ok(None),
                Some((near, coping)) => {
                    let (at, coping) = self.settle(near, coping, pair).ok_or(Shorten::Some)?;
                    Ok(Some((at, Exit::Coping(coping))))
                }
            },
            Barrier::Fences(fences) => self.fence(fences, y, pair),
        }
    }

    /// The first fence that the contour crosses outwards on the way to `y`.
    ///
    /// The chord only proposes fences: near a corner of the patch the contour
    /// may pass on the other side of it than its chord. Where the contour
    /// itself meets the line of a fence decides.
    fn fence(
        &self,
        fences: &[Fence],
        y: DVec3,
        pair: Pair,
    ) -> Result<Option<(DVec3, Exit)>, Shorten> {
        let t = heading(self.probe, self.x, self.region.normal, self.pair).0;
        let chord = y - self.x;
        let sagitta = SAGITTA * chord.length() + 2.0 * self.lengths.tie;
        let mut first: Option<(f64, DVec3, usize)> = None;
        for (k, fence) in fences.iter().enumerate() {
            let along = fence.to - fence.from;
            let length = along.length();
            let along = along / length.max(f64::MIN_POSITIVE);
            let inside = self.region.normal.cross(along).normalize_or_zero();
            let (a, b) = (inside.dot(self.x - fence.from), inside.dot(y - fence.from));
            // Along a fence, as over a row of facets, the contour stays in its facet.
            if b >= -self.lengths.outside || a <= b || a < -self.lengths.tie {
                continue;
            }
            if a <= self.lengths.tie && t.dot(inside) > 0.0 {
                // It starts on this fence, inwards, and comes back to it: the
                // chord leaves the patch where the contour runs into it first.
                return Err(Shorten::Some);
            }
            let s = (a / (a - b)).clamp(0.0, 1.0);
            let guess = self.x + s * chord;
            let off = |p: DVec3| {
                let place = (p - fence.from).dot(along);
                (-place).max(place - length)
            };
            if off(guess) > sagitta {
                continue;
            }
            let third = Condition::plane(inside, fence.from);
            // Without a tie there the pair is that of the far end of the step.
            let at = (self.correct(guess, third, pair, 2.0 * sagitta)).ok_or(Shorten::Some)?;
            let way = (at - self.x).dot(chord);
            if off(at) <= self.lengths.tie && first.is_none_or(|f| way < f.0) {
                first = Some((way, at, k));
            }
        }
        Ok(first.map(|(_, at, k)| (at, Exit::Fence(k))))
    }

    /// Whether a step ends outside the part without having crossed the
    /// barrier: the contour bulges into the part, its chord does not.
    pub(super) fn strays(&self, y: DVec3) -> bool {
        matches!(self.region.barrier, Barrier::Coping) && self.probe.is_outside(y)
    }

    /// Whether a step on a patch of coping ends off the coping: it passed the
    /// outline unseen.
    pub(super) fn off_patch(&self, y: DVec3) -> bool {
        matches!(self.region.barrier, Barrier::Fences(_))
            && self
                .probe
                .field()
                .nearest_coping(y, self.lengths.tie)
                .is_none()
    }

    /// The point of the contour on the coping, starting from a guess.
    fn settle(&self, near: DVec3, coping: FaceId, pair: Pair) -> Option<(DVec3, FaceId)> {
        let conditions = [pair.tie(), self.region.plane()];
        on_coping(
            self.probe.field(),
            conditions,
            near,
            coping,
            self.size,
            self.lengths.solve,
        )
    }
}
