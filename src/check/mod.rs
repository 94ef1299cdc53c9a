//! What a result fails to do, held against the part.
//!
//! * [`Check`]: a mid-surface of any origin, measured against its part.
//! * [`closed_over`]: coping faces that no border reached.
//! * [`missed`]: faces that were not tagged, before which a sheet ends.

mod against_part;
mod ball;
mod bends;
pub mod closed_over;
mod measures;
pub mod missed;
#[cfg(test)]
mod tests;

pub use against_part::{Check, Limits};
pub use measures::{Defect, LEAST_ANGLE, Measure, Outcome};
