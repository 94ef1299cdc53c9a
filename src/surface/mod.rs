//! The result: a non-manifold triangle mesh of sheets that meet in seams.

pub mod graph;
pub mod listing;
pub mod marked;
#[cfg(test)]
pub(crate) mod shapes;

use glam::DVec3;
use serde::Serialize;
use smallvec::SmallVec;

use crate::mesh::TriMesh;

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

/// Vertex of the mid-surface.
#[derive(Clone, Debug, PartialEq)]
pub struct MidVertex {
    /// Position in part units.
    pub position: DVec3,
    /// What it is.
    pub kind: VertexKind,
    /// Distance between the footpoints, in part units.
    pub thickness: f64,
    /// Nearest wall points, all at the same distance from `position`.
    pub footpoints: SmallVec<[DVec3; 2]>,
}

impl MidVertex {
    /// Radius of the ball around it that touches the nearest walls; half the
    /// thickness where no footpoint is known.
    ///
    /// Where the object angle is less than 180 degrees, as near a seam, half
    /// the thickness is less than this.
    pub fn radius(&self) -> f64 {
        let foot = self.footpoints.first();
        foot.map_or(0.5 * self.thickness, |f| f.distance(self.position))
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
pub struct SeamLine {
    /// Vertices in order, each joined to the next by a triangle edge. A
    /// closed line does not repeat its first vertex.
    pub path: Vec<u32>,
    /// Sheets at the seam, sorted, each once per side.
    pub sheets: Vec<u32>,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
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
pub struct BorderLine {
    /// Vertices in order, as in [`SeamLine::path`].
    pub path: Vec<u32>,
    /// Sheet that ends here.
    pub sheet: u32,
    /// Why it ends here.
    pub kind: BorderKind,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
}

/// The mid-surface of a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MidSurface {
    /// Vertices, shared between sheets along seams.
    pub vertices: Vec<MidVertex>,
    /// Triangles of all sheets.
    pub triangles: Vec<MidTriangle>,
    /// Seams.
    pub seams: Vec<SeamLine>,
    /// Free boundary.
    pub borders: Vec<BorderLine>,
    /// Vertices where seams meet or end, ascending.
    pub junctions: Vec<u32>,
    /// Number of sheets; sheets are numbered from 0.
    pub sheet_count: u32,
}

impl MidSurface {
    /// Its triangles alone.
    pub fn mesh(&self) -> TriMesh {
        TriMesh {
            positions: self.vertices.iter().map(|v| v.position).collect(),
            triangles: self.triangles.iter().map(|t| t.corners).collect(),
        }
    }
}

/// Segments of a line of vertices, as [`SeamLine::path`] holds them; a closed one
/// returns to its start.
pub fn segments(path: &[u32], closed: bool) -> impl Iterator<Item = [u32; 2]> + '_ {
    let back = match path {
        [first, .., last] if closed => Some([*last, *first]),
        _ => None,
    };
    path.windows(2).map(|pair| [pair[0], pair[1]]).chain(back)
}
