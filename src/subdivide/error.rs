//! What is wrong with a control mesh, and why there is no solid.

use miette::Diagnostic;
use thiserror::Error;

use super::{MOST_LEVELS, MOST_POINTS, Scheme, Trial, tried};

/// Why polygons are no control mesh. Faces and vertices count from 0.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum CageError {
    /// Nothing to subdivide.
    #[error("the control mesh has no faces")]
    #[diagnostic(help("export the faces of the control mesh, not points or curves"))]
    Empty,
    /// NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is no finite number")]
    #[diagnostic(help("repair the vertex in the tool that wrote the file"))]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {vertex}, which does not exist")]
    #[diagnostic(help("export the control mesh again"))]
    NoSuchVertex {
        /// The face.
        face: usize,
        /// The vertex.
        vertex: usize,
    },
    /// A face of one or two corners.
    #[error("face {face} has fewer than three corners")]
    #[diagnostic(help("remove the face, or give it three or more corners, each once"))]
    FewCorners {
        /// The face.
        face: usize,
    },
    /// A face runs over a vertex twice.
    #[error("face {face} has vertex {vertex} at two of its corners")]
    #[diagnostic(help("remove the face, or give it three or more corners, each once"))]
    RepeatedCorner {
        /// The face.
        face: usize,
        /// The vertex.
        vertex: usize,
    },
    /// More than two faces at an edge.
    #[error(
        "the edge between vertices {from} and {to} has more than two faces: {first}, {second}, {face}"
    )]
    #[diagnostic(help("remove inner or doubled faces at that edge"))]
    CrowdedEdge {
        /// The face that is one too many.
        face: usize,
        /// A face there before.
        first: usize,
        /// The other face there before.
        second: usize,
        /// One end.
        from: usize,
        /// The other end.
        to: usize,
    },
    /// Two neighbours run over their edge in the same direction.
    #[error(
        "faces {other} and {face} run over their edge from vertex {from} to {to} in the same direction"
    )]
    #[diagnostic(help(
        "turn one of the two over; most modelling tools can make normals consistent"
    ))]
    Inconsistent {
        /// The later face.
        face: usize,
        /// The earlier one.
        other: usize,
        /// Start of the edge.
        from: usize,
        /// Its end.
        to: usize,
    },
    /// Pieces that hang together at a vertex only.
    #[error(
        "the faces around vertex {vertex} do not hang together by edges: face {face} is one of another piece"
    )]
    #[diagnostic(help("give each piece a vertex of its own there, or join the pieces by an edge"))]
    Pinched {
        /// A face of a piece beyond the first.
        face: usize,
        /// The vertex.
        vertex: usize,
    },
    /// A vertex of no face.
    #[error("vertex {vertex} belongs to no face")]
    #[diagnostic(help("remove loose vertices in the modelling tool"))]
    Isolated {
        /// The vertex.
        vertex: usize,
    },
    /// A crease on no edge.
    #[error("crease tag {tag} names the edge between vertices {from} and {to}, which no face has")]
    #[diagnostic(help("tags count vertices from 0; name both ends of an edge, or remove the tag"))]
    NoSuchEdge {
        /// Number of the tag.
        tag: usize,
        /// One end.
        from: u32,
        /// The other.
        to: u32,
    },
    /// A sharp vertex that is none.
    #[error("corner tag {tag} names vertex {vertex}, which does not exist")]
    #[diagnostic(help("tags count vertices from 0; correct or remove the tag"))]
    NoSuchCorner {
        /// Number of the tag.
        tag: usize,
        /// The vertex.
        vertex: u32,
    },
    /// A hole that is no face.
    #[error("hole tag {tag} names face {face}, which does not exist")]
    #[diagnostic(help("tags count faces from 0; correct or remove the tag"))]
    NoSuchHole {
        /// Number of the tag.
        tag: usize,
        /// The face.
        face: u32,
    },
    /// A wall without thickness.
    #[error("the thickness at vertex {vertex} is not a positive length")]
    #[diagnostic(help("give every group a positive thickness"))]
    BadShare {
        /// The vertex.
        vertex: usize,
    },
    /// Nothing is left.
    #[error("all faces are holes, or lie at a boundary that is cut away")]
    #[diagnostic(help("remove hole tags, or take --boundary corner or edge"))]
    AllHoles,
    /// Holes leave faces that meet at a vertex alone.
    #[error("holes leave faces that meet at vertex {vertex} alone")]
    #[diagnostic(help("make one hole of those that touch there, or move them apart"))]
    PinchedHole {
        /// The vertex.
        vertex: usize,
    },
    /// More than can be numbered.
    #[error("{corners} face corners are too many")]
    #[diagnostic(help("subdivide fewer times, or start from a coarser mesh"))]
    TooLarge {
        /// Corners asked for.
        corners: usize,
    },
}

