//! Units of the trees: the part, shrunk to about one and moved to the origin, so
//! that single precision serves for bounds.

use glam::DVec3;

/// Part units to tree units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub centre: DVec3,
    /// Power of two: multiplying by it is exact.
    pub scale: f64,
}

impl Frame {
    /// Frame of the box `low..high`; any finite frame for an empty box.
    pub fn new(low: DVec3, high: DVec3) -> Frame {
        let centre = (low + high) * 0.5;
        let half = (high - low).max_element() * 0.5;
        if !centre.is_finite() || !half.is_finite() {
            return Frame {
                centre: DVec3::ZERO,
                scale: 1.0,
            };
        }
        let exponent = half.max(1e-290).log2().ceil();
        Frame {
            centre,
            scale: (-exponent).exp2(),
        }
    }

    #[inline]
    pub fn to_tree(self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }
}
