//! The 3D follower of curves where three or more walls tie
//! (Bloomenthal 2011, section 4.2).
//!
//! The paper steps along the last tangent, intersects the sheets with a
//! transverse circle and averages the crossings of the chords. Here the step
//! returns to the tie of three walls by Newton's method in the transverse
//! plane, and every further wall that met at the start is carried along, so
//! that each sheet of the seam keeps its own pair of walls to the other end.

use glam::DVec3;
use smallvec::SmallVec;

use super::cage::Cage;
use super::fan::one_place;
use crate::mesh::FaceId;
use crate::trace::probe::Probe;
use crate::trace::solve::{Condition, distance_to, on_coping, solve};
use crate::trace::tolerances::{
    AHEAD, CREASE_ANGLE, DEPENDENT, REACH, SAFE_HOP, SHRINK, STRAIGHT, TINY, Tolerances,
};

/// How a curve ends inside or on a tetrahedron.
#[derive(Clone, Debug)]
pub enum CurveStop {
    /// On a face of the tetrahedron.
    Face {
        /// Which face.
        face: usize,
        /// Where.
        at: DVec3,
    },
    /// Out of the part through coping.
    Coping {
        /// Where.
        at: DVec3,
        /// The coping triangle.
        coping: FaceId,
    },
    /// A further wall ties.
    Junction {
        /// Where.
        at: DVec3,
        /// Distance of the walls there.
        distance: f64,
    },
    /// The follower could not go on.
    Lost {
        /// Where it gave up.
        at: DVec3,
    },
}

/// The walls of a curve; replaced by their neighbours as the footpoints slide.
pub type Walls = SmallVec<[FaceId; 6]>;

/// Unit direction of the curve on which `walls` tie at `x`, up to sign, with
/// the three of them that fix it best; `None` where they tie in a plane.
fn tangent(probe: &Probe, x: DVec3, walls: &[FaceId]) -> Option<(DVec3, [FaceId; 3])> {
    /// By how much a triple must be better than an earlier one: rounding does
    /// not choose.
    const BETTER: f64 = 1.0 + 1e-9;
    let field = probe.field();
    let u: SmallVec<[DVec3; 6]> = walls.iter().map(|&w| distance_to(field, x, w).1).collect();
    let mut best: Option<(f64, DVec3, [FaceId; 3])> = None;
    for i in 0..u.len() {
        for j in i + 1..u.len() {
            for k in j + 1..u.len() {
                let t = (u[j] - u[i]).cross(u[k] - u[i]);
                let size = t.length();
                if best.is_none_or(|b| size > b.0 * BETTER) {
                    best = Some((size, t, [walls[i], walls[j], walls[k]]));
                }
            }
        }
    }
    let (size, t, triple) = best?;
    (size > DEPENDENT).then(|| (t / size, triple))
}

/// Direction of the curve of `walls` at `x`, turned to the side of `towards`.
pub fn direction(probe: &Probe, x: DVec3, walls: &[FaceId], towards: DVec3) -> Option<DVec3> {
    let (t, _) = tangent(probe, x, walls)?;
    Some(if t.dot(towards) < 0.0 { -t } else { t })
}

/// Follows the curve on which `walls` tie from `start` towards `towards`.
/// `walls` are those at the end when it returns.
pub fn follow(
    probe: &mut Probe,
    cage: &Cage,
    start: DVec3,
    walls: &mut Walls,
    towards: DVec3,
    start_on_coping: bool,
) -> CurveStop {
    let size = cage.size();
    let lengths = Tolerances::new(probe.walls().tolerances(), size);
    let mut follower = Follower {
        probe,
        cage,
        size,
        lengths,
        x: start,
        walls: std::mem::take(walls),
        last: towards,
        on_coping: start_on_coping,
    };
    let stop = follower.run();
    *walls = follower.walls;
    stop
}

struct Follower<'p, 'a, 'c> {
    probe: &'p mut Probe<'a>,
    cage: &'c Cage,
    size: f64,
    lengths: Tolerances,
    x: DVec3,
    /// Walls that tie at `x`.
    walls: Walls,
    /// Heading of the last step.
    last: DVec3,
    /// Whether `x` is a start that lies on coping, which does not end the curve.
    on_coping: bool,
}

