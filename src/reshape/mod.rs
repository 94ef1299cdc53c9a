//! Editing of marked meshes.

pub mod clean;
