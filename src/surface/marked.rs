//! The raw mesh: triangles over shared vertices, with the lines that followers gave.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::{BorderKind, MidSurface, segments};
use crate::mesh::{FaceId, TriMesh};

/// What a side of a polygon is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Line {
    /// Inside a sheet.
    Sheet,
    /// Along a seam.
    Seam,
    /// Where the sheet leaves the part through coping.
    CopingBorder,
    /// Where the sheet fades out.
    FadingBorder,
    /// Where the sheet bends because a fin was left out.
    Crease,
}

/// A vertex with the walls that tie there.
#[derive(Clone, Debug)]
pub struct MarkedVertex {
    /// Where.
    pub at: DVec3,
    /// Wall triangles that tie.
    pub walls: SmallVec<[FaceId; 4]>,
    /// The coping triangle, on a coping border.
    pub coping: Option<FaceId>,
}

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default)]
pub struct MarkedMesh {
    /// Vertices.
    pub vertices: Vec<MarkedVertex>,
    /// Triangles; no orientation promised.
    pub triangles: Vec<[u32; 3]>,
    /// What followers said of an edge, low vertex first. Edges not listed are
    /// inside a sheet.
    pub lines: FxHashMap<(u32, u32), Line>,
}

/// An edge and the triangles at it.
pub type EdgeTriangles = ((u32, u32), SmallVec<[u32; 3]>);

/// An edge by its vertices, low first.
pub fn edge(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl MarkedMesh {
    /// The mesh of a surface, its walls unknown.
    pub fn of(surface: &MidSurface) -> MarkedMesh {
        let seams = (surface.seams().iter()).map(|l| (&l.path, l.closed, Line::Seam));
        let borders = surface.borders().iter().map(|l| {
            let line = match l.kind {
                BorderKind::Coping => Line::CopingBorder,
                BorderKind::Fading => Line::FadingBorder,
            };
            (&l.path, l.closed, line)
        });
        let creases = (surface.creases().iter()).map(|l| (&l.path, l.closed, Line::Crease));
        let lines = seams
            .chain(borders)
            .chain(creases)
            .flat_map(|(path, closed, line)| {
                segments(path, closed).map(move |[a, b]| (edge(a, b), line))
            });
        MarkedMesh {
            lines: lines.collect(),
            vertices: (surface.vertices().iter())
                .map(|v| MarkedVertex {
                    at: v.position,
                    walls: SmallVec::new(),
                    coping: None,
                })
                .collect(),
            triangles: surface.triangles().iter().map(|t| t.corners).collect(),
        }
    }

    /// Drops marks from edges inside a sheet: where a loop was closed by
    /// matching, the neighbour may have gone on beyond its border.
    pub fn drop_stray_lines(&mut self) {
        let mut uses: FxHashMap<(u32, u32), usize> =
            self.lines.keys().map(|&marked| (marked, 0)).collect();
        for c in &self.triangles {
            for k in 0..3 {
                if let Some(n) = uses.get_mut(&edge(c[k], c[(k + 1) % 3])) {
                    *n += 1;
                }
            }
        }
        (self.lines).retain(|marked, line| uses[marked] != 2 || *line == Line::Crease);
    }

    /// Its triangles alone.
    pub fn plain(&self) -> TriMesh {
        TriMesh {
            positions: self.vertices.iter().map(|v| v.at).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// Triangles at each edge, edges in ascending order.
    pub fn edge_triangles(&self) -> Vec<EdgeTriangles> {
        let mut all: Vec<((u32, u32), u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (t, c) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                all.push((edge(c[k], c[(k + 1) % 3]), t as u32));
            }
        }
        all.sort_unstable();
        let mut out: Vec<EdgeTriangles> = Vec::new();
        for (e, t) in all {
            match out.last_mut() {
                Some(last) if last.0 == e => last.1.push(t),
                _ => out.push((e, SmallVec::from_slice(&[t]))),
            }
        }
        out
    }
}