impl CageError {
    /// The face that the error names.
    pub fn face(&self) -> Option<usize> {
        match *self {
            CageError::NoSuchVertex { face, .. }
            | CageError::FewCorners { face }
            | CageError::RepeatedCorner { face, .. }
            | CageError::CrowdedEdge { face, .. }
            | CageError::Inconsistent { face, .. }
            | CageError::Pinched { face, .. } => Some(face),
            _ => None,
        }
    }

    /// The vertex that the error names, where it names no face.
    pub fn vertex(&self) -> Option<usize> {
        match *self {
            CageError::NotFinite { vertex }
            | CageError::Isolated { vertex }
            | CageError::BadShare { vertex }
            | CageError::PinchedHole { vertex } => Some(vertex),
            _ => None,
        }
    }
}

/// Why there is no solid.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum SubdivideError {
    /// The control mesh is none, or grew too large.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Cage(#[from] CageError),
    /// No positive length.
    #[error("the thickness {0} is not a positive length")]
    #[diagnostic(help("give --thickness a positive length"))]
    Thickness(f64),
    /// A wall with nothing of the mesh's size.
    #[error(
        "a wall of {thickness} is out of all proportion to a control mesh with a diagonal of {diagonal:.6}"
    )]
    #[diagnostic(help("give --thickness in the units of the control mesh"))]
    Thick {
        /// Asked for.
        thickness: f64,
        /// Of the control mesh.
        diagonal: f64,
    },
    /// No positive length.
    #[error("the tolerance {0} is not a positive length")]
    #[diagnostic(help("give --tolerance a positive length"))]
    Tolerance(f64),
    /// None, or too many.
    #[error(
        "{samples} samples a side on {faces} faces: one is the least, {MOST_POINTS} points in all the most"
    )]
    #[diagnostic(help("take fewer --samples or --levels"))]
    Samples {
        /// Steps along a side.
        samples: usize,
        /// Faces at the level.
        faces: usize,
    },
    /// More memory than is allowed.
    #[error(
        "{samples} samples at level {level} need about {needed:.1} GB, and {allowed:.1} GB are allowed; {fit} samples would fit"
    )]
    #[diagnostic(help(
        "take fewer --samples or --levels; raise --memory-limit if the machine has more memory"
    ))]
    Memory {
        /// Steps along a side.
        samples: usize,
        /// The level.
        level: u32,
        /// Gigabytes that they take.
        needed: f64,
        /// Gigabytes allowed.
        allowed: f64,
        /// Steps along a side that would fit.
        fit: usize,
    },
    /// Too many steps.
    #[error("{0} subdivision steps are more than {MOST_LEVELS}")]
    #[diagnostic(help("take fewer --samples or --levels"))]
    Levels(u32),
    /// A part of the mesh has no normal: all its vertices coincide, or lie on a
    /// line.
    #[error("the surface has no normal at vertex {vertex} of level {level}, nor around it")]
    #[diagnostic(help("remove the parts of the control mesh that have no area"))]
    NoNormal {
        /// Vertex of the refined mesh.
        vertex: usize,
        /// The level.
        level: u32,
    },
    /// No level meets both demands.
    #[error(
        "no level is both within {tolerance} of the thickness {thickness} and free of folds: {}",
        tried(.trials, *.scheme)
    )]
    #[diagnostic(help(
        "--scheme contour has no folds at any thickness; or allow a greater --tolerance, ask for a smaller --thickness, or take a level all the same with --levels N"
    ))]
    NoLevel {
        /// Asked for.
        thickness: f64,
        /// Asked for.
        tolerance: f64,
        /// Asked for.
        scheme: Scheme,
        /// What each level gives.
        trials: Vec<Trial>,
    },
}
