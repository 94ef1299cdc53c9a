//! The ball inside the part that touches a wall at a given point and another
//! wall elsewhere: its centre is where the mid-surface should be.
//!
//! Shrinking ball of Ma, Bae and Choi, "3D medial axis point approximation using
//! nearest neighbors and the normal field" (2012), on triangles in place of
//! points.

use glam::DVec3;

use crate::field::{Field, Footpoint, Hit};

/// Rounds at most; a handful is usual.
const ROUNDS: usize = 40;

/// A ball that shrinks by less than this share has come to rest.
const AT_REST: f64 = 1e-9;

/// Two feet seen from the centre under a smaller angle, degrees, lie on one
/// smooth wall: the facets of its tessellation are no wall of their own.
const ONE_WALL: f64 = 15.0;

/// A ball that touches two walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touching {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    /// Where it touches the other wall.
    pub(super) other: Footpoint,
}

/// The ball at `foot`, on the side that `inward`, a unit vector, points to;
/// none where no wall is across.
pub(super) fn touching(
    field: &Field,
    foot: &Footpoint,
    inward: DVec3,
    hits: &mut Vec<Hit>,
) -> Option<Touching> {
    let (low, high) = field.bounds();
    let far = foot.point + inward * (high - low).length();
    field.hits(foot.point, far, hits);
    let across = hits.iter().find(|hit| {
        !field.is_coping(hit.face)
            && hit.face != foot.face
            && field.normal(hit.face).dot(inward) > 1e-6
    })?;
    let mut radius = 0.5 * across.t * (far - foot.point).length();
    let mut other = Footpoint {
        face: across.face,
        point: foot.point.lerp(far, across.t),
        distance: radius,
    };
    let one_wall = ONE_WALL.to_radians();
    for _ in 0..ROUNDS {
        let centre = foot.point + radius * inward;
        let near = field.footpoint_near(centre, other.face);
        let chord = near.point - foot.point;
        let next = chord.length_squared() / (2.0 * chord.dot(inward));
        let at_rest = !(next > 0.0 && next < radius * (1.0 - AT_REST));
        if at_rest || (foot.point - centre).angle_between(near.point - centre) < one_wall {
            break;
        }
        (radius, other) = (next, near);
    }
    let centre = foot.point + radius * inward;
    (radius > 0.0).then_some(Touching {
        centre,
        radius,
        other: Footpoint {
            distance: centre.distance(other.point),
            ..other
        },
    })
}
