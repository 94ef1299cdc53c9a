//! What a result fails to do, held against the part.

pub mod closed_over;
