//! A tetrahedron, as the 3D followers see it.

use glam::DVec3;

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

    /// How far outside `x` lies, at most (negative inside); one face may be
    /// left out.
    pub(in crate::trace) fn excess(&self, x: DVec3, but: Option<usize>) -> f64 {
        (0..4)
            .filter(|&i| Some(i) != but)
            .map(|i| -self.inward[i].dot(x - self.on_face(i)))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}
