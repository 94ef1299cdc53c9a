//! What can be wrong with a part, and what was put right on the way.

use std::fmt;

use glam::DVec3;
use miette::Diagnostic;
use thiserror::Error;

use super::FaceId;

/// An edge for a message: where it is and one triangle that has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeReport {
    /// One end.
    pub from: DVec3,
    /// The other end.
    pub to: DVec3,
    /// A triangle with this edge.
    pub triangle: FaceId,
}

impl fmt::Display for EdgeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = [self.from, self.to];
        write!(
            f,
            "from ({}, {}, {}) to ({}, {}, {}) of triangle {}",
            a.x, a.y, a.z, b.x, b.y, b.z, self.triangle.0
        )
    }
}

/// Why a mesh with its coping flags is no part. Triangles and vertices are
/// named by 0-based index.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum PartError {
    /// No triangles at all.
    #[error("the mesh has no triangles")]
    #[diagnostic(help("check that the export holds the part's faces, not only its points"))]
    Empty,
    /// A corner points past the end of the vertices.
    #[error("triangle {} names vertex {index}, but there are only {vertices}", triangle.0)]
    #[diagnostic(help("export the mesh again; indices count from 0"))]
    IndexOutOfRange {
        /// The triangle.
        triangle: FaceId,
        /// The index it names.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// NaN or an infinity.
    #[error("vertex {vertex} has a coordinate that is no finite number: ({:e}, {:e}, {:e})", position.x, position.y, position.z)]
    #[diagnostic(help("repair the vertex in the tool that wrote the mesh"))]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// Its position.
        position: DVec3,
    },
    /// The box is too large or too small for the arithmetic.
    #[error("the part's bounding box has a diagonal of {diagonal:e}, which is not usable")]
    #[diagnostic(help("scale the part to a diagonal between 1e-30 and 1e30 units"))]
    Size {
        /// Diagonal of the box.
        diagonal: f64,
    },
    /// The flags belong to something else.
    #[error("{flags} coping flags were given for {triangles} triangles")]
    #[diagnostic(help("give one flag for every triangle of the mesh"))]
    CopingLength {
        /// Flags given.
        flags: usize,
        /// Triangles of the mesh.
        triangles: usize,
    },
    /// The weld tolerance would weld the part itself away.
    #[error("a weld tolerance of {tolerance} does not fit a part with a diagonal of {diagonal:.6}")]
    #[diagnostic(help(
        "give a positive length well below the wall thickness, or leave the option away: equal vertices are welded anyway"
    ))]
    WeldTolerance {
        /// Tolerance asked for.
        tolerance: f64,
        /// Diagonal of the box.
        diagonal: f64,
    },
    /// Edges of one triangle only.
    #[error("the mesh is open: {count} {} one triangle only, the first {first}", if *count == 1 { "edge has" } else { "edges have" })]
    #[diagnostic(help("{}", open_remedy(*weld)))]
    Open {
        /// How many open edges.
        count: usize,
        /// One of them.
        first: EdgeReport,
        /// A tolerance of [`PartOptions::weld`](super::PartOptions::weld) that would
        /// close it, if one was found.
        weld: Option<f64>,
    },
    /// No consistent orientation exists, as on a Moebius strip.
    #[error(
        "the triangles cannot be oriented consistently; the contradiction shows at the edge {first}"
    )]
    #[diagnostic(help("the surface has one side only there: rebuild the faces around that edge"))]
    NotOrientable {
        /// Where two ways round disagree.
        first: EdgeReport,
    },
    /// Edges where triangles do not pair up.
    #[error("{count} {} shared by three or more triangles that do not pair up, the first {first} with {uses} triangles", if *count == 1 { "edge is" } else { "edges are" })]
    #[diagnostic(help(
        "remove inner faces or doubled triangles at that edge; --repair does where they lie on each other; --allow-open goes on all the same, but inside and outside are then guesses near it"
    ))]
    NonManifold {
        /// How many such edges.
        count: usize,
        /// One of them.
        first: EdgeReport,
        /// Triangles at that edge.
        uses: usize,
    },
    /// Closed, but encloses nothing.
    #[error("the mesh is closed but encloses no volume (volume {volume:e}, area {area:e})")]
    #[diagnostic(help("the part must be a solid with thick walls, not a doubled surface"))]
    NoVolume {
        /// Signed volume.
        volume: f64,
        /// Area of all triangles.
        area: f64,
    },
    /// Every triangle is tagged.
    #[error("all {triangles} triangles are tagged as coping, so no wall is left")]
    #[diagnostic(help(
        "tag only the narrow side faces that close a wall; `midsurf tags PART TAGS` shows what each rule selects"
    ))]
    AllCoping {
        /// Triangles of the part.
        triangles: usize,
    },
    /// The wall triangles left are all of zero area.
    #[error("none of the {walls} wall triangles has an area, so no wall is left")]
    #[diagnostic(help(
        "tag only the narrow side faces that close a wall; `midsurf tags PART TAGS` shows what each rule selects"
    ))]
    NoWall {
        /// Wall triangles, all of zero area.
        walls: usize,
    },
}

