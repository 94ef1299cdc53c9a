//! Facets of a smooth wall that take each other's place under a contour.

use glam::DVec3;

use super::Follower;
use crate::mesh::FaceId;
use crate::trace::probe::Pair;
use crate::trace::tolerances::{CREASE_ANGLE, SHORT_HOP};

impl Follower<'_, '_, '_> {
    /// The pair with `nearer` in the place of a facet of the same smooth wall.
    pub(super) fn slide(&mut self, y: DVec3, pair: Pair, nearer: FaceId) -> Option<Pair> {
        let walls = self.probe.walls();
        let field = walls.field();
        let foot = field.footpoint_on(y, nearer);
        let u = (y - foot.point).normalize_or_zero();
        let cosine = CREASE_ANGLE.to_radians().cos();
        let mut best: Option<(f64, Pair)> = None;
        for (old, new) in [
            (
                pair.left,
                Pair {
                    left: nearer,
                    right: pair.right,
                },
            ),
            (
                pair.right,
                Pair {
                    left: pair.left,
                    right: nearer,
                },
            ),
        ] {
            let was = field.footpoint_on(y, old);
            let mut bend = (y - was.point).normalize_or_zero().dot(u);
            if walls.smooth_neighbours(old, nearer, CREASE_ANGLE) {
                bend = bend.max(cosine);
            }
            if bend < cosine || best.is_some_and(|b| b.0 >= bend) || !walls.slides(&was, &foot) {
                continue;
            }
            best = Some((bend, new));
        }
        let (_, new) = best?;
        walls
            .separate(
                y,
                &field.footpoint_on(y, new.left),
                &field.footpoint_on(y, new.right),
            )
            .then_some(new)
    }

    /// Whether the walls lie plain under a step on which they gave way to
    /// others; a thin web that stands between shows in a shorter step.
    pub(super) fn plain_step(&self, y: DVec3, pair: Pair, stride: f64) -> bool {
        let (walls, field) = (self.probe.walls(), self.probe.field());
        [(self.pair.left, pair.left), (self.pair.right, pair.right)]
            .into_iter()
            .all(|(old, new)| {
                let to = field.footpoint_on(y, new);
                old == new
                    || stride <= SHORT_HOP * to.distance
                    || walls.plain_between(&field.footpoint_on(self.x, old), &to)
            })
    }
}
