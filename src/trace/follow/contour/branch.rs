//! Where another wall comes up beside a contour: a branch point, or a facet
//! edge of a curved wall.

use glam::DVec3;

use super::{Follower, Shorten, Step, Stop, heading};
use crate::mesh::FaceId;
use crate::trace::follow::fan::{Fan, fan, one_place};
use crate::trace::probe::Pair;
use crate::trace::solve::{Condition, distance_to, solve};
use crate::trace::tolerances::{CREASE_ANGLE, POLISH, SAME_WAY};

impl Follower<'_, '_, '_> {
    /// Another wall is nearer at `y`: find where it came up and what meets there.
    pub(super) fn meet(&mut self, y: DVec3, pair: Pair, nearer: FaceId) -> Result<Step, Shorten> {
        let (at, distance, third) = self.branch_point(y, pair, nearer)?;
        let (at, distance) = self
            .polish(at, [pair.left, pair.right, third])
            .unwrap_or((at, distance));
        let (t, _) = heading(self.probe, self.x, self.region.normal, self.pair);
        let ahead = (at - self.x).dot(t);
        if ahead < -self.lengths.same_point || self.region.excess(at) > self.lengths.outside {
            return Err(Shorten::Some);
        }
        if self.at_vertex() && ahead <= self.lengths.same_point {
            // The branch point that the contour leaves: its walls come near
            // again farther on, and a shorter step tells where.
            return Err(Shorten::Some);
        }
        if let Some((place, exit)) = self.barrier(at, pair)?
            && ahead > self.lengths.tie
            && place.distance(at) > self.lengths.tie
        {
            // The barrier stands before the branch point. Where the walls of
            // the far end do not lead to it, a shorter step has the right ones.
            if place.distance(self.x) > at.distance(self.x) || !self.nearest_there(place, pair) {
                return Err(Shorten::Some);
            }
            return Ok(Step::Stop(Stop::Leaves {
                at: place,
                pair,
                exit,
            }));
        }
        if self.strays(at) {
            return Err(Shorten::Some);
        }
        let fan = fan(self.probe, at, self.region.normal, distance);
        let arrived = self.spoke_back(&fan, pair).ok_or(Shorten::Some)?;
        if fan.spokes.len() == 2 {
            let on = fan.spokes[1 - arrived];
            let bend = on.direction.dot(-fan.spokes[arrived].direction);
            if bend > (0.5 * CREASE_ANGLE).to_radians().cos() {
                let pair = self.prefer(at, on.pair, third);
                return self.turn(fan, arrived, pair, ahead);
            }
        }
        Ok(Step::Stop(Stop::Node { fan, arrived, pair }))
    }

    /// Where a third wall ties with the pair on the way to `y`, its distance,
    /// and that wall: the nearest one there.
    fn branch_point(
        &mut self,
        y: DVec3,
        pair: Pair,
        nearer: FaceId,
    ) -> Result<(DVec3, f64, FaceId), Shorten> {
        const MOST_WALLS: usize = 16;
        let field = self.probe.field();
        let mut third = nearer;
        for _ in 0..MOST_WALLS {
            let lead =
                |p: DVec3| distance_to(field, p, third).0 - distance_to(field, p, pair.left).0;
            let (g, h) = (lead(self.x), lead(y));
            let s = if g > h {
                (g / (g - h)).clamp(0.0, 1.0)
            } else {
                0.5
            };
            let guess = self.x.lerp(y, s);
            let reach = 2.0 * self.x.distance(y) + self.lengths.same_point;
            let conditions = [
                pair.tie(),
                Condition::Tie(pair.left, third),
                self.region.plane(),
            ];
            let found = solve(field, conditions, guess, reach, self.lengths.solve);
            let at = found.ok_or(Shorten::Some)?;
            let d = distance_to(field, at, pair.left).0;
            let foot = self.probe.nearest(at, third);
            if foot.distance >= d - self.lengths.tie {
                return Ok((at, d.min(foot.distance), third));
            }
            if foot.face == third {
                break;
            }
            third = foot.face;
        }
        Err(Shorten::Some)
    }

    /// The spoke of a branch point on which a contour with `pair` arrives.
    fn spoke_back(&self, fan: &Fan, pair: Pair) -> Option<usize> {
        let (on, _) = heading(self.probe, fan.at, self.region.normal, pair);
        let along = |k: &usize| fan.spokes[*k].direction.dot(-on);
        (0..fan.spokes.len())
            .max_by(|a, b| along(a).total_cmp(&along(b)))
            .filter(|k| along(k) >= SAME_WAY)
    }

    /// Walks on with another facet of a curved wall from a facet edge.
    fn turn(&mut self, fan: Fan, arrived: usize, pair: Pair, ahead: f64) -> Result<Step, Shorten> {
        /// Facet edges passed at one place before it becomes a vertex, where
        /// the contour goes on by the walls alone: those round a corner of a
        /// tessellated wall.
        const MOST_TURNS: usize = 12;
        let stays = ahead <= self.lengths.tie;
        if pair == self.pair && stays {
            return Err(Shorten::Some);
        }
        self.turns = if stays { self.turns + 1 } else { 0 };
        if self.turns > MOST_TURNS {
            return Ok(Step::Stop(Stop::Node { fan, arrived, pair }));
        }
        self.travelled += fan.at.distance(self.x) + self.lengths.tie;
        self.x = fan.at;
        self.pair = pair;
        Ok(Step::Moved)
    }

    /// A branch point among facets of a curved wall, exact: within a tie the
    /// facet beside the right one would do. Gives the point for the facets that
    /// are nearest on their walls, if others than those given.
    fn polish(&self, at: DVec3, triple: [FaceId; 3]) -> Option<(DVec3, f64)> {
        let walls = self.probe.walls();
        let mut exact = at;
        let mut triple = triple;
        let mut changed = false;
        for _ in 0..8 {
            let settled = triple.map(|w| walls.settle(exact, w, CREASE_ANGLE));
            if settled == triple {
                break;
            }
            let conditions = [
                Condition::Tie(settled[0], settled[1]),
                Condition::Tie(settled[0], settled[2]),
                self.region.plane(),
            ];
            exact = solve(
                walls.field(),
                conditions,
                exact,
                POLISH * self.lengths.tie,
                self.lengths.solve,
            )?;
            triple = settled;
            changed = true;
        }
        changed.then(|| (exact, distance_to(walls.field(), exact, triple[0]).0))
    }

    /// Whether no wall is nearer to `y` than those of the pair.
    fn nearest_there(&mut self, y: DVec3, pair: Pair) -> bool {
        let d = distance_to(self.probe.field(), y, pair.left).0;
        self.probe.nearest(y, pair.left).distance >= d - self.lengths.tie
    }

    /// `pair` with `wall` in the place of a triangle that it shares its footpoint with.
    fn prefer(&self, at: DVec3, pair: Pair, wall: FaceId) -> Pair {
        let field = self.probe.field();
        let foot = field.footpoint_on(at, wall);
        let near = one_place(foot.distance, self.lengths.tie);
        let same = |f: FaceId| field.footpoint_on(at, f).point.distance(foot.point) <= near;
        Pair {
            left: if same(pair.left) { wall } else { pair.left },
            right: if same(pair.right) { wall } else { pair.right },
        }
    }
}
