//! Back onto the exact mid-surface: guesses near sheets and lines become points
//! with solved footpoints.
//!
//! A point of a sheet is found along the sheet's own normal, which is the
//! gradient of the difference of the two wall distances (Newton's method on
//! one tie). It counts only if no other wall is nearer there and the two walls
//! are separate, as everywhere in the tracing. Where the tie leads astray,
//! beside bends and seams, the largest ball through each of the footpoints
//! decides (shrinking ball: Ma, Bae and Choi 2012).

use glam::DVec3;
use smallvec::SmallVec;

use crate::mesh::FaceId;
use crate::surface::marked::{Line, MarkedVertex};
use crate::trace::solve::{Condition, distance_to, on_coping, solve};
use crate::trace::tolerances::CREASE_ANGLE;
use crate::walls::Walls;
use crate::walls::thickness::Ray;

/// Steps of Newton's method on one tie; near a solution three suffice.
const STEPS: usize = 16;

/// Walls whose footpoint directions differ by less have no tie between them.
const PARTED: f64 = 1e-3;

/// A wall nearer by more than this share of the distance refutes a tie; the
/// share by which single-precision facets are off.
const NEARER: f64 = 1e-6;

/// Puts points back onto the mid-surface of a part.
pub struct Projector<'a> {
    walls: &'a Walls<'a>,
}

