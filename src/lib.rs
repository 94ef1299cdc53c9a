//! Mid-surface of a thin-wall part.

// A library neither prints nor gives up.
#![warn(clippy::print_stdout, clippy::print_stderr)]
#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod assembly;
pub mod extract;
pub mod field;
pub mod follow;
pub mod io;
pub mod lattice;
pub mod mesh;
pub mod post;
pub mod tags;
pub mod trace;
pub mod vertices;