/// Outcome of one step.
enum Step {
    Stop(CurveStop),
    Moved,
    /// Round a bend of a wall's edge, which says nothing of the next step's length.
    Turned,
}

/// The way ahead: heading, and the first face on it.
struct Ahead {
    t: DVec3,
    stride: f64,
    /// The face where the step ends, if it reaches one.
    face: Option<usize>,
}

/// Where a step lands: a place that is still being moved as the footpoints
/// slide along their walls.
struct Landing {
    y: DVec3,
    walls: Walls,
    /// The three of the walls that fix the place best.
    triple: [FaceId; 3],
    /// The plane in which it is sought: across the curve, a face, or coping.
    plane: Condition,
    reach: f64,
    /// The coping triangle through which the curve leaves the part.
    coping: Option<FaceId>,
}

impl Landing {
    fn ties(&self) -> [Condition; 2] {
        let [a, b, c] = self.triple;
        [Condition::Tie(a, b), Condition::Tie(a, c)]
    }

    /// Moves to the tie of the walls as they are now.
    fn tie_again(&mut self, probe: &Probe, tolerance: f64) -> Option<()> {
        (_, self.triple) = tangent(probe, self.y, &self.walls)?;
        let [a, b] = self.ties();
        let conditions = [a, b, self.plane];
        self.y = solve(probe.field(), conditions, self.y, self.reach, tolerance)?;
        Some(())
    }

    fn distance(&self, probe: &Probe) -> f64 {
        distance_to(probe.field(), self.y, self.triple[0]).0
    }
}

