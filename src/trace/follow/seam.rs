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

use super::contour::CREASE_ANGLE;
use super::fan::one_place;
use crate::mesh::FaceId;
use crate::trace::probe::Probe;
use crate::trace::solve::{Condition, distance_to, on_coping, solve};
use crate::trace::tolerances::{REACH, SHRINK, STRAIGHT, TINY, Tolerances};

/// A tetrahedron: where a curve may run.
#[derive(Clone, Copy, Debug)]
pub struct Cage {
    /// Corners.
    pub corners: [DVec3; 4],
    /// Unit normals of the faces, face `i` opposite corner `i`, inwards.
    pub inward: [DVec3; 4],
    /// Whether coping comes near.
    pub may_leave_part: bool,
}

impl Cage {
    /// A tetrahedron by its corners, which span space.
    pub fn new(corners: [DVec3; 4], may_leave_part: bool) -> Cage {
        let mut inward = [DVec3::ZERO; 4];
        for (i, normal) in inward.iter_mut().enumerate() {
            let [p, q, r] = Cage::face_corners(corners, i);
            let n = (q - p).cross(r - p).normalize_or_zero();
            *normal = if n.dot(corners[i] - p) < 0.0 { -n } else { n };
        }
        Cage {
            corners,
            inward,
            may_leave_part,
        }
    }

    fn face_corners(corners: [DVec3; 4], i: usize) -> [DVec3; 3] {
        match i {
            0 => [corners[1], corners[2], corners[3]],
            1 => [corners[0], corners[2], corners[3]],
            2 => [corners[0], corners[1], corners[3]],
            _ => [corners[0], corners[1], corners[2]],
        }
    }

    /// A corner on face `i`.
    pub fn on_face(&self, i: usize) -> DVec3 {
        self.corners[(i + 1) % 4]
    }

    /// Longest edge, roughly.
    pub fn size(&self) -> f64 {
        self.corners[0].distance(self.corners[3])
    }

    /// Low and high corner of the box round it.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let [a, b, c, d] = self.corners;
        (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }

