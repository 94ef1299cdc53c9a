//! From a marked mesh to the mid-surface: sheets, seams, borders and creases.
//!
//! An edge with exactly two triangles is inside a sheet, whatever followers
//! said of it; one with three or more is on a seam; one with a single triangle
//! is on a border if a follower marked it so, and a crack if not. Nothing is
//! joined by distance.

use rustc_hash::{FxHashMap, FxHashSet};

use super::edges::{Edges, chains};
use super::marked::{Line, MarkedMesh, edge};
use super::sheets::orient;
use super::{
    Ball, Border, BorderKind, Crease, MidSurface, MidTriangle, MidVertex, Seam, SurfaceParts,
    VertexKind, segments,
};

/// The mid-surface that a marked mesh is; `balls[v]` belongs to its vertex `v`.
///
/// Vertices that no triangle uses and triangles with a repeated corner are
/// dropped, the others keep their order. Sheets are numbered by their lowest
/// triangle and turned to one side each.
pub fn build(mesh: &MarkedMesh, balls: Vec<Ball>) -> MidSurface {
    Complex::new(mesh).build(balls)
}

/// The mesh with its edges and sheets.
struct Complex<'m> {
    mesh: &'m MarkedMesh,
    /// Vertices in use, by their number in the marked mesh.
    kept: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    edges: Edges,
    /// Sheet of each triangle.
    sheet_of: Vec<u32>,
    sheet_count: u32,
}

/// What lines meet at each vertex.
#[derive(Clone, Copy, Default)]
struct Meeting {
    seam: bool,
    coping: bool,
    fading: bool,
    crack: bool,
    junction: bool,
}