impl Follower<'_, '_, '_> {
    fn run(&mut self) -> CurveStop {
        const MOST_STEPS: usize = 1000;
        let mut length = self.size;
        for _ in 0..MOST_STEPS {
            if length < self.lengths.shortest {
                break;
            }
            let Some((t, triple)) = tangent(self.probe, self.x, &self.walls) else {
                break;
            };
            let ahead = self.ahead(t, length);
            match self.step(&ahead, triple) {
                Some(Step::Stop(stop)) => return stop,
                Some(Step::Moved) => length *= 2.0,
                Some(Step::Turned) => {}
                None => length = ahead.stride * SHRINK,
            }
        }
        CurveStop::Lost { at: self.x }
    }

    /// The first face on the way along `t`, either way of which is the curve.
    fn ahead(&self, t: DVec3, length: f64) -> Ahead {
        let t = if t.dot(self.last) < 0.0 { -t } else { t };
        let (mut face, mut exit) = (None, f64::INFINITY);
        for i in 0..4 {
            let inward = self.cage.inward[i];
            let speed = -inward.dot(t);
            if speed > AHEAD {
                let way = (inward.dot(self.x - self.cage.on_face(i)) / speed).max(0.0);
                if way < exit {
                    (face, exit) = (Some(i), way);
                }
            }
        }
        Ahead {
            t,
            stride: length.min(exit),
            face: face.filter(|_| length >= exit),
        }
    }

    /// One step; `None` where it must be shorter.
    fn step(&mut self, ahead: &Ahead, triple: [FaceId; 3]) -> Option<Step> {
        let mut landing = self.land(ahead, triple)?;
        self.leave_part(&mut landing)?;
        self.settle(&mut landing)?;
        if let Some(step) = self.give_way(&mut landing, ahead)? {
            return Some(step);
        }
        self.accept(&mut landing, ahead)?;
        self.walls = landing.walls;
        let at = landing.y;
        if let Some(coping) = landing.coping {
            return Some(Step::Stop(CurveStop::Coping { at, coping }));
        }
        if let Some(face) = ahead.face {
            return Some(Step::Stop(CurveStop::Face { face, at }));
        }
        self.on_coping = false;
        self.last = at - self.x;
        self.x = at;
        Some(Step::Moved)
    }

    /// Predicts along the tangent and returns to the tie.
    fn land(&self, ahead: &Ahead, triple: [FaceId; 3]) -> Option<Landing> {
        let predicted = self.x + ahead.stride * ahead.t;
        let plane = match ahead.face {
            Some(i) => Condition::plane(self.cage.inward[i], self.cage.on_face(i)),
            None => Condition::plane(ahead.t, predicted),
        };
        let mut landing = Landing {
            y: predicted,
            walls: self.walls.clone(),
            triple,
            plane,
            // Close before a face that the curve meets at a low angle, the
            // step is short and the way along the face is not.
            reach: REACH * ahead.stride + TINY * self.size,
            coping: None,
        };
        let [a, b] = landing.ties();
        landing.y = solve(
            self.probe.field(),
            [a, b, plane],
            predicted,
            landing.reach,
            self.lengths.solve,
        )?;
        let slack = match ahead.face {
            Some(_) => self.lengths.outside,
            None => self.lengths.rounding,
        };
        (self.cage.excess(landing.y, ahead.face) <= slack).then_some(landing)
    }

    /// Stops the step at the coping that it passes, if any.
    fn leave_part(&mut self, landing: &mut Landing) -> Option<()> {
        if !self.cage.may_leave_part {
            return Some(());
        }
        let skip = if self.on_coping {
            self.lengths.same_point
        } else {
            0.0
        };
        let Some((hit, coping)) = self.probe.coping_hit(self.x, landing.y, skip) else {
            return Some(());
        };
        let field = self.probe.field();
        let ties = landing.ties();
        let (at, coping) = on_coping(
            field,
            ties,
            hit,
            coping,
            0.5 * self.size,
            self.lengths.solve,
        )?;
        if self.cage.excess(at, None) > self.lengths.outside {
            return None;
        }
        landing.y = at;
        landing.coping = Some(coping);
        landing.plane = Condition::plane(field.normal(coping), field.corners(coping)[0]);
        Some(())
    }

    /// Footpoints slide along their walls; the tie moves with them.
    fn settle(&self, landing: &mut Landing) -> Option<()> {
        const MOST_SLIDES: usize = 16;
        let walls = self.probe.walls();
        for _ in 0..MOST_SLIDES {
            let mut moved = false;
            for wall in landing.walls.iter_mut() {
                let settled = walls.settle(landing.y, *wall, CREASE_ANGLE);
                moved |= settled != *wall;
                *wall = settled;
            }
            if !moved {
                break;
            }
            landing.tie_again(self.probe, self.lengths.solve)?;
        }
        Some(())
    }

    /// Where another wall is nearer than those of the curve, one of them gives
    /// way to it, or the curve has passed a junction.
    fn give_way(&mut self, landing: &mut Landing, ahead: &Ahead) -> Option<Option<Step>> {
        const MOST_SLIDES: usize = 64;
        for _ in 0..MOST_SLIDES {
            let d = landing.distance(self.probe);
            let foot = self.probe.nearest(landing.y, landing.triple[0]);
            if landing.walls.contains(&foot.face) || foot.distance >= d - self.lengths.solve {
                break;
            }
            if let Some(k) = slides_for(self.probe, landing.y, &landing.walls, foot.face) {
                landing.walls[k] = foot.face;
                landing.tie_again(self.probe, self.lengths.solve)?;
                continue;
            }
            if foot.distance >= d - self.lengths.tie {
                break;
            }
            // Over a long step a footpoint slides far and looks like a jump.
            if ahead.stride > SAFE_HOP * d {
                return None;
            }
            return self.meet(landing, ahead, foot.face).map(Some);
        }
        Some(None)
    }

    /// A further wall came up on the way to the landing: a junction, unless its
    /// footpoint has only moved on to the next edge, round a bend of a reflex one.
    fn meet(&mut self, landing: &mut Landing, ahead: &Ahead, other: FaceId) -> Option<Step> {
        let (at, distance) = self.junction(landing, other)?;
        let back = (at - self.x).dot(ahead.t) <= -self.lengths.same_point;
        if back || self.cage.excess(at, None) > self.lengths.outside {
            return None;
        }
        let field = self.probe.field();
        let point = field.footpoint_on(at, other).point;
        let near = one_place(distance, self.lengths.tie);
        let same = (landing.walls.iter())
            .position(|&w| field.footpoint_on(at, w).point.distance(point) <= near);
        self.walls = std::mem::take(&mut landing.walls);
        let Some(k) = same else {
            // Those at the landing, or at the last step, may be some facets away.
            for wall in &mut self.walls {
                *wall = self.probe.walls().settle(at, *wall, CREASE_ANGLE);
            }
            return Some(Step::Stop(CurveStop::Junction { at, distance }));
        };
        self.walls[k] = other;
        self.last = ahead.t;
        self.x = at;
        Some(Step::Turned)
    }

    /// The point on the way to the landing where `other` ties with the walls
    /// of the curve, and their distance there.
    fn junction(&mut self, landing: &Landing, other: FaceId) -> Option<(DVec3, f64)> {
        const MOST_WALLS: usize = 16;
        let (x, y) = (self.x, landing.y);
        let [ab, ac] = landing.ties();
        let first = landing.triple[0];
        let mut other = other;
        for _ in 0..MOST_WALLS {
            let field = self.probe.field();
            let lead = |p: DVec3| distance_to(field, p, other).0 - distance_to(field, p, first).0;
            let (g, h) = (lead(x), lead(y));
            let s = if g > h {
                (g / (g - h)).clamp(0.0, 1.0)
            } else {
                0.5
            };
            let conditions = [ab, ac, Condition::Tie(first, other)];
            let reach = 2.0 * x.distance(y) + self.lengths.same_point;
            let at = solve(field, conditions, x.lerp(y, s), reach, self.lengths.solve)?;
            let d = distance_to(field, at, first).0;
            let foot = self.probe.nearest(at, other);
            if foot.distance >= d - self.lengths.tie {
                return Some((at, d.min(foot.distance)));
            }
            if foot.face == other {
                return None;
            }
            other = foot.face;
        }
        None
    }

    /// Whether the curve may go to the landing in one step.
    fn accept(&mut self, landing: &mut Landing, ahead: &Ahead) -> Option<()> {
        let (probe, y) = (&mut *self.probe, landing.y);
        // Over a long step walls that gave way to others may hide a junction.
        let turns = tangent(probe, y, &landing.walls)
            .is_none_or(|(next, _)| next.dot(ahead.t).abs() < STRAIGHT);
        if turns && landing.coping.is_none() && ahead.stride > TINY * self.size {
            return None;
        }
        // Walls that tied at the start but do no more: the seam splits.
        let d = landing.distance(probe);
        let parted = self.lengths.parted;
        for k in 0..landing.walls.len() {
            let off = |probe: &Probe, wall| (distance_to(probe.field(), y, wall).0 - d).abs();
            if off(probe, landing.walls[k]) > parted {
                refresh(probe, y, d, &mut landing.walls, k);
            }
            if off(probe, landing.walls[k]) > parted {
                return None;
            }
        }
        // A curve may bulge into the part where its chord does not.
        if self.cage.may_leave_part && landing.coping.is_none() && probe.is_outside(y) {
            return None;
        }
        let beside = ahead.face.filter(|_| landing.coping.is_none());
        (self.cage.excess(y, beside) <= self.lengths.outside).then_some(())
    }
}

