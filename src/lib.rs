//! Mid-surface of a thin-wall part.
pub mod mesh;
pub mod field;
