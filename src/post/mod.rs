//! From the raw mesh to the result: clean-up, then sheets, seams and borders.

pub mod clean;
pub mod graph;
pub mod listing;
mod sets;
