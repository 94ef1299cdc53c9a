//! Numbers of a precision, seen from a frame.

use glam::DVec3;

use crate::mesh::Frame;
use crate::settings::precision::Precision;

/// Coordinates, in a frame, of the points that will be written: they have the
/// numbers of a precision once they are moved out of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    precision: Precision,
    frame: Frame,
}

impl Numbers {
    /// Of a precision, in a frame.
    pub fn new(precision: Precision, frame: Frame) -> Numbers {
        Numbers { precision, frame }
    }

    /// Which numbers are written.
    pub fn precision(self) -> Precision {
        self.precision
    }

    /// The frame.
    pub fn frame(self) -> Frame {
        self.frame
    }

    /// The nearest point allowed.
    pub fn round_point(self, p: DVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| self.round(axis, p[axis])))
    }

    pub(super) fn round(self, axis: usize, x: f64) -> f64 {
        self.through_world(axis, x, |x| self.precision.round(x))
    }

    /// The nearest number allowed that is greater than one allowed.
    pub(super) fn above(self, axis: usize, x: f64) -> f64 {
        self.through_world(axis, x, |x| self.precision.above(x))
    }

    /// The nearest number allowed that is less than one allowed.
    pub(super) fn below(self, axis: usize, x: f64) -> f64 {
        self.through_world(axis, x, |x| self.precision.below(x))
    }

    /// Whether numbers between two planes may be few.
    pub(super) fn are_sparse(self, axis: usize) -> bool {
        self.precision == Precision::Single || self.frame.origin()[axis] != 0.0
    }

    fn through_world(self, axis: usize, x: f64, f: impl Fn(f64) -> f64) -> f64 {
        let origin = self.frame.origin()[axis];
        if origin == 0.0 {
            f(x)
        } else {
            f(x + origin) - origin
        }
    }
}

impl From<Precision> for Numbers {
    fn from(precision: Precision) -> Numbers {
        Numbers::new(precision, Frame::default())
    }
}
