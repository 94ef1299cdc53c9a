//! A local frame for meshes far from the origin.
//!
//! A ship's frame or a building's panel has coordinates a thousand times its
//! own size, and sums and products of those lose as many digits. An engine that
//! takes such a mesh works on it about an origin nearby, and moves its result
//! back.

use std::borrow::Cow;

use glam::DVec3;

use super::{Bounds, Part, TriMesh};

/// Diagonals of its box that a mesh may lie from the origin, along an axis, and
/// still be worked on where it is.
const NEAR: f64 = 16.0;

/// Axes moved so that a mesh lies near the origin.
///
/// Along an axis on which the box's middle is farther than some diagonals from
/// zero, the origin is a multiple of a power of two about the diagonal; on other
/// axes it is zero, so that a mesh near the origin is not touched at all.
/// Coordinates in the box and around it are within a factor of two of such an
/// origin, so [`Frame::to_local`] is exact (Sterbenz, 1974), and
/// [`Frame::to_world`] of it gives the same bits again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    origin: DVec3,
}

impl Frame {
    /// The frame for all that lies in a box.
    pub fn around(bounds: &Bounds) -> Frame {
        let diagonal = bounds.diagonal();
        let step = diagonal.log2().ceil().exp2();
        let origin = bounds.center().to_array().map(|middle| {
            let origin = (middle / step).round() * step;
            if middle.abs() > NEAR * diagonal && origin.is_finite() {
                origin
            } else {
                0.0
            }
        });
        Frame {
            origin: DVec3::from_array(origin),
        }
    }

    /// The frame's origin, part units.
    pub fn origin(self) -> DVec3 {
        self.origin
    }

    /// Whether nothing moves.
    pub fn is_identity(self) -> bool {
        self.origin == DVec3::ZERO
    }

    /// A point of the part in the frame.
    pub fn to_local(self, p: DVec3) -> DVec3 {
        p - self.origin
    }

    /// A point in the frame in the part's own coordinates.
    pub fn to_world(self, p: DVec3) -> DVec3 {
        p + self.origin
    }

    /// Moves points into the frame.
    pub fn enter<'a>(self, points: impl IntoIterator<Item = &'a mut DVec3>) {
        if !self.is_identity() {
            points.into_iter().for_each(|p| *p = self.to_local(*p));
        }
    }

    /// Moves points out of the frame.
    pub fn leave<'a>(self, points: impl IntoIterator<Item = &'a mut DVec3>) {
        if !self.is_identity() {
            points.into_iter().for_each(|p| *p = self.to_world(*p));
        }
    }
}

impl TriMesh {
    /// The mesh in a frame.
    pub fn in_frame(&self, frame: Frame) -> Cow<'_, TriMesh> {
        if frame.is_identity() {
            return Cow::Borrowed(self);
        }
        let mut mesh = self.clone();
        frame.enter(&mut mesh.positions);
        Cow::Owned(mesh)
    }
}

impl Part {
    /// The part in a frame.
    pub fn in_frame(&self, frame: Frame) -> Cow<'_, Part> {
        if frame.is_identity() {
            return Cow::Borrowed(self);
        }
        let mut part = self.clone();
        frame.enter(&mut part.mesh.positions);
        Cow::Owned(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube_at(at: DVec3) -> Bounds {
        Bounds::of([at, at + DVec3::ONE])
    }

    #[test]
    fn near_the_origin_nothing_moves() {
        for at in [DVec3::ZERO, DVec3::splat(-20.0), DVec3::new(0.0, 25.0, 3.0)] {
            assert!(Frame::around(&cube_at(at)).is_identity(), "{at}");
        }
        assert!(Frame::around(&Bounds::EMPTY).is_identity());
    }

    #[test]
    fn only_far_axes_move() {
        let frame = Frame::around(&cube_at(DVec3::new(0.3, 4e5, -70.0)));
        assert_eq!(frame.origin().x, 0.0);
        assert_eq!(frame.origin().y, 4e5);
        assert_eq!(frame.origin().z, -70.0);
    }

    #[test]
    fn there_and_back_is_exact() {
        for scale in [1e-20, 1.0, 1e20] {
            for far in [31.0, 1e3 / 3.0, -1e6 / 7.0, 1e14 / 3.0] {
                let at = scale * DVec3::new(far, -3.0 * far, 0.7 * far);
                let corners = [at, at + scale * DVec3::new(1.0, 0.1, 0.7)];
                let frame = Frame::around(&Bounds::of(corners));
                assert!(!frame.is_identity());
                for i in 0..100 {
                    let p = corners[0].lerp(corners[1], f64::from(i) / 99.0);
                    let local = frame.to_local(p);
                    assert!(local.abs().max_element() < 3.0 * scale, "{local}");
                    assert_eq!(frame.to_world(local), p);
                    // Exact: the difference says so too.
                    assert_eq!(frame.to_world(local) - p, DVec3::ZERO);
                }
            }
        }
    }
}
