//! Why files make no part.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

use super::balls::UnknownGroup;
use crate::coping::TagError;
use crate::io::{LoadedMesh, NoSolid, Place, ReadError};
use crate::mesh::PartError;
use crate::settings::cell::BadCell;
use crate::settings::memory::Bytes;
use crate::settings::quote::{figure, shown_path};
use crate::subdivide::CageError;

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
    /// A sag for what has its chords already.
    #[error("{}: --cad-sag is for CAD models", shown_path(.0))]
    #[diagnostic(help("leave --cad-sag away: a mesh has its chords already"))]
    NoCad(PathBuf),
    /// The sag of a CAD model is no length.
    #[error("{}: {problem}", shown_path(file))]
    #[diagnostic(help("give --cad-sag a length, or a share of the diagonal as 0.1%"))]
    Sag {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: BadCell,
    },
    /// The file has no such solid.
    #[error("{}: {problem}", shown_path(file))]
    #[diagnostic(forward(problem))]
    Solid {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: NoSolid,
    },
    /// The control mesh is none.
    #[error("{}: {problem}", place.within(file))]
    #[diagnostic(forward(problem))]
    Control {
        /// The file at fault.
        file: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong.
        problem: CageError,
    },
    /// A thickness was given to a name that the file does not have.
    #[error("{}: {problem}", shown_path(file))]
    #[diagnostic(forward(problem))]
    Group {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: UnknownGroup,
    },
    /// A mid-surface that is not the part's.
    #[error(
        "{}: does not belong to {}: its box is {} by its diagonal, that of the part {}",
        shown_path(file), shown_path(part), figure(*diagonal), figure(*whole)
    )]
    #[diagnostic(help("check that both are of one part, in one unit and one place"))]
    Foreign {
        /// The mid-surface.
        file: PathBuf,
        /// The part.
        part: PathBuf,
        /// Diagonal of the mid-surface's box.
        diagonal: f64,
        /// Diagonal of the part's.
        whole: f64,
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
