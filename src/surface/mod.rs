//! The result: a non-manifold triangle mesh of sheets that meet in seams.
//!
//! * [`MidSurface`]: the value that all else makes, reads, reshapes, measures
//!   and writes. It knows vertices, triangles, sheets and lines, and nothing of
//!   the part that it came from.
//! * [`marked`]: triangles with marked edges, what tracing makes and editing
//!   changes; [`build`](build::build) finds the sheets and lines in it.
//! * [`graph`]: counts, areas, lengths and neighbours, from the value alone.
//! * [`listing`], [`quality`]: what to say of it.

pub mod build;
pub(crate) mod edges;
pub mod graph;
pub mod listing;
pub mod marked;
mod pillows;
pub mod quality;
#[cfg(test)]
pub(crate) mod shapes;
mod sheets;
#[cfg(test)]
mod tests;
pub mod thickness;

use glam::DVec3;
use serde::Serialize;
use smallvec::SmallVec;
use thiserror::Error;

use crate::mesh::{Frame, TriMesh};
use edges::Edges;

/// What a mid-surface vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VertexKind {
    /// Inside one sheet.
    Sheet,
    /// On a seam.
    Seam,
    /// Where seams meet or end.
    Junction,
    /// On a border where the sheet leaves the part through a coping face.
    CopingBorder,
    /// On a border where the object angle fades.
    FadingBorder,
}

/// The ball around a point of the mid-surface that touches the nearest walls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ball {
    /// Radius, part units.
    ///
    /// Where the object angle is less than 180 degrees, as near a seam, half
    /// the thickness is less than this.
    pub radius: f64,
    /// Largest distance between two footpoints, part units; 0 of fewer than two.
    ///
    /// Near a T the web keeps its true thickness: both feet stand on the two
    /// reflex corners, while the ball grows.
    pub thickness: f64,
    /// Nearest wall points, all at the same distance; none where they are not
    /// known, as in a surface read from a file.
    pub footpoints: SmallVec<[DVec3; 2]>,
}

impl Ball {
    /// The two footpoints that are farthest apart: those that the thickness is
    /// the distance of. The first such pair, where several are equally far.
    pub fn widest(&self) -> Option<[DVec3; 2]> {
        let apart = |pair: &(DVec3, DVec3)| (pair.0 - pair.1).length_squared();
        let wider = |best: (DVec3, DVec3), pair| {
            if apart(&pair) > apart(&best) {
                pair
            } else {
                best
            }
        };
        let (p, q) = pairs(&self.footpoints).reduce(wider)?;
        Some([q, p])
    }

    /// The ball around `centre` that touches at these points.
    pub fn touching(centre: DVec3, footpoints: SmallVec<[DVec3; 2]>) -> Ball {
        let thickness = pairs(&footpoints)
            .map(|(p, q)| (p - q).length())
            .fold(0.0, f64::max);
        Ball {
            radius: footpoints.first().map_or(0.0, |f| f.distance(centre)),
            thickness,
            footpoints,
        }
    }
}

fn pairs(points: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    (points.iter().enumerate()).flat_map(|(n, &p)| points[..n].iter().map(move |&q| (p, q)))
}

/// Vertex of the mid-surface.
#[derive(Clone, Debug, PartialEq)]
pub struct MidVertex {
    /// Position in part units.
    pub position: DVec3,
    /// What it is.
    pub kind: VertexKind,
    /// The ball around it that touches the nearest walls.
    pub ball: Ball,
}

impl MidVertex {
    /// Largest angle between two footpoint vectors, degrees; 0 of fewer than
    /// two footpoints.
    pub fn object_angle(&self) -> f64 {
        pairs(&self.ball.footpoints)
            .map(|(p, q)| (p - self.position).angle_between(q - self.position))
            .map(f64::to_degrees)
            .filter(|a| a.is_finite())
            .fold(0.0, f64::max)
    }
}

/// Triangle of the mid-surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MidTriangle {
    /// Indices into [`MidSurface::vertices`], one orientation a sheet.
    pub corners: [u32; 3],
    /// Sheet that holds it, below [`MidSurface::sheet_count`].
    pub sheet: u32,
}

/// Curve where three or more sheet sides meet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seam {
    /// Vertices in order, each joined to the next by a triangle edge. A
    /// closed line does not repeat its first vertex.
    pub path: Vec<u32>,
    /// Sheets at the seam, sorted, each once per side.
    pub sheets: Vec<u32>,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
    /// Edges that no follower gave as a seam; 0 in a sound result.
    pub unmarked: usize,
}

