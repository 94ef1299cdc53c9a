//! What every engine is told: how fine, how much memory, and whom to tell
//! where it is.

pub mod memory;
pub mod progress;
