//! What every engine is told: how fine, with which numbers, within how much
//! memory, and whom to tell where it is; and what all tell: warnings, remedies.

pub mod cell;
pub mod memory;
pub mod precision;
pub mod progress;
pub mod quote;
pub mod remedy;
pub mod warning;
