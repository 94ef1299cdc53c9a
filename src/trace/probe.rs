//! The field as one thread asks it.

use glam::DVec3;

use crate::field::{Field, Footpoint};
use crate::mesh::FaceId;
use crate::trace::solve::Condition;
use crate::walls::Walls;

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

    /// The condition that both are equally far.
    pub fn tie(self) -> Condition {
        Condition::Tie(self.left, self.right)
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

    /// Nearest wall point, and the distance to the nearest triangle of any
    /// kind, negative outside; counted once.
    pub fn nearest_and_clearance(&mut self, p: DVec3, hint: FaceId) -> (Footpoint, f64) {
        self.queries += 1;
        self.walls.field().cleared_footpoint_near(p, hint)
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

    /// First place where the segment leaves the part through coping, away from
    /// its start by more than `skip`; with the coping triangle.
    pub fn coping_hit(&mut self, from: DVec3, to: DVec3, skip: f64) -> Option<(DVec3, FaceId)> {
        let field = self.walls.field();
        let length = from.distance(to);
        let mut hits = std::mem::take(&mut self.hits);
        hits.clear();
        field.hits(from, to, &mut hits);
        let found = hits
            .iter()
            .find(|h| {
                field.is_coping(h.face)
                    && h.t * length >= skip
                    && field.normal(h.face).dot(to - from) > 0.0
            })
            .map(|h| (from + h.t * (to - from), h.face));
        self.hits = hits;
        found
    }
}
