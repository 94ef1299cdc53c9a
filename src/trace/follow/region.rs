//! Where a contour may run: a convex polygon in a plane, and what ends it there.

use glam::DVec3;
use smallvec::SmallVec;

use crate::mesh::FaceId;
use crate::trace::solve::Condition;

/// A convex polygon in a plane: where a contour may run.
#[derive(Clone, Debug)]
pub struct Region {
    /// Unit normal; corners run counter-clockwise round it.
    pub normal: DVec3,
    /// Corners; side `i` joins corner `i` and `i + 1`.
    pub corners: SmallVec<[DVec3; 8]>,
    /// What ends contours inside the polygon besides its sides.
    pub barrier: Barrier,
    /// Vertices known to lie inside, where contours stop: those through which
    /// a 3D follower came.
    pub stations: Vec<DVec3>,
}

/// What ends a contour inside a region.
#[derive(Clone, Debug)]
pub enum Barrier {
    /// Nothing: coping is far.
    None,
    /// Coping triangles, where the contour leaves the part.
    Coping,
    /// Segments in the plane with their inside on the left: the outline of
    /// the flat patch of coping that a border runs on.
    Fences(Vec<Fence>),
}

/// A segment of an outline.
#[derive(Clone, Copy, Debug)]
pub struct Fence {
    /// From here.
    pub from: DVec3,
    /// To there.
    pub to: DVec3,
    /// Coping triangle inside the outline.
    pub face: FaceId,
    /// Its edge that the segment is.
    pub edge: usize,
}

/// The place where a contour meets a barrier.
#[derive(Clone, Copy, Debug)]
pub enum Exit {
    /// Through this coping triangle.
    Coping(FaceId),
    /// Through this fence, by number.
    Fence(usize),
}

impl Region {
    /// A polygon through its corners; `None` where they have no area.
    pub fn new(corners: SmallVec<[DVec3; 8]>, barrier: Barrier) -> Option<Region> {
        let mut area = DVec3::ZERO;
        for k in 1..corners.len().saturating_sub(1) {
            area += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]);
        }
        let normal = area.try_normalize()?;
        Some(Region {
            normal,
            corners,
            barrier,
            stations: Vec::new(),
        })
    }

    pub(super) fn plane(&self) -> Condition {
        Condition::plane(self.normal, self.corners[0])
    }

    /// Ends of side `i`.
    pub fn side(&self, i: usize) -> (DVec3, DVec3) {
        (self.corners[i], self.corners[(i + 1) % self.corners.len()])
    }

    /// Unit normal of side `i`, in the plane, towards the inside.
    pub fn inward(&self, i: usize) -> DVec3 {
        let (p, q) = self.side(i);
        self.normal.cross(q - p).normalize_or_zero()
    }

    pub(super) fn diameter(&self) -> f64 {
        let mut d: f64 = 0.0;
        for a in &self.corners {
            for b in &self.corners {
                d = d.max(a.distance(*b));
            }
        }
        d
    }

    /// How far outside `x` lies, at most (negative inside).
    pub(super) fn excess(&self, x: DVec3) -> f64 {
        (0..self.corners.len())
            .map(|i| -self.inward(i).dot(x - self.corners[i]))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