fn open_remedy(weld: Option<f64>) -> String {
    // Hollowing has an --open of its own, but no --distance.
    const SURFACE: &str =
        "--open both takes it for a surface without thickness, with --distance to both sides";
    match weld {
        Some(weld) => format!(
            "its vertices do not quite meet: close the gaps in the modelling tool; or --weld {weld:.1e}, which closes it, if that is well below the wall thickness; or --repair; {SURFACE}"
        ),
        None => format!(
            "close the holes in the modelling tool; --repair fills small flat ones; --allow-open goes on all the same, but inside and outside are then guesses near the gaps and sheets may be missing or cut short there; {SURFACE}"
        ),
    }
}

impl PartError {
    /// The triangle that the message names, to look up its place in the file.
    pub fn triangle(&self) -> Option<FaceId> {
        match self {
            PartError::IndexOutOfRange { triangle, .. } => Some(*triangle),
            PartError::Open { first, .. }
            | PartError::NotOrientable { first }
            | PartError::NonManifold { first, .. } => Some(first.triangle),
            _ => None,
        }
    }
}

/// What was odd about a part and how it was dealt with.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PartWarning {
    /// Vertices merged; `near` counts those that needed the tolerance.
    Welded {
        /// Merged because they were equal.
        exact: usize,
        /// Merged because they were within the tolerance.
        near: usize,
    },
    /// Vertices lay on edges of the triangles beyond, which were split there.
    Stitched {
        /// Edges closed.
        edges: usize,
        /// Triangles added.
        triangles: usize,
    },
    /// Triangles without area, of three vertices in a row, were given a piece of
    /// the triangle beyond their longest edge.
    Flipped {
        /// How many.
        triangles: usize,
    },
    /// Triangles lay on others of the same three vertices, and were left out.
    Doubled {
        /// Triangles left out.
        triangles: usize,
    },
    /// Small flat holes were filled.
    Filled {
        /// Holes.
        holes: usize,
        /// Triangles added.
        triangles: usize,
    },
    /// Fans of triangles that touched in a vertex alone got vertices of their own.
    Unpinched {
        /// Vertices added.
        vertices: usize,
    },
    /// The part was inside out and was turned.
    Turned {
        /// Volume before.
        volume: f64,
    },
    /// Single shells were inside out and were turned.
    ShellsTurned {
        /// Shells turned.
        shells: usize,
        /// Their triangles.
        triangles: usize,
    },
    /// Shells lay inside others the wrong way round for what they are there: a
    /// cavity, mostly. They were turned.
    ShellsNested {
        /// Shells turned.
        shells: usize,
        /// Their triangles.
        triangles: usize,
    },
    /// Shells too many to find out which lies in which.
    ShellsUnchecked {
        /// Shells left as they are.
        shells: usize,
    },
    /// Triangles were turned to agree with their neighbours.
    Reoriented {
        /// Triangles turned.
        triangles: usize,
        /// An edge where neighbours disagreed.
        first: EdgeReport,
    },
    /// The mesh is open and was let through.
    Open {
        /// Open edges.
        count: usize,
        /// One of them.
        first: EdgeReport,
    },
    /// Edges of more than two triangles.
    NonManifold {
        /// How many.
        count: usize,
        /// One of them.
        first: EdgeReport,
        /// Whether their triangles pair up.
        balanced: bool,
    },
    /// Triangles without area; kept.
    ZeroArea {
        /// How many.
        triangles: usize,
        /// The first.
        first: FaceId,
    },
    /// Nothing is tagged.
    NoCoping,
    /// The part is so far from the origin that its own numbers have lost
    /// digits.
    FarFromOrigin {
        /// Largest coordinate over the diagonal of the box.
        ratio: f64,
        /// Distance between neighbouring numbers there, part units.
        step: f64,
    },
}