/// Why a border ends its sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BorderKind {
    /// The sheet leaves the part through a coping face.
    Coping,
    /// The object angle fades out inside the part.
    Fading,
}

/// Piece of the free boundary of a sheet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Border {
    /// Vertices in order, as in [`Seam::path`].
    pub path: Vec<u32>,
    /// Sheet that ends here.
    pub sheet: u32,
    /// Why it ends here.
    pub kind: BorderKind,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
}

/// Line inside a sheet along which it bends: what a fin leaves that is not
/// wanted on a mid-surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crease {
    /// Vertices in order, as in [`Seam::path`].
    pub path: Vec<u32>,
    /// Sheet that bends here.
    pub sheet: u32,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
}

/// What a mid-surface is made of; [`MidSurface::new`] checks it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceParts {
    /// Vertices, shared between sheets along seams.
    pub vertices: Vec<MidVertex>,
    /// Triangles of all sheets.
    pub triangles: Vec<MidTriangle>,
    /// Seams.
    pub seams: Vec<Seam>,
    /// Free boundary.
    pub borders: Vec<Border>,
    /// Creases.
    pub creases: Vec<Crease>,
    /// Vertices where seams meet or end, ascending.
    pub junctions: Vec<u32>,
}

/// The mid-surface of a part.
///
/// Invariants, held by [`MidSurface::new`]: indices are in range, corners of a
/// triangle differ, every figure is finite and no thickness negative; sheets
/// are numbered from 0 without gaps; lines run along triangle edges, those of
/// borders with one triangle, of seams with three or more, of creases with
/// two; junctions ascend. An edge of one triangle on no border is a crack.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MidSurface {
    parts: SurfaceParts,
    sheet_count: u32,
}

/// Why parts make no mid-surface.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A corner, line or junction names a vertex that does not exist.
    #[error("{what} {number} names vertex {vertex}, of {count}")]
    NoVertex {
        /// Triangle, seam, border, crease or junction.
        what: &'static str,
        /// Its number.
        number: usize,
        /// The vertex.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// A triangle has a corner twice.
    #[error("triangle {0} has a corner twice")]
    RepeatedCorner(usize),
    /// A figure is not finite, or a thickness or radius is negative.
    #[error("vertex {0} has a figure that is not finite, or a negative thickness")]
    BadVertex(usize),
    /// A sheet number between 0 and the greatest has no triangle.
    #[error("sheet {0} has no triangle")]
    EmptySheet(u32),
    /// A step of a line is no edge, or an edge of another number of triangles.
    #[error("{what} {number} runs from vertex {from} to {to}, where {triangles} triangles meet")]
    OffEdge {
        /// Seam, border or crease.
        what: &'static str,
        /// Its number.
        number: usize,
        /// Start of the step.
        from: u32,
        /// End of the step.
        to: u32,
        /// Triangles at that edge.
        triangles: usize,
    },
    /// Junctions do not ascend.
    #[error("junctions do not ascend at vertex {0}")]
    Unsorted(u32),
}

impl MidSurface {
    /// A mid-surface of these parts.
    ///
    /// # Errors
    ///
    /// [`SurfaceError`] for what the invariants exclude.
    pub fn new(parts: SurfaceParts) -> Result<MidSurface, SurfaceError> {
        let count = parts.vertices.len();
        let exists = |what, number, vertices: &[u32]| match vertices
            .iter()
            .find(|&&v| v as usize >= count)
        {
            Some(&vertex) => Err(SurfaceError::NoVertex {
                what,
                number,
                vertex,
                count,
            }),
            None => Ok(()),
        };
        for (number, triangle) in parts.triangles.iter().enumerate() {
            exists("triangle", number, &triangle.corners)?;
            let [a, b, c] = triangle.corners;
            if a == b || b == c || c == a {
                return Err(SurfaceError::RepeatedCorner(number));
            }
        }
        let sound = |v: &MidVertex| {
            let lengths = [v.ball.radius, v.ball.thickness];
            v.position.is_finite()
                && v.ball.footpoints.iter().all(|f| f.is_finite())
                && lengths.iter().all(|l| l.is_finite() && *l >= 0.0)
        };
        if let Some(vertex) = parts.vertices.iter().position(|v| !sound(v)) {
            return Err(SurfaceError::BadVertex(vertex));
        }
        let sheet_count = sheet_count(&parts.triangles)?;
        let corners: Vec<[u32; 3]> = parts.triangles.iter().map(|t| t.corners).collect();
        let edges = Edges::new(&corners);
        for (what, number, path, closed) in lines(&parts) {
            exists(what, number, path)?;
            for [from, to] in segments(path, closed) {
                let triangles = edges.find(from, to).map_or(0, |e| edges.uses(e).len());
                let fits = match what {
                    "seam" => triangles >= 3,
                    "border" => triangles == 1,
                    _ => triangles == 2,
                };
                if !fits {
                    return Err(SurfaceError::OffEdge {
                        what,
                        number,
                        from,
                        to,
                        triangles,
                    });
                }
            }
        }
        exists("junction", 0, &parts.junctions)?;
        if let Some(pair) = parts.junctions.windows(2).find(|p| p[0] >= p[1]) {
            return Err(SurfaceError::Unsorted(pair[1]));
        }
        Ok(MidSurface { parts, sheet_count })
    }

