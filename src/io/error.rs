//! Why a mesh file could not be read: where, what, and what to do.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use miette::Diagnostic;
use thiserror::Error;

use crate::settings::quote::{bounded, quoted, shown, shown_path};

/// Place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// Line, counted from 1.
    Line(u64),
    /// Byte offset, counted from 0.
    Byte(u64),
}

impl Place {
    /// The place in words, after the file's name.
    pub fn within(self, file: &Path) -> String {
        let file = shown_path(file);
        match self {
            Place::Whole => file,
            Place::Line(line) => format!("{file}, line {line}"),
            Place::Byte(byte) => format!("{file}, byte {byte}"),
        }
    }
}

/// What is wrong with a file.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum Problem {
    /// The system refused.
    #[error("cannot be read: {0}")]
    #[diagnostic(help("check the path, the spelling of the name and the permissions"))]
    Io(#[source] io::Error),
    /// A folder or the like.
    #[error("is not a file")]
    #[diagnostic(help("name a mesh file"))]
    NotAFile,
    /// Suffix of no known format.
    #[error("has no suffix of a known mesh format")]
    #[diagnostic(help(
        "use a mesh as .obj, .stl, .ply, .off, .3mf, .glb, .gltf, .msh, .inp or .bdf, or a CAD model as .step, .iges or .brep"
    ))]
    UnknownFormat,
    /// A CAD file, and nothing that could mesh it.
    #[error("CAD files are meshed by Gmsh, which was not found")]
    #[diagnostic(help(
        "install it with `pip install gmsh` or `apt-get install gmsh`, or name the program in the environment variable GMSH"
    ))]
    NoMesher,
    /// Gmsh gave no mesh; its last words.
    #[error("Gmsh made no mesh of it: {0}")]
    #[diagnostic(help("check the model in the CAD system, or export it as a fine STL"))]
    MesherFailed(String),
    /// Suffix of a format that cannot hold a control mesh, or of none.
    #[error("a control mesh is read from OBJ alone")]
    #[diagnostic(help("export the control mesh, not its subdivision, as polygons in .obj"))]
    NoControlFormat,
    /// More than is read.
    #[error("has more than {most} bytes, the most that are read")]
    #[diagnostic(help("check that this is the right file; raise --max-input if it is"))]
    TooLarge {
        /// The bound.
        most: u64,
    },
    /// The memory is not to be had.
    #[error("does not fit into memory: {bytes} bytes more were not to be had")]
    #[diagnostic(help("take a machine with more memory; coarsen the mesh"))]
    Memory {
        /// Asked for.
        bytes: u64,
    },
    /// No bytes.
    #[error("the file is empty")]
    #[diagnostic(help("export or download the file again"))]
    Empty,
    /// A web page, an archive, a pointer to elsewhere.
    #[error("this is {0}, not a mesh")]
    #[diagnostic(help("download the raw file, unpack it, or rename it to its true suffix"))]
    Foreign(&'static str),
    /// Ended before its time.
    #[error("the file ends too early: {0}")]
    #[diagnostic(help("the file is damaged or was cut in transfer: export or copy it again"))]
    Truncated(String),
    /// A count that the size of the file contradicts.
    #[error("the file claims {claimed} {what}, but {reason}")]
    #[diagnostic(help("the file is damaged or was cut in transfer: export or copy it again"))]
    LyingCount {
        /// What is counted.
        what: &'static str,
        /// The claim.
        claimed: u64,
        /// Why it cannot be.
        reason: String,
    },
    /// A word that should be a number.
    #[error("{} is not a number", quoted(word))]
    #[diagnostic(help("write numbers with a decimal point and no thousands separators"))]
    NotANumber {
        /// The word.
        word: String,
    },
    /// NaN, an infinity, or beyond the range of the arithmetic.
    #[error("the coordinate {} is not a finite number", shown(word))]
    #[diagnostic(help("repair the vertex in the tool that wrote the file"))]
    NotFinite {
        /// The word or value.
        word: String,
    },
    /// A word that should be a vertex index.
    #[error("{} is not a vertex index", quoted(word))]
    #[diagnostic(help("write whole numbers, as in `f 1 2 3` or `f 1/1/1 2/2/1 3/3/1`"))]
    NotAnIndex {
        /// The word.
        word: String,
    },
    /// A vertex index out of range.
    #[error("vertex {index} does not exist: the file has {vertices} vertices{}", if *relative { " up to here" } else { "" })]
    #[diagnostic(help("export the file again; a cut or hand-edited file often misses vertices"))]
    IndexOutOfRange {
        /// The index as written.
        index: i64,
        /// Vertices of the file, or up to here for a relative index.
        vertices: usize,
        /// Whether the index counts backwards.
        relative: bool,
    },
    /// A facet of fewer than three corners.
    #[error("a face needs three corners, this one has {corners}")]
    #[diagnostic(help("remove the face or complete it"))]
    FewCorners {
        /// Corners given.
        corners: usize,
    },
    /// A polygon too large to triangulate here.
    #[error("a face with {corners} corners is too large to be triangulated")]
    #[diagnostic(help("export the mesh as triangles"))]
    ManyCorners {
        /// Corners given.
        corners: usize,
    },
    /// No facets in the file.
    #[error("the file holds no faces{}", if *vertices > 0 { ", only points" } else { "" })]
    #[diagnostic(help("export the surface mesh, not points or curves"))]
    NoFaces {
        /// Points found.
        vertices: usize,
    },
    /// More than the index type can number.
    #[error("more than 4294967294 {0}")]
    #[diagnostic(help("split or coarsen the mesh"))]
    TooMany(&'static str),
    /// The grammar of the format is broken.
    #[error("{}", bounded(.0))]
    #[diagnostic(help("export the file again, or correct it at this place"))]
    Syntax(String),
}

/// Why a mesh file could not be read.
#[derive(Debug)]
pub struct ReadError {
    file: PathBuf,
    place: Place,
    problem: Problem,
}

impl ReadError {
    pub(crate) fn new(file: &Path, (place, problem): Located) -> ReadError {
        ReadError {
            file: file.to_owned(),
            place,
            problem,
        }
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Where in the file.
    pub fn place(&self) -> Place {
        self.place
    }

    /// What is wrong.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place.within(&self.file), self.problem)
    }
}

impl std::error::Error for ReadError {}

impl Diagnostic for ReadError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.problem.help()
    }
}

/// A problem and its place, before the file's name is added.
pub(crate) type Located = (Place, Problem);
