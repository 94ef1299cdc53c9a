//! Editing of marked meshes.
//!
//! * [`crease`]: cuts sheets where they bend at a fin left out.
//! * [`clean`]: contracts needles, moves nothing.
//! * [`remesh`](mod@remesh): towards an element size.
//! * [`project`]: back onto the exact mid-surface.

pub mod clean;
mod complex;
pub mod crease;
mod facing;
mod lines;
pub mod project;
pub mod remesh;
mod shape;
mod size;

use remesh::Junctions;
use serde::Serialize;

use crate::settings::cell::{BadCell, CellSize, Scale};

/// Elements that a shell model wants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ElementSettings {
    /// Edge length.
    pub size: CellSize,
    /// How far edges may run beside a curved wall.
    pub sag: CellSize,
    /// Growth of edges away from fine places, by length.
    pub grading: f64,
    /// Whether triangles pair to quadrilaterals.
    pub quads: bool,
    /// How sheets run where they meet.
    pub junctions: Junctions,
}

impl ElementSettings {
    /// Elements of a size, all else by default.
    pub fn of_size(size: CellSize) -> ElementSettings {
        ElementSettings {
            size,
            sag: CellSize::Thicknesses(remesh::Settings::SAG),
            grading: remesh::Settings::GRADING,
            quads: false,
            junctions: Junctions::Medial,
        }
    }

    /// The same as lengths.
    ///
    /// # Errors
    ///
    /// As [`CellSize::resolve`].
    pub fn resolve(&self, scale: &Scale) -> Result<remesh::Settings, BadCell> {
        Ok(remesh::Settings {
            size: self.size.resolve(scale)?,
            sag: self.sag.resolve(scale)?,
            grading: self.grading,
            quads: self.quads,
            junctions: self.junctions,
        })
    }
}
