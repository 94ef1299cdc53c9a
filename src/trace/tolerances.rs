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

/// How far a contour may lie off its chord, in chords: it bends by at most
/// twice 30 degrees in a step.
pub const SAGITTA: f64 = REACH;

/// Object angle, degrees, below which two walls that a contour passes between
/// are facets of one curved wall: the contour bends by less than half of it
/// and gets no vertex of its own.
pub const CREASE_ANGLE: f64 = 20.0;

/// What unit gradients must span, as a length, an area or a volume, to fix a
/// direction: a tie is then found to within ten million times what distances
/// are off by, which is less than a tie is allowed.
pub const DEPENDENT: f64 = 1e-7;

/// Difference of two unit gradients below which they are one: no tie changes there.
pub const SAME_DIRECTION: f64 = 1e-9;

/// How far off the triangle, in reaches, a point solved in its plane may lie:
/// a hundred times less than [`OUTSIDE`].
pub const ON_TRIANGLE: f64 = 1e-11;

/// Cosine from which on a side or a face lies ahead: less is rounding.
pub const AHEAD: f64 = 1e-12;

/// How far aside of the heading, in strides, a known vertex may lie that a step aims at.
pub const BESIDE: f64 = 0.05;

/// Steps by which nothing that stands between two walls is jumped over, in
/// distances of the walls: where the footpoints leave their triangles, up to
/// the ball itself, a little more so that a step of one ball is one.
pub const BALL_HOP: f64 = 1.01;

/// As [`BALL_HOP`], where a footpoint may look like a jump that only slides far.
pub const SAFE_HOP: f64 = 0.25;

/// As [`BALL_HOP`], so short that a thin web between shows.
pub const SHORT_HOP: f64 = 0.05;

/// How far beyond a side, in sizes of it, a point counts as on it: solving on
/// the side's plane leaves a thousand times less.
pub const OUTSIDE: f64 = 1e-9;

/// Places on a segment that are one, in lengths of it: hits of triangles that
/// share an edge.
pub const SAME_HIT: f64 = 1e-12;

/// How far a branch point may move, in ties, when its facets are taken exactly.
pub const POLISH: f64 = 64.0;

/// Lengths in part units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Newton steps and roots stop here.
    pub solve: f64,
    /// What stands between two walls on an edge is decided to here, as exactly
    /// as the distances are known (two solver steps), so that the faces round
    /// the edge find the same.
    pub decided: f64,
    /// Distances that differ by less are tied.
    pub tie: f64,
    /// Distances of two solved walls that differ by more were not solved: a
    /// hundredth of a tie, far above rounding.
    pub solved_tie: f64,
    /// Distances that differ by more have parted, after a tie: each may be
    /// off by some ties where walls meet at a low angle.
    pub parted: f64,
    /// Points closer than this are one: each of two ways to it may be off by
    /// a tie, to either side. Independent of the cell, so that edge, face and
    /// tetrahedron agree.
    pub same_point: f64,
    /// How near a step that aims at a known vertex must land.
    pub station: f64,
    /// Shortest step of a follower, below which it gives up: within it, walls
    /// are told apart by rounding.
    pub shortest: f64,
    /// How far beyond a side of its region a point counts as on it.
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
            decided: 2.0 * walls.solve,
            tie: walls.tie,
            solved_tie: 0.01 * walls.tie,
            parted: 8.0 * walls.tie,
            same_point,
            station: 1e-6 * size + same_point,
            shortest: (1e-6 * size).max(same_point),
            outside: OUTSIDE * size,
            rounding: 1e-12 * size,
        }
    }
}
