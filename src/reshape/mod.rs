//! Editing of marked meshes.
//!
//! * [`crease`]: cuts sheets where they bend at a fin left out.
//! * [`clean`]: contracts needles, moves nothing.
//! * [`uncut`]: both without triangles that pass through each other.
//! * [`remesh`](mod@remesh): towards an element size.
//! * [`project`]: back onto the exact mid-surface.
//! * [`written`]: the same for a mid-surface read from a file, with its part or
//!   without.

pub mod clean;
mod complex;
pub mod crease;
mod facets;
mod facing;
mod ground;
mod lines;
pub mod project;
pub mod remesh;
mod shape;
mod size;
pub mod uncut;
pub mod written;

use miette::Diagnostic;
use remesh::Junctions;
use serde::Serialize;
use thiserror::Error;

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

/// Elements so small that they would not fit into the memory allowed.
#[derive(Clone, Copy, Debug, PartialEq, Error, Diagnostic)]
#[error(
    "element size {size} needs about {elements:.0} triangles and {gigabytes:.1} GB; the smallest size that fits is about {smallest:.4}"
)]
#[diagnostic(help(
    "take a larger --element-size; raise --memory-limit if the machine has more memory"
))]
pub struct TooManyElements {
    /// Element size asked for.
    pub size: f64,
    /// Triangles that it would need.
    pub elements: f64,
    /// Memory that they would take.
    pub gigabytes: f64,
    /// Smallest size within the bound.
    pub smallest: f64,
}

/// Bytes that a triangle takes while it is edited, for the memory bound.
const BYTES_PER_TRIANGLE: f64 = 1_000.0;

/// Refuses elements that would not fit; how many there are is the area against
/// that of equilateral triangles.
pub(crate) fn fits(area: f64, size: f64, memory_limit: u64) -> Result<(), TooManyElements> {
    let elements = area / (0.433 * size * size);
    let bytes = elements * BYTES_PER_TRIANGLE;
    if bytes <= memory_limit as f64 {
        return Ok(());
    }
    Err(TooManyElements {
        size,
        elements,
        gigabytes: bytes / 1e9,
        smallest: size * (bytes / memory_limit as f64).sqrt() * 1.01,
    })
}
