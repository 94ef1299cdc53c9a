//! Mid-surface of a thin-wall part.
pub mod assembly;
pub mod cli;
pub mod extract;
pub mod field;
pub mod follow;
pub mod io;
pub mod lattice;
pub mod mesh;
pub mod tags;
pub mod vertices;
