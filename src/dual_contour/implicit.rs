//! What is contoured: a solid given by a function.

use glam::DVec3;

/// What the function is at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Negative inside the solid, part units.
    pub value: f64,
    /// Unit direction in which `value` grows fastest; outward at the surface.
    pub gradient: DVec3,
    /// A bound that needs no side: `value` is at least this far from zero. The
    /// bounding box filter of the offset works with it.
    pub unsigned: f64,
    /// The element that decided the value.
    pub element: u32,
}

/// A solid as the zero set of a function that changes by at most the distance
/// walked (where it has a step, that is found if a node beside it is near the
/// surface; the contour is closed in any case), and that is, near its surface, everywhere that of the nearest of a
/// number of *elements* (the triangles of a part, say).
///
/// Answers depend on the arguments alone, whatever the hint.
pub trait Implicit: Sync {
    /// The function at `p`; `hint` is an element likely near the answer.
    fn sample(&self, p: DVec3, hint: u32) -> Sample;

    /// The function of one element alone: value and unit gradient.
    ///
    /// Smooth where [`sample`](Implicit::sample) has a crease.
    fn element(&self, p: DVec3, element: u32) -> (f64, DVec3);

    /// The element, if any, that takes another's place where the function and
    /// that other element vanish, because the other, though zero there by
    /// itself, is no part of the surface: more than `tolerance` inside the one
    /// that covers it, or hidden behind it.
    ///
    /// In a plain union none ever is. But a union that is cut off, or the
    /// common part of several solids, has a value of zero all over the cut, and
    /// an element that ends somewhere behind it makes no crease there.
    fn covered(&self, _p: DVec3, _element: u32, _tolerance: f64) -> Option<u32> {
        None
    }

    /// Changes elements that are to meet near `p` for those that stand for them
    /// there: where a union is cut off, the member of it that met the edge of
    /// a cell need not reach the crease at all.
    fn stand_in(&self, _p: DVec3, _elements: &mut [u32]) {}

    /// Where the surface crosses the segment between two samples of opposite
    /// sides. `samples[0]` is at `ends[0]`.
    fn crossing(&self, ends: [DVec3; 2], samples: [Sample; 2]) -> Crossing;
}

/// Where the surface crosses a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Fraction of the way.
    pub t: f64,
    /// Element that decides there.
    pub element: u32,
    /// Halvings of the segment that it took; see Table V of the paper.
    pub splits: u8,
    /// Closest-point queries that it took.
    pub queries: u32,
}