/// Lets wall `k`, no longer tied at `y`, slide to the tied wall that continues it.
fn refresh(probe: &mut Probe, y: DVec3, distance: f64, walls: &mut Walls, k: usize) {
    let was = probe.field().footpoint_on(y, walls[k]);
    let mut feet = std::mem::take(&mut probe.feet);
    feet.clear();
    probe
        .field()
        .footpoints_within(y, distance + probe.walls().tolerances().tie, &mut feet);
    let next = feet
        .iter()
        .filter(|f| !walls.contains(&f.face) && probe.walls().slides(&was, f))
        .min_by(|a, b| {
            a.point
                .distance(was.point)
                .total_cmp(&b.point.distance(was.point))
        });
    if let Some(foot) = next {
        walls[k] = foot.face;
    }
    probe.feet = feet;
}

/// Which of the walls the nearer triangle continues, if any.
fn slides_for(probe: &Probe, y: DVec3, walls: &[FaceId], nearer: FaceId) -> Option<usize> {
    let field = probe.field();
    let foot = field.footpoint_on(y, nearer);
    let u = (y - foot.point).normalize_or_zero();
    let cosine = CREASE_ANGLE.to_radians().cos();
    let mut best: Option<(f64, usize)> = None;
    for (k, &wall) in walls.iter().enumerate() {
        let was = field.footpoint_on(y, wall);
        let bend = (y - was.point).normalize_or_zero().dot(u);
        if bend >= cosine && best.is_none_or(|b| bend > b.0) && probe.walls().slides(&was, &foot) {
            best = Some((bend, k));
        }
    }
    best.map(|b| b.1)
}
