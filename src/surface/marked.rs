//! The raw mesh: triangles over shared vertices, with the lines that followers gave.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;
use rustc_hash::{FxHashMap, FxHashSet};
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

    /// Drops pairs of triangles on the same three corners. Where a sheet only
    /// just bulges through a face, the pieces in both tetrahedra have all their
    /// corners in that face, lie on each other and enclose nothing.
    pub fn drop_pillows(&mut self) {
        let sorted = |mut t: [u32; 3]| {
            t.sort_unstable();
            t
        };
        let mut all: Vec<[u32; 3]> = self.triangles.iter().copied().map(sorted).collect();
        all.par_sort_unstable();
        let mut count: FxHashMap<[u32; 3], usize> = (all.chunk_by(|a, b| a == b))
            .filter(|same| same.len() > 1)
            .map(|same| (same[0], same.len()))
            .collect();
        drop(all);
        if count.is_empty() {
            return;
        }
        for t in self.stoppers(&count) {
            count.insert(t, 1);
        }
        self.triangles.retain(|&t| match count.get_mut(&sorted(t)) {
            // Of an odd number one stays, the first.
            Some(n) => std::mem::take(n) % 2 == 1,
            None => true,
        });
    }

    /// Of triangles that come so many times those of an even number of which one
    /// must stay: without it a sheet would end at its sides. A seam that turns round
    /// in a face has two sheets on each other there, one of which the third goes on
    /// as. Marks their sides that become seams so.
    fn stoppers(&mut self, count: &FxHashMap<[u32; 3], usize>) -> Vec<[u32; 3]> {
        let sides = |t: [u32; 3]| [0, 1, 2].map(|k| edge(t[k], t[(k + 1) % 3]));
        let mut pillows: Vec<[u32; 3]> = (count.iter())
            .filter(|(_, n)| *n % 2 == 0)
            .map(|(&t, _)| t)
            .collect();
        pillows.sort_unstable();
        let mut left: FxHashMap<(u32, u32), usize> = (pillows.iter())
            .flat_map(|&t| sides(t))
            .map(|side| (side, 0))
            .collect();
        let mut seen: FxHashSet<[u32; 3]> = FxHashSet::default();
        for &triangle in &self.triangles {
            let mut t = triangle;
            t.sort_unstable();
            // Of an odd number one stays.
            let stays = match count.get(&t) {
                Some(n) => n % 2 == 1 && seen.insert(t),
                None => true,
            };
            if stays {
                for side in sides(triangle) {
                    left.entry(side).and_modify(|n| *n += 1);
                }
            }
        }
        let ends = |side: &(u32, u32)| {
            let line = self.lines.get(side);
            !matches!(line, Some(Line::CopingBorder | Line::FadingBorder))
        };
        let mut kept = Vec::new();
        for t in pillows {
            let open = |uses: usize| {
                let so_many = |side: &(u32, u32)| left[side] == uses && ends(side);
                sides(t).iter().filter(|side| so_many(side)).count()
            };
            if open(1) > 0 && open(0) == 0 {
                sides(t)
                    .iter()
                    .for_each(|side| *left.entry(*side).or_default() += 1);
                kept.push(t);
            }
        }
        for side in kept.iter().flat_map(|&t| sides(t)) {
            if left[&side] > 2 {
                self.lines.entry(side).or_insert(Line::Seam);
            }
        }
        kept
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
