//! The lengths by which the walk decides, each with one name and one value.
//!
//! Neighbours must answer *is this the same point?* alike, or a crack opens
//! between them; so nobody makes a length of his own.

use crate::walls;

/// Shrink of a step that failed: two and a half tries halve it twice.
pub const SHRINK: f64 = 0.4;

/// How far the corrector may lead from the prediction, in steps: a curve
/// that bends by 30 degrees in a step leaves its tangent by 0.27 of it.
pub const REACH: f64 = 0.3;

/// Cosine of the largest bend of a step: 30 degrees.
pub const STRAIGHT: f64 = 0.85;

/// Cosine of the widest angle between two directions that may be the same
/// contour, seen from a vertex: 60 degrees.
pub const SAME_WAY: f64 = 0.5;

/// Largest step at a vertex, of the size of the region, that is short enough
/// to bend as it likes.
pub const TINY: f64 = 1e-3;

/// Lengths in part units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Newton steps and roots stop here.
    pub solve: f64,
    /// Distances that differ by less are tied.
    pub tie: f64,
    /// Points closer than this are one: each of two ways to it may be off by
    /// a tie, to either side. Independent of the cell, so that edge, face and
    /// tetrahedron agree.
    pub same_point: f64,
    /// Shortest step of a follower, below which it gives up: within it, walls
    /// are told apart by rounding.
    pub shortest: f64,
    /// How far beyond a side of its region a point counts as on it: solving
    /// on the side's plane leaves a thousand times less.
    pub outside: f64,
    /// How far outside a point may be by rounding alone.
    pub rounding: f64,
}

impl Tolerances {
    /// For a region (a face, a tetrahedron) of a size.
    pub fn new(walls: walls::Tolerances, size: f64) -> Tolerances {
        let same_point = 4.0 * walls.tie;
        Tolerances {
            solve: walls.solve,
            tie: walls.tie,
            same_point,
            shortest: (1e-6 * size).max(same_point),
            outside: 1e-9 * size,
            rounding: 1e-12 * size,
        }
    }
}