    fn excess(&self, x: DVec3, but: usize) -> f64 {
        (0..4)
            .filter(|&i| i != but)
            .map(|i| -self.inward[i].dot(x - self.on_face(i)))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

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
    let field = probe.field();
    let u: SmallVec<[DVec3; 6]> = walls.iter().map(|&w| distance_to(field, x, w).1).collect();
    let mut best: Option<(f64, DVec3, [FaceId; 3])> = None;
    for i in 0..u.len() {
        for j in i + 1..u.len() {
            for k in j + 1..u.len() {
                let t = (u[j] - u[i]).cross(u[k] - u[i]);
                let size = t.length();
                if best.is_none_or(|b| size > b.0 * (1.0 + 1e-9)) {
                    best = Some((size, t, [walls[i], walls[j], walls[k]]));
                }
            }
        }
    }
    let (size, t, triple) = best?;
    (size > 1e-7).then(|| (t / size, triple))
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
    const MOST_STEPS: usize = 1000;
    let tolerances = probe.walls().tolerances();
    let (tie, tolerance) = (tolerances.tie, tolerances.solve);
    let size = cage.size();
    let lengths = Tolerances::new(tolerances, size);
    let mut length = size;
    let mut x = start;
    let mut last = towards;
    let mut first = true;
    let mut steps = 0;
    'step: while steps < MOST_STEPS && length >= lengths.shortest {
        steps += 1;
        let Some((mut t, mut triple)) = tangent(probe, x, walls) else {
            break;
        };
        if t.dot(last) < 0.0 {
            t = -t;
        }
        // The first face ahead.
        let mut exit = (usize::MAX, f64::INFINITY);
        for i in 0..4 {
            let speed = -cage.inward[i].dot(t);
            if speed > 1e-12 {
                let way = (cage.inward[i].dot(x - cage.on_face(i)) / speed).max(0.0);
                if way < exit.1 {
                    exit = (i, way);
                }
            }
        }
        let leaving = length >= exit.1;
        let stride = length.min(exit.1);
        let predicted = x + stride * t;
        let third = if leaving {
            Condition::plane(cage.inward[exit.0], cage.on_face(exit.0))
        } else {
            Condition::plane(t, predicted)
        };
        // Close before a face that the curve meets at a low angle, the step is
        // short and the way along the face is not.
        let reach = REACH * stride + TINY * size;
        let ties = [
            Condition::Tie(triple[0], triple[1]),
            Condition::Tie(triple[0], triple[2]),
        ];
        let Some(mut y) = solve(
            probe.field(),
            [ties[0], ties[1], third],
            predicted,
            reach,
            tolerance,
        ) else {
            length = stride * SHRINK;
            continue;
        };
        let slack = if leaving {
            lengths.outside
        } else {
            lengths.rounding
        };
        if cage.excess(y, if leaving { exit.0 } else { usize::MAX }) > slack {
            length = stride * SHRINK;
            continue;
        }
        let mut left_part = None;
        if cage.may_leave_part {
            let skip = if first && start_on_coping {
                lengths.same_point
            } else {
                0.0
            };
            if let Some((hit, coping)) = probe.coping_hit(x, y, skip) {
                let Some((at, coping)) =
                    on_coping(probe.field(), ties, hit, coping, 0.5 * size, tolerance)
                else {
                    length = stride * SHRINK;
                    continue;
                };
                if cage.excess(at, usize::MAX) > lengths.outside {
                    length = stride * SHRINK;
                    continue;
                }
                y = at;
                left_part = Some(coping);
            }
        }
        // Footpoints slide along their walls; the tie moves with them.
        let mut carried = walls.clone();
        for _ in 0..16 {
            let mut moved = false;
            for wall in carried.iter_mut() {
                let settled = probe.walls().settle(y, *wall, CREASE_ANGLE);
                moved |= settled != *wall;
                *wall = settled;
            }
            if !moved {
                break;
            }
            let again = tangent(probe, y, &carried).and_then(|(_, best)| {
                triple = best;
                let ties = [
                    Condition::Tie(best[0], best[1]),
                    Condition::Tie(best[0], best[2]),
                ];
                let third = match left_part {
                    Some(coping) => Condition::plane(
                        probe.field().normal(coping),
                        probe.field().corners(coping)[0],
                    ),
                    None => third,
                };
                solve(
                    probe.field(),
                    [ties[0], ties[1], third],
                    y,
                    reach,
                    tolerance,
                )
            });
            match again {
                Some(z) => y = z,
                None => {
                    length = stride * SHRINK;
                    continue 'step;
                }
            }
        }
        // Is another wall nearer?
        for _ in 0..64 {
            let (d, _) = distance_to(probe.field(), y, triple[0]);
            let foot = probe.nearest(y, triple[0]);
            if carried.contains(&foot.face) || foot.distance >= d - tolerance {
                break;
            }
            if let Some(k) = slides_for(probe, y, &carried, foot.face) {
                carried[k] = foot.face;
                let Some((_, best)) = tangent(probe, y, &carried) else {
                    length = stride * SHRINK;
                    continue 'step;
                };
                triple = best;
                let ties = [
                    Condition::Tie(triple[0], triple[1]),
                    Condition::Tie(triple[0], triple[2]),
                ];
                let third = match left_part {
                    Some(coping) => Condition::plane(
                        probe.field().normal(coping),
                        probe.field().corners(coping)[0],
                    ),
                    None => third,
                };
                match solve(
                    probe.field(),
                    [ties[0], ties[1], third],
                    y,
                    reach,
                    tolerance,
                ) {
                    Some(z) => y = z,
                    None => {
                        length = stride * SHRINK;
                        continue 'step;
                    }
                }
                continue;
            }
            if foot.distance >= d - tie {
                break;
            }
            // Over a long step a footpoint slides far and looks like a jump.
            if stride > 0.25 * d {
                length = stride * SHRINK;
                continue 'step;
            }
            match junction(probe, x, y, triple, foot.face, tie, tolerance) {
                Some((at, distance))
                    if cage.excess(at, usize::MAX) <= lengths.outside
                        && (at - x).dot(t) > -lengths.same_point =>
                {
                    // At a bend of a reflex edge the footpoint only moves on to the next edge.
                    let point = probe.field().footpoint_on(at, foot.face).point;
                    let near = one_place(distance, tie);
                    let same = carried.iter().position(|&w| {
                        probe.field().footpoint_on(at, w).point.distance(point) <= near
                    });
                    let Some(k) = same else {
                        return CurveStop::Junction { at, distance };
                    };
                    carried[k] = foot.face;
                    *walls = carried;
                    last = t;
                    x = at;
                    continue 'step;
                }
                _ => {
                    length = stride * SHRINK;
                    continue 'step;
                }
            }
        }
        // Over a long step walls that gave way to others may hide a junction.
        let turns =
            tangent(probe, y, &carried).is_none_or(|(next, _)| next.dot(t).abs() < STRAIGHT);
        if turns && left_part.is_none() && stride > TINY * size {
            length = stride * SHRINK;
            continue;
        }
        // Walls that tied at the start but do no more: the seam splits.
        let (d, _) = distance_to(probe.field(), y, triple[0]);
        for k in 0..carried.len() {
            if (distance_to(probe.field(), y, carried[k]).0 - d).abs() > 8.0 * tie {
                refresh(probe, y, d, &mut carried, k);
            }
            if (distance_to(probe.field(), y, carried[k]).0 - d).abs() > 8.0 * tie {
                length = stride * SHRINK;
                continue 'step;
            }
        }
        // A curve may bulge into the part where its chord does not.
        if cage.may_leave_part && left_part.is_none() && probe.is_outside(y) {
            length = stride * SHRINK;
            continue;
        }
        let beside = if leaving && left_part.is_none() {
            exit.0
        } else {
            usize::MAX
        };
        if cage.excess(y, beside) > lengths.outside {
            length = stride * SHRINK;
            continue;
        }
        *walls = carried;
        if let Some(coping) = left_part {
            return CurveStop::Coping { at: y, coping };
        }
        if leaving {
            return CurveStop::Face {
                face: exit.0,
                at: y,
            };
        }
        first = false;
        last = y - x;
        x = y;
        length *= 2.0;
    }
    CurveStop::Lost { at: x }
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

/// The point between `x` and `y` where `other` ties with the three walls.
fn junction(
    probe: &mut Probe,
    x: DVec3,
    y: DVec3,
    triple: [FaceId; 3],
    other: FaceId,
    tie: f64,
    tolerance: f64,
) -> Option<(DVec3, f64)> {
    let mut other = other;
    for _ in 0..16 {
        let field = probe.field();
        let lead = |p: DVec3| distance_to(field, p, other).0 - distance_to(field, p, triple[0]).0;
        let (g, h) = (lead(x), lead(y));
        let s = if g > h {
            (g / (g - h)).clamp(0.0, 1.0)
        } else {
            0.5
        };
        let conditions = [
            Condition::Tie(triple[0], triple[1]),
            Condition::Tie(triple[0], triple[2]),
            Condition::Tie(triple[0], other),
        ];
        let reach = 2.0 * x.distance(y) + 4.0 * tie;
        let at = solve(field, conditions, x.lerp(y, s), reach, tolerance)?;
        let d = distance_to(field, at, triple[0]).0;
        let foot = probe.nearest(at, other);
        if foot.distance >= d - tie {
            return Some((at, d.min(foot.distance)));
        }
        if foot.face == other {
            return None;
        }
        other = foot.face;
    }
    None
}