    /// Parts that hold the invariants by the way they were made.
    fn made(parts: SurfaceParts, sheet_count: u32) -> MidSurface {
        debug_assert!(MidSurface::new(parts.clone()).is_ok());
        MidSurface { parts, sheet_count }
    }

    /// What it is made of, to be changed and checked anew.
    pub fn into_parts(self) -> SurfaceParts {
        self.parts
    }

    /// Vertices, shared between sheets along seams.
    pub fn vertices(&self) -> &[MidVertex] {
        &self.parts.vertices
    }

    /// Triangles of all sheets.
    pub fn triangles(&self) -> &[MidTriangle] {
        &self.parts.triangles
    }

    /// Seams.
    pub fn seams(&self) -> &[Seam] {
        &self.parts.seams
    }

    /// Free boundary.
    pub fn borders(&self) -> &[Border] {
        &self.parts.borders
    }

    /// Creases.
    pub fn creases(&self) -> &[Crease] {
        &self.parts.creases
    }

    /// Vertices where seams meet or end, ascending.
    pub fn junctions(&self) -> &[u32] {
        &self.parts.junctions
    }

    /// Number of sheets; sheets are numbered from 0.
    pub fn sheet_count(&self) -> u32 {
        self.sheet_count
    }

    /// Where a vertex is.
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.parts.vertices[vertex as usize].position
    }

    /// Its triangles alone.
    pub fn mesh(&self) -> TriMesh {
        TriMesh {
            positions: self.vertices().iter().map(|v| v.position).collect(),
            triangles: self.triangles().iter().map(|t| t.corners).collect(),
        }
    }

    /// Moves positions and footpoints out of a frame.
    pub(crate) fn leave(&mut self, frame: Frame) {
        for vertex in &mut self.parts.vertices {
            frame.leave([&mut vertex.position]);
            frame.leave(&mut vertex.ball.footpoints);
        }
    }
}

/// Number of sheets, if none below it is empty.
fn sheet_count(triangles: &[MidTriangle]) -> Result<u32, SurfaceError> {
    let mut seen: Vec<u32> = triangles.iter().map(|t| t.sheet).collect();
    seen.sort_unstable();
    seen.dedup();
    match (0..).zip(&seen).find(|(n, s)| n != *s) {
        Some((n, _)) => Err(SurfaceError::EmptySheet(n)),
        None => Ok(seen.len() as u32),
    }
}

/// Every line: what it is, its number, its path, and whether it is closed.
fn lines(parts: &SurfaceParts) -> impl Iterator<Item = (&'static str, usize, &[u32], bool)> {
    let seams = (parts.seams.iter().enumerate()).map(|(n, l)| ("seam", n, &l.path[..], l.closed));
    let borders =
        (parts.borders.iter().enumerate()).map(|(n, l)| ("border", n, &l.path[..], l.closed));
    let creases =
        (parts.creases.iter().enumerate()).map(|(n, l)| ("crease", n, &l.path[..], l.closed));
    seams.chain(borders).chain(creases)
}

/// Segments of a line of vertices, as [`Seam::path`] holds them; a closed one
/// returns to its start.
pub fn segments(path: &[u32], closed: bool) -> impl Iterator<Item = [u32; 2]> + '_ {
    let back = match path {
        [first, .., last] if closed => Some([*last, *first]),
        _ => None,
    };
    path.windows(2).map(|pair| [pair[0], pair[1]]).chain(back)
}