impl<'m> Complex<'m> {
    fn new(mesh: &'m MarkedMesh) -> Complex<'m> {
        let sound = |c: &&[u32; 3]| c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
        let mut used = vec![false; mesh.vertices.len()];
        for c in mesh.triangles.iter().filter(sound).flatten() {
            used[*c as usize] = true;
        }
        let kept: Vec<u32> = (0..used.len() as u32)
            .filter(|&v| used[v as usize])
            .collect();
        let mut number = vec![0; used.len()];
        for (n, &v) in kept.iter().enumerate() {
            number[v as usize] = n as u32;
        }
        let mut triangles: Vec<[u32; 3]> = (mesh.triangles.iter().filter(sound))
            .map(|c| c.map(|v| number[v as usize]))
            .collect();
        let edges = Edges::new(&triangles);
        let at = |v: u32| mesh.vertices[kept[v as usize] as usize].at;
        let (sheet_of, sheet_count) = orient(&mut triangles, &edges, &at);
        Complex {
            mesh,
            kept,
            triangles,
            edges,
            sheet_of,
            sheet_count,
        }
    }

    /// What followers said of an edge.
    fn line(&self, e: usize) -> Option<Line> {
        let [a, b] = self.edges.ends[e].map(|v| self.kept[v as usize]);
        let line = self.mesh.lines.get(&edge(a, b)).copied();
        line.filter(|&l| l != Line::Sheet)
    }

    /// Sheet of the face at a use of an edge.
    fn sheet(&self, slot: u32) -> u32 {
        self.sheet_of[slot as usize / 3]
    }

    fn build(self, mut balls: Vec<Ball>) -> MidSurface {
        let mut meetings = vec![Meeting::default(); self.kept.len()];
        let seams = self.seams(&mut meetings);
        let borders = self.borders(&mut meetings);
        for seam in &seams {
            if let (false, &[first, .., last]) = (seam.closed, seam.path.as_slice()) {
                for v in [first, last] {
                    let m = &mut meetings[v as usize];
                    m.junction |= !(m.coping || m.fading || m.crack);
                }
            }
        }
        let junctions: Vec<u32> = (0..meetings.len() as u32)
            .filter(|&v| meetings[v as usize].junction)
            .collect();
        let vertices = (self.kept.iter().zip(&meetings))
            .map(|(&v, m)| MidVertex {
                position: self.mesh.vertices[v as usize].at,
                kind: kind(m),
                ball: std::mem::take(&mut balls[v as usize]),
            })
            .collect();
        let creases = self.creases();
        let triangles = (self.triangles.iter().zip(&self.sheet_of))
            .map(|(&corners, &sheet)| MidTriangle { corners, sheet })
            .collect();
        let parts = SurfaceParts {
            vertices,
            triangles,
            seams,
            borders,
            creases,
            junctions,
        };
        MidSurface::made(parts, self.sheet_count)
    }

    /// Seams. Marks the vertices where they meet as junctions.
    fn seams(&self, meetings: &mut [Meeting]) -> Vec<Seam> {
        let mut classes: Vec<Vec<u32>> = Vec::new();
        let mut class_of: FxHashMap<Vec<u32>, u32> = FxHashMap::default();
        let mut lines = Vec::new();
        let mut unmarked = FxHashSet::default();
        for e in 0..self.edges.len() {
            let uses = self.edges.uses(e);
            if uses.len() < 3 {
                continue;
            }
            let mut sides: Vec<u32> = uses.iter().map(|&s| self.sheet(s)).collect();
            sides.sort_unstable();
            let class = *class_of.entry(sides).or_insert_with_key(|sides| {
                classes.push(sides.clone());
                classes.len() as u32 - 1
            });
            if self.line(e) != Some(Line::Seam) {
                unmarked.insert(self.edges.ends[e]);
            }
            lines.push((self.edges.ends[e], class));
        }
        let mut ends: FxHashMap<u32, u32> = FxHashMap::default();
        let all = chains(&lines, &|_| false);
        for chain in &all {
            for &v in &chain.path {
                meetings[v as usize].seam = true;
            }
            if let (false, &[first, .., last]) = (chain.closed, chain.path.as_slice()) {
                for v in [first, last] {
                    *ends.entry(v).or_default() += 1;
                }
            }
        }
        for (v, _) in ends.into_iter().filter(|&(_, n)| n > 1) {
            meetings[v as usize].junction = true;
        }
        all.into_iter()
            .map(|chain| Seam {
                unmarked: segments(&chain.path, chain.closed)
                    .filter(|&[a, b]| unmarked.contains(&[a.min(b), a.max(b)]))
                    .count(),
                path: chain.path,
                sheets: classes[chain.class as usize].clone(),
                closed: chain.closed,
            })
            .collect()
    }

    /// Borders. Marks the vertices where they and cracks run.
    fn borders(&self, meetings: &mut [Meeting]) -> Vec<Border> {
        let mut lines = Vec::new();
        for e in 0..self.edges.len() {
            let &[slot] = self.edges.uses(e) else {
                continue;
            };
            let ends = self.edges.ends[e];
            let kind = match self.line(e) {
                Some(Line::CopingBorder) => Some(BorderKind::Coping),
                Some(Line::FadingBorder) => Some(BorderKind::Fading),
                _ => None,
            };
            for v in ends {
                let m = &mut meetings[v as usize];
                m.coping |= kind == Some(BorderKind::Coping);
                m.fading |= kind == Some(BorderKind::Fading);
                m.crack |= kind.is_none();
            }
            if let Some(kind) = kind {
                let class = 2 * self.sheet(slot) + u32::from(kind == BorderKind::Fading);
                lines.push((ends, class));
            }
        }
        chains(&lines, &|v| meetings[v as usize].seam)
            .into_iter()
            .map(|chain| Border {
                path: chain.path,
                sheet: chain.class / 2,
                kind: [BorderKind::Coping, BorderKind::Fading][chain.class as usize % 2],
                closed: chain.closed,
            })
            .collect()
    }

    /// Marked edges inside a sheet.
    fn creases(&self) -> Vec<Crease> {
        let lines: Vec<([u32; 2], u32)> = (0..self.edges.len())
            .filter(|&e| self.line(e).is_some())
            .filter_map(|e| {
                let &[slot, _] = self.edges.uses(e) else {
                    return None;
                };
                Some((self.edges.ends[e], self.sheet(slot)))
            })
            .collect();
        chains(&lines, &|_| false)
            .into_iter()
            .map(|chain| Crease {
                path: chain.path,
                sheet: chain.class,
                closed: chain.closed,
            })
            .collect()
    }
}

fn kind(meeting: &Meeting) -> VertexKind {
    match meeting {
        Meeting { junction: true, .. } => VertexKind::Junction,
        Meeting { seam: true, .. } => VertexKind::Seam,
        Meeting { coping: true, .. } => VertexKind::CopingBorder,
        Meeting { fading: true, .. } => VertexKind::FadingBorder,
        _ => VertexKind::Sheet,
    }
}
