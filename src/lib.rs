//! Mid-surface of a thin-wall part.
pub mod field;
pub mod io;
pub mod mesh;
pub mod tags;