impl PartWarning {
    /// Stable code for reports.
    pub fn code(&self) -> &'static str {
        match self {
            PartWarning::Welded { .. } => "welded",
            PartWarning::Stitched { .. } => "stitched",
            PartWarning::Flipped { .. } => "flipped",
            PartWarning::Doubled { .. } => "doubled",
            PartWarning::Filled { .. } => "filled",
            PartWarning::Unpinched { .. } => "unpinched",
            PartWarning::Turned { .. } => "turned",
            PartWarning::ShellsTurned { .. } => "shells_turned",
            PartWarning::ShellsNested { .. } => "shells_nested",
            PartWarning::ShellsUnchecked { .. } => "shells_unchecked",
            PartWarning::Reoriented { .. } => "reoriented",
            PartWarning::Open { .. } => "open",
            PartWarning::NonManifold { .. } => "non_manifold",
            PartWarning::ZeroArea { .. } => "zero_area",
            PartWarning::NoCoping => "no_coping",
            PartWarning::FarFromOrigin { .. } => "far_from_origin",
        }
    }
}

impl fmt::Display for PartWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PartWarning::Welded { exact, near } => write!(
                f,
                "vertices welded: {exact} equal ones, {near} nearly equal ones"
            ),
            PartWarning::Stitched { edges, triangles } => write!(
                f,
                "{edges} edges were open because vertices lie on them that their triangle does not have; splitting there added {triangles} triangles"
            ),
            PartWarning::Flipped { triangles } => write!(
                f,
                "{triangles} triangles had no area, their vertices being in a row; the triangles beyond were split there in their place"
            ),
            PartWarning::Doubled { triangles } => write!(
                f,
                "{triangles} triangles lay on others of the same vertices and were left out"
            ),
            PartWarning::Filled { holes, triangles } => write!(
                f,
                "{holes} small flat holes were filled with {triangles} triangles"
            ),
            PartWarning::Unpinched { vertices } => write!(
                f,
                "{vertices} vertices were added where pieces of the surface touched in a vertex alone; nothing moved"
            ),
            PartWarning::Turned { volume } => write!(
                f,
                "the part was inside out (volume {volume:.6}); all triangles were turned"
            ),
            PartWarning::ShellsTurned { shells, triangles } => write!(
                f,
                "{shells} shells were inside out; their {triangles} triangles were turned"
            ),
            PartWarning::ShellsNested { shells, triangles } => write!(
                f,
                "{shells} {} inside another shell the same way round as that; {triangles} triangles were turned, so that a shell in a shell is a cavity and one in a cavity is solid",
                if *shells == 1 {
                    "shell lies"
                } else {
                    "shells lie"
                },
            ),
            PartWarning::ShellsUnchecked { shells } => write!(
                f,
                "{shells} shells were left as they are, too many to find out which lies in which"
            ),
            PartWarning::Reoriented { triangles, first } => write!(
                f,
                "{triangles} triangles were turned to agree with their neighbours, the first disagreement at the edge {first}"
            ),
            PartWarning::Open { count, first } => write!(
                f,
                "the mesh is open: {count} edges have one triangle only, the first {first}; inside and outside are guesses near the gaps"
            ),
            PartWarning::NonManifold {
                count,
                first,
                balanced,
            } => write!(
                f,
                "{count} edges have more than two triangles{}, the first {first}",
                if *balanced {
                    ""
                } else {
                    " that do not pair up"
                }
            ),
            PartWarning::ZeroArea { triangles, first } => write!(
                f,
                "{triangles} triangles have no area, the first is triangle {}; they are kept and do no harm",
                first.0
            ),
            PartWarning::NoCoping => write!(
                f,
                "no triangle is tagged as coping; the mid-surface will end in fins at the rims of the walls"
            ),
            PartWarning::FarFromOrigin { ratio, step } => write!(
                f,
                "the part lies {ratio:.1e} times its size away from the origin, where its coordinates come in steps of {step:.1e}: what is finer is lost in the file already; export it nearer to the origin, or in a format of double precision"
            ),
        }
    }
}