impl<'a> Projector<'a> {
    /// Of the part that the walls belong to.
    pub fn new(walls: &'a Walls<'a>) -> Projector<'a> {
        Projector { walls }
    }

    /// The walls asked.
    pub fn walls(&self) -> &'a Walls<'a> {
        self.walls
    }

    /// The point of a sheet nearest to a guess, at most `reach` away. `hints`
    /// are walls of vertices near by.
    pub fn on_sheet(&self, guess: DVec3, hints: &[FaceId], reach: f64) -> Option<MarkedVertex> {
        let gap = |v: &MarkedVertex| v.at.distance(guess);
        let settled = self.settled(guess, hints);
        let mut best: Option<MarkedVertex> = None;
        for (n, &a) in settled.iter().enumerate() {
            for &b in &settled[..n] {
                if let Some(found) = self.tie(guess, a, b, reach)
                    && best.as_ref().is_none_or(|b| gap(&found) < gap(b))
                {
                    best = Some(found);
                }
            }
        }
        best.or_else(|| {
            let nearest = self.walls.field().footpoint(guess).face;
            (settled.into_iter().chain([nearest])).find_map(|face| self.ball(guess, face, reach))
        })
    }

    /// The centre of the largest ball that touches the wall of `face` where
    /// `guess` has its footpoint there.
    fn ball(&self, guess: DVec3, face: FaceId, reach: f64) -> Option<MarkedVertex> {
        let field = self.walls.field();
        let foot = field.footpoint_on(guess, face);
        let ray = Ray {
            from: foot.point,
            direction: (guess - foot.point).normalize_or_zero(),
            radius: 0.0,
            growth: 1.0,
        };
        let (centre, touch) = ray.ball(field, face)?;
        // Solved to rounding by the tie of the two.
        let found = self.tie(centre, face, touch.face, reach)?;
        (found.at.distance(guess) <= reach).then_some(found)
    }

    /// The triangles with the footpoints of `x` on the walls hinted at, one
    /// for each place.
    fn settled(&self, x: DVec3, hints: &[FaceId]) -> SmallVec<[FaceId; 6]> {
        let field = self.walls.field();
        let mut found: SmallVec<[FaceId; 6]> = SmallVec::new();
        let mut feet: SmallVec<[DVec3; 6]> = SmallVec::new();
        for &hint in hints {
            let face = self.walls.settle(x, hint, CREASE_ANGLE);
            let foot = field.footpoint_on(x, face);
            let same = 1e-3 * foot.distance;
            if !found.contains(&face) && feet.iter().all(|f| f.distance(foot.point) > same) {
                found.push(face);
                feet.push(foot.point);
            }
        }
        found
    }

    /// The point along the sheet's normal where two walls are equally far.
    fn tie(&self, guess: DVec3, a: FaceId, b: FaceId, reach: f64) -> Option<MarkedVertex> {
        let field = self.walls.field();
        let tolerance = self.walls.tolerances().solve;
        let (mut x, mut pair) = (guess, [a, b]);
        for step in 0..STEPS {
            let [(da, ua), (db, ub)] = pair.map(|face| distance_to(field, x, face));
            let gradient = ua - ub;
            let square = gradient.length_squared();
            if square < PARTED * PARTED {
                return None;
            }
            let way = (db - da) / square * gradient;
            x += way;
            if !x.is_finite() || x.distance(guess) > reach {
                return None;
            }
            if way.length() <= tolerance {
                let settled = pair.map(|face| self.walls.settle(x, face, CREASE_ANGLE));
                if settled == pair {
                    return self.checked(x, &pair);
                }
                pair = settled;
            } else if step % 4 == 3 {
                pair = pair.map(|face| self.walls.settle(x, face, CREASE_ANGLE));
            }
        }
        None
    }

    /// The vertex at `x` if its walls tie, are nearest, and the first two of
    /// them are separate.
    fn checked(&self, x: DVec3, walls: &[FaceId]) -> Option<MarkedVertex> {
        let field = self.walls.field();
        let feet: SmallVec<[_; 4]> = walls.iter().map(|&f| field.footpoint_on(x, f)).collect();
        let (first, rest) = feet.split_first()?;
        let least = feet.iter().fold(f64::INFINITY, |d, f| d.min(f.distance));
        let slack = NEARER * least + 2.0 * self.walls.tolerances().tie;
        let nearest = field.footpoint_near(x, first.face).distance;
        let separate = rest.iter().any(|f| self.walls.separate(x, first, f));
        (nearest >= least - slack && separate).then(|| MarkedVertex {
            at: x,
            walls: SmallVec::from_slice(walls),
            coping: None,
        })
    }

    /// The point of a line in the plane through `guess` across `along`, at
    /// most `reach` away. A fading border has no exact place within its sheet:
    /// of it the point of the sheet nearest to the guess.
    pub fn on_line(
        &self,
        line: Line,
        guess: DVec3,
        along: DVec3,
        hints: &MarkedVertex,
        reach: f64,
    ) -> Option<MarkedVertex> {
        let field = self.walls.field();
        let tolerance = self.walls.tolerances().solve;
        let across = Condition::plane(along, guess);
        let settled = self.settled(guess, &hints.walls);
        match line {
            Line::CopingBorder => {
                let coping = hints.coping?;
                for k in 1..settled.len() {
                    for j in 0..k {
                        let [a, b] = [settled[j], settled[k]];
                        let ties = [Condition::Tie(a, b), across];
                        if let Some((at, coping)) =
                            on_coping(field, ties, guess, coping, reach, tolerance)
                            && let Some(found) = self.checked_near(at, &[a, b])
                        {
                            let coping = Some(coping);
                            return Some(MarkedVertex { coping, ..found });
                        }
                    }
                }
                None
            }
            Line::Seam | Line::Crease => {
                for k in 2..settled.len() {
                    for j in 1..k {
                        for i in 0..j {
                            let [a, b, c] = [i, j, k].map(|n| settled[n]);
                            let ties = [Condition::Tie(a, b), Condition::Tie(b, c), across];
                            if let Some(at) = solve(field, ties, guess, reach, tolerance)
                                && let Some(found) = self.checked_near(at, &[a, b, c])
                            {
                                return Some(found);
                            }
                        }
                    }
                }
                None
            }
            Line::FadingBorder | Line::Sheet => self.on_sheet(guess, &hints.walls, reach),
        }
    }

    /// As [`checked`](Self::checked), the walls settled first: a solution may
    /// lie over a neighbour of the triangle that it was solved for.
    fn checked_near(&self, x: DVec3, walls: &[FaceId]) -> Option<MarkedVertex> {
        let settled = self.settled(x, walls);
        (settled.len() == walls.len())
            .then(|| self.checked(x, &settled))
            .flatten()
    }

    /// Unit normal of the sheet at `x` between two walls, from the first
    /// towards the second.
    pub fn normal(&self, x: DVec3, a: FaceId, b: FaceId) -> DVec3 {
        let field = self.walls.field();
        (distance_to(field, x, a).1 - distance_to(field, x, b).1).normalize_or_zero()
    }
}
