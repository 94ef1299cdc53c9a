//! Editing of marked meshes.

pub mod clean;
mod complex;
pub mod crease;
mod lines;
pub mod project;
mod shape;
