//! Points where walls are equally far: the one numeric kernel of all followers.
//!
//! Everything the followers look for is a point with three conditions, each a
//! tie between two walls or a plane: a contour step (tie, face, cross-plane), a
//! branch point (two ties, face), a seam step (two ties, cross-plane), a
//! junction (three ties), the end of a seam (two ties, coping plane). The
//! distance to a triangle has a continuous gradient, so Newton's method serves.

use glam::{DMat3, DVec3};

use crate::field::Field;
use crate::mesh::FaceId;
use crate::trace::tolerances::{DEPENDENT, ON_TRIANGLE, SAME_DIRECTION};

/// One condition on a point.
#[derive(Clone, Copy, Debug)]
pub enum Condition {
    /// Equally far from two wall triangles.
    Tie(FaceId, FaceId),
    /// In the plane `normal . x = offset`, `normal` of unit length.
    Plane(DVec3, f64),
}

impl Condition {
    /// The plane through a point.
    pub fn plane(normal: DVec3, through: DVec3) -> Condition {
        Condition::Plane(normal, normal.dot(through))
    }
}

/// Distance from `p` to one triangle, with its gradient.
pub fn distance_to(field: &Field, p: DVec3, face: FaceId) -> (f64, DVec3) {
    let foot = field.footpoint_on(p, face);
    (foot.distance, (p - foot.point).normalize_or_zero())
}

/// Solves three conditions from `start`; gives up (`None`) where they are
/// nearly dependent, do not converge, or lead farther than `reach` away.
pub fn solve(
    field: &Field,
    conditions: [Condition; 3],
    start: DVec3,
    reach: f64,
    tolerance: f64,
) -> Option<DVec3> {
    const STEPS: usize = 40;
    let mut x = start;
    for _ in 0..STEPS {
        let mut rows = [DVec3::ZERO; 3];
        let mut rest = DVec3::ZERO;
        for (k, condition) in conditions.iter().enumerate() {
            let (value, gradient) = match *condition {
                Condition::Tie(a, b) => {
                    let ((da, ua), (db, ub)) = (distance_to(field, x, a), distance_to(field, x, b));
                    (da - db, ua - ub)
                }
                Condition::Plane(normal, offset) => (normal.dot(x) - offset, normal),
            };
            let length = gradient.length();
            if length < SAME_DIRECTION {
                return None;
            }
            rows[k] = gradient / length;
            rest[k] = -value / length;
        }
        let matrix = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
        if matrix.determinant().abs() < DEPENDENT {
            return None;
        }
        let step = matrix.inverse() * rest;
        x += step;
        if !x.is_finite() || x.distance(start) > reach {
            return None;
        }
        if step.length() <= tolerance {
            return Some(x);
        }
    }
    None
}

/// The point of a contour or curve (two conditions) on the coping, starting
/// from a guess near triangle `coping`, with the triangle that it lies on;
/// `None` as for [`solve`].
pub fn on_coping(
    field: &Field,
    conditions: [Condition; 2],
    near: DVec3,
    coping: FaceId,
    reach: f64,
    tolerance: f64,
) -> Option<(DVec3, FaceId)> {
    let (mut at, mut coping) = (near, coping);
    for _ in 0..8 {
        let third = Condition::plane(field.normal(coping), field.corners(coping)[0]);
        at = solve(
            field,
            [conditions[0], conditions[1], third],
            at,
            reach,
            tolerance,
        )?;
        let slip = field.footpoint_on(at, coping).distance;
        if slip <= ON_TRIANGLE * reach + tolerance {
            break;
        }
        // Beyond the triangle's edge: the neighbour that is nearer, if it is coping too.
        match field.nearest_coping(at, 2.0 * slip) {
            Some(next) if next.face != coping && next.distance < slip => coping = next.face,
            _ => break,
        }
    }
    Some((at, coping))
}

/// Where walls `a` and `b` are equally far on the segment `from..to`, `a`
/// being the nearer one at `from` and `b` at `to`: safeguarded Newton on the
/// difference of distances. Returns the parameter in 0..=1.
pub fn tie_on_segment(
    field: &Field,
    from: DVec3,
    to: DVec3,
    a: FaceId,
    b: FaceId,
    tolerance: f64,
) -> f64 {
    let way = to - from;
    let length = way.length();
    let (mut low, mut high) = (0.0, 1.0);
    let value = |s: f64| {
        let x = from + s * way;
        let ((da, ua), (db, ub)) = (distance_to(field, x, a), distance_to(field, x, b));
        (da - db, (ua - ub).dot(way))
    };
    let mut s = {
        let (at_low, at_high) = (value(0.0).0, value(1.0).0);
        if at_low >= 0.0 {
            return 0.0;
        }
        if at_high <= 0.0 {
            return 1.0;
        }
        at_low / (at_low - at_high)
    };
    for _ in 0..80 {
        let (g, slope) = value(s);
        if g < 0.0 {
            low = s;
        } else {
            high = s;
        }
        if g == 0.0 || (high - low) * length <= tolerance {
            break;
        }
        let newton = s - g / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - s).abs() * length <= 0.25 * tolerance {
            return next;
        }
        s = next;
    }
    s
}
