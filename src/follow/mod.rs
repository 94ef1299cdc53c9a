//! The contour followers (Bloomenthal 2011, section 4).
//!
//! * [`contour`]: the 2D follower, in the plane of a tetrahedron face or of a
//!   coping triangle.
//! * [`seam`]: the 3D follower of curves where three or more walls tie: seams,
//!   and the fading borders that end in the centre of a round.
//! * [`border`]: the 3D follower of coping borders, which is the 2D follower
//!   walking from one coping triangle to the next.
//! * [`fan`]: what leaves a point where walls tie: the circle of footpoint
//!   tests of the paper (in 3D a sphere), taken to the limit of radius zero.
//!
//! All of them step along a predicted tangent, return to the tie by Newton's
//! method ([`solve`]) and then ask the field once whether a nearer wall has
//! come up. The paper samples transverse segments and circles of finite size
//! instead; a tie solved to rounding needs no size to choose, and a wall that
//! comes up between two samples cannot be jumped over unseen as long as the
//! footpoints stay on the same two triangles, which are convex.

pub mod border;
pub mod contour;
pub mod face;
pub mod fan;
pub mod seam;
pub mod solve;

use glam::DVec3;

use crate::field::walls::Walls;
use crate::field::{Field, Footpoint};
use crate::mesh::FaceId;

/// Two walls that tie, ordered: whoever walks the contour has `left` nearest
/// on the left hand and `right` on the right, seen from the tip of the
/// plane's normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    /// Wall triangle nearest on the left.
    pub left: FaceId,
    /// Wall triangle nearest on the right.
    pub right: FaceId,
}

impl Pair {
    /// The same pair for a walk the other way.
    pub fn reversed(self) -> Pair {
        Pair {
            left: self.right,
            right: self.left,
        }
    }
}

/// The field as one thread uses it: shared walls, a count and scratch space.
pub struct Probe<'a> {
    walls: &'a Walls<'a>,
    queries: u64,
    pub(crate) feet: Vec<Footpoint>,
    pub(crate) hits: Vec<crate::field::Hit>,
}

impl<'a> Probe<'a> {
    /// A probe with nothing counted.
    pub fn new(walls: &'a Walls<'a>) -> Probe<'a> {
        Probe {
            walls,
            queries: 0,
            feet: Vec::new(),
            hits: Vec::new(),
        }
    }

    /// Closest-point queries so far.
    pub fn queries(&self) -> u64 {
        self.queries
    }

    /// The walls asked.
    pub fn walls(&self) -> &'a Walls<'a> {
        self.walls
    }

    /// The field asked.
    pub fn field(&self) -> &'a Field {
        self.walls.field()
    }

    /// Nearest wall point; counted.
    pub fn nearest(&mut self, p: DVec3, hint: FaceId) -> Footpoint {
        self.queries += 1;
        self.walls.field().footpoint_near(p, hint)
    }

    /// Nearest wall point without a guess; counted.
    pub fn nearest_anywhere(&mut self, p: DVec3) -> Footpoint {
        self.queries += 1;
        self.walls.field().footpoint(p)
    }

    /// Whether a point lies outside the part by more than a tie: nothing there
    /// is ever followed.
    pub fn is_outside(&self, x: DVec3) -> bool {
        self.field().signed_clearance(x) < -self.walls.tolerances().tie
    }

    /// Whether the pair still makes a mid-surface at `x`.
    pub fn separate(&self, x: DVec3, a: FaceId, b: FaceId) -> bool {
        let field = self.field();
        self.walls
            .separate(x, &field.footpoint_on(x, a), &field.footpoint_on(x, b))
    }

    /// First place where the segment meets coping, away from its start by more
    /// than `skip`; with the coping triangle.
    pub fn coping_hit(&mut self, from: DVec3, to: DVec3, skip: f64) -> Option<(DVec3, FaceId)> {
        let field = self.walls.field();
        let length = from.distance(to);
        let mut hits = std::mem::take(&mut self.hits);
        hits.clear();
        field.hits(from, to, &mut hits);
        let found = hits
            .iter()
            .find(|h| field.is_coping(h.face) && h.t * length > skip)
            .map(|h| (from + h.t * (to - from), h.face));
        self.hits = hits;
        found
    }
}
