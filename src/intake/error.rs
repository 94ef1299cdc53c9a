//! Why files make no part.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

use crate::coping::TagError;
use crate::io::quote::shown_path;
use crate::io::{LoadedMesh, Place, ReadError};
use crate::mesh::PartError;
use crate::settings::memory::Bytes;

/// Why files make no part.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum IntakeError {
    /// The mesh cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Read(#[from] ReadError),
    /// The tags cannot be read, or do not fit the mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Tags(#[from] TagError),
    /// The mesh with its tags is no part.
    #[error("{}: {problem}", place.within(file))]
    #[diagnostic(forward(problem))]
    Part {
        /// The file at fault.
        file: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong.
        problem: PartError,
    },
    /// The file would not fit into the memory left.
    #[error(
        "{}: reading needs about {needed}, and {left} are left; a file of {fitting} would fit",
        shown_path(file)
    )]
    #[diagnostic(help("take a machine with more memory, or coarsen the mesh"))]
    Memory {
        /// The file.
        file: PathBuf,
        /// What reading it takes at the peak.
        needed: Bytes,
        /// What the system still gives.
        left: Bytes,
        /// The largest file for which that is enough.
        fitting: Bytes,
    },
}

impl IntakeError {
    /// A mesh file that is no part: at the facet that the problem names.
    pub(super) fn in_mesh(file: &Path, loaded: &LoadedMesh, problem: PartError) -> IntakeError {
        let triangle = problem.triangle();
        IntakeError::Part {
            file: file.to_owned(),
            place: triangle.map_or(Place::Whole, |triangle| loaded.place_of(triangle)),
            problem,
        }
    }
}
