//! The contour followers (Bloomenthal 2011, section 4).
//!
//! * [`contour`]: the 2D follower, in a [`region`]: the plane of a tetrahedron
//!   face or of a coping triangle.
//! * [`seam`]: the 3D follower of curves where three or more walls tie: seams,
//!   and the fading borders that end in the centre of a round; in a [`cage`].
//! * [`border`]: the 3D follower of coping borders, which is the 2D follower
//!   walking from one coping triangle to the next.
//! * [`fan`]: what leaves a point where walls tie: the circle of footpoint
//!   tests of the paper (in 3D a sphere), taken to the limit of radius zero.
//!
//! [`face`] makes of contours all that one face holds, [`refine`] where a
//! follower was lost on it.
//!
//! All of them step along a predicted tangent, return to the tie by Newton's
//! method ([`super::solve`]) and then ask the field once whether a nearer wall has
//! come up. The paper samples transverse segments and circles of finite size
//! instead; a tie solved to rounding needs no size to choose, and a wall that
//! comes up between two samples cannot be jumped over unseen as long as the
//! footpoints stay on the same two triangles, which are convex.

pub mod border;
pub mod cage;
mod close;
pub mod contour;
pub mod face;
pub mod fan;
mod refine;
pub mod region;
pub mod seam;
#[cfg(test)]
mod tests;
