//! Sheets, seams and borders.
//!
//! An edge with exactly two triangles is inside a sheet, whatever followers
//! said of it; one with three or more is on a seam; one with a single triangle
//! is on a border if a follower marked it so, and a crack if not. Every count
//! here is of the mesh as it is, nothing is joined by distance.

mod data;
mod edges;
mod feet;
mod sheets;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

pub use data::{BorderData, Counts, Node, SeamData, SeamEnd, SheetData, SheetGraph, Span};

use crate::field::Field;
use crate::mesh::sets::Sets;
use crate::surface::marked::Line;
use crate::surface::marked::{RawMesh, edge};
use crate::surface::{
    BorderKind, BorderLine, MidSurface, MidTriangle, MidVertex, SeamLine, VertexKind, segments,
};
use edges::{Chain, Edges, chains};
use feet::Feet;
use sheets::{Sheets, shapes};

/// An edge with one triangle and no border there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crack {
    /// Middle of the edge.
    pub at: DVec3,
    /// Its length.
    pub length: f64,
}

/// Builds the result from the raw mesh.
///
/// Vertices that no triangle uses are dropped, the others keep their order.
/// Triangles with a repeated corner are dropped too; they are counted.
pub fn build(mesh: &RawMesh, field: &Field) -> (MidSurface, SheetGraph, Vec<Crack>) {
    let complex = Complex::new(mesh);
    let feet = Feet::find(mesh, &complex.kept, field);
    complex.build(feet)
}

/// The mesh with its edges and sheets.
struct Complex<'m> {
    mesh: &'m RawMesh,
    /// Vertices in use, by their number in the raw mesh.
    kept: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    repeated_corners: usize,
    edges: Edges,
    sheets: Sheets,
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
    fn new(mesh: &'m RawMesh) -> Complex<'m> {
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
        let edges = Edges::new(&triangles, |a, b| {
            let key = edge(kept[a as usize], kept[b as usize]);
            mesh.lines.get(&key).copied().filter(|&l| l != Line::Sheet)
        });
        let at = |v: u32| mesh.vertices[kept[v as usize] as usize].at;
        let sheets = Sheets::orient(&mut triangles, &edges, &at);
        Complex {
            mesh,
            repeated_corners: mesh.triangles.len() - triangles.len(),
            kept,
            triangles,
            edges,
            sheets,
        }
    }

    fn at(&self, v: u32) -> DVec3 {
        self.mesh.vertices[self.kept[v as usize] as usize].at
    }

    fn length(&self, e: usize) -> f64 {
        let [a, b] = self.edges.ends[e].map(|v| self.at(v));
        (b - a).length()
    }

    fn path_length(&self, path: &[u32], closed: bool) -> f64 {
        let steps = path.windows(2).map(|s| (s[0], s[1]));
        let last = match (closed, path) {
            (true, &[first, .., last]) => Some((last, first)),
            _ => None,
        };
        steps
            .chain(last)
            .map(|(a, b)| (self.at(a) - self.at(b)).length())
            .sum()
    }

    fn sheet_of(&self, slot: u32) -> u32 {
        self.sheets.of_face[slot as usize / 3]
    }

    fn build(self, feet: Feet) -> (MidSurface, SheetGraph, Vec<Crack>) {
        let mut meetings = vec![Meeting::default(); self.kept.len()];
        let seams = self.seams(&mut meetings);
        let (borders, cracks) = self.borders(&mut meetings);
        for (seam, _) in &seams {
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

        let sheets = self.sheet_data(&feet, &meetings);
        let seam_data = (seams.iter())
            .map(|(seam, irregular)| SeamData {
                length: self.path_length(&seam.path, seam.closed),
                irregular: *irregular,
                ends: seam_ends(seam, &meetings),
            })
            .collect::<Vec<_>>();
        let border_data = (borders.iter())
            .map(|b| BorderData {
                length: self.path_length(&b.path, b.closed),
            })
            .collect();
        let seams: Vec<SeamLine> = seams.into_iter().map(|s| s.0).collect();
        let counts = self.counts(&seams, &borders, junctions.len(), cracks.len(), &feet);
        let graph = SheetGraph::new(sheets, seam_data, &seams, border_data, counts);
        let surface = MidSurface {
            vertices: self.vertices(feet, &meetings),
            triangles: (self.triangles.iter().zip(&self.sheets.of_face))
                .map(|(&corners, &sheet)| MidTriangle { corners, sheet })
                .collect(),
            seams,
            borders,
            junctions,
            sheet_count: self.sheets.count() as u32,
        };
        (surface, graph, cracks)
    }

    /// Seams, each with whether it has an edge that no follower marked.
    ///
    /// Marks the vertices where seams meet as junctions.
    fn seams(&self, meetings: &mut [Meeting]) -> Vec<(SeamLine, bool)> {
        let mut classes: Vec<Vec<u32>> = Vec::new();
        let mut class_of: FxHashMap<Vec<u32>, u32> = FxHashMap::default();
        let mut lines = Vec::new();
        let mut unmarked = FxHashSet::default();
        for e in 0..self.edges.len() {
            let uses = self.edges.uses(e);
            if uses.len() < 3 {
                continue;
            }
            let mut sides: Vec<u32> = uses.iter().map(|&s| self.sheet_of(s)).collect();
            sides.sort_unstable();
            let class = *class_of.entry(sides).or_insert_with_key(|sides| {
                classes.push(sides.clone());
                classes.len() as u32 - 1
            });
            if self.edges.line[e] != Some(Line::Seam) {
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
        let irregular = |chain: &Chain| {
            segments(&chain.path, chain.closed)
                .any(|[a, b]| unmarked.contains(&[a.min(b), a.max(b)]))
        };
        all.into_iter()
            .map(|chain| {
                let irregular = irregular(&chain);
                let line = SeamLine {
                    path: chain.path,
                    sheets: classes[chain.class as usize].clone(),
                    closed: chain.closed,
                };
                (line, irregular)
            })
            .collect()
    }

    /// Borders and cracks; notes at the vertices where they run.
    fn borders(&self, meetings: &mut [Meeting]) -> (Vec<BorderLine>, Vec<Crack>) {
        let mut lines = Vec::new();
        let mut cracks = Vec::new();
        for e in 0..self.edges.len() {
            let &[slot] = self.edges.uses(e) else {
                continue;
            };
            let ends = self.edges.ends[e];
            let kind = match self.edges.line[e] {
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
            match kind {
                Some(kind) => {
                    let class = 2 * self.sheet_of(slot) + u32::from(kind == BorderKind::Fading);
                    lines.push((ends, class));
                }
                None => cracks.push(Crack {
                    at: 0.5 * (self.at(ends[0]) + self.at(ends[1])),
                    length: self.length(e),
                }),
            }
        }
        let borders = chains(&lines, &|v| meetings[v as usize].seam)
            .into_iter()
            .map(|chain| BorderLine {
                path: chain.path,
                sheet: chain.class / 2,
                kind: [BorderKind::Coping, BorderKind::Fading][chain.class as usize % 2],
                closed: chain.closed,
            })
            .collect();
        (borders, cracks)
    }

    fn vertices(&self, feet: Feet, meetings: &[Meeting]) -> Vec<MidVertex> {
        (feet.into_points().into_iter())
            .zip(meetings)
            .enumerate()
            .map(|(v, (points, m))| MidVertex {
                position: self.at(v as u32),
                kind: match m {
                    Meeting { junction: true, .. } => VertexKind::Junction,
                    Meeting { seam: true, .. } => VertexKind::Seam,
                    Meeting { coping: true, .. } => VertexKind::CopingBorder,
                    Meeting { fading: true, .. } => VertexKind::FadingBorder,
                    _ => VertexKind::Sheet,
                },
                thickness: feet::thickness(&points),
                footpoints: points,
            })
            .collect()
    }

    /// Areas, shapes and spans of thickness and angle.
    fn sheet_data(&self, feet: &Feet, meetings: &[Meeting]) -> Vec<SheetData> {
        let shapes = shapes(&self.triangles, &self.edges, &self.sheets);
        let mut data: Vec<SheetData> = (shapes.iter().zip(&self.sheets.twisted))
            .map(|(shape, &twisted)| SheetData {
                euler: shape.euler,
                boundary_loops: shape.loops,
                orientable: !twisted,
                ..SheetData::default()
            })
            .collect();
        // A vertex counts once in each of its sheets, and apart if on a seam.
        let mut members: Vec<(u32, bool, u32)> = Vec::with_capacity(3 * self.triangles.len());
        for (c, &sheet) in self.triangles.iter().zip(&self.sheets.of_face) {
            let [p, q, r] = c.map(|v| self.at(v));
            let sheet_data = &mut data[sheet as usize];
            sheet_data.area += 0.5 * (q - p).cross(r - p).length();
            sheet_data.triangles += 1;
            members.extend(c.map(|v| (sheet, meetings[v as usize].seam, v)));
        }
        members.sort_unstable();
        members.dedup();
        for group in members.chunk_by(|a, b| a.0 == b.0) {
            let off_seam = group.iter().filter(|m| !m.1).count();
            let counted = &group[..if off_seam > 0 { off_seam } else { group.len() }];
            let sheet_data = &mut data[group[0].0 as usize];
            sheet_data.thickness = Span::of(counted.iter().map(|m| feet.thickness(m.2)));
            sheet_data.angle = Span::of(counted.iter().map(|m| feet.angle(m.2)));
        }
        data
    }

    fn counts(
        &self,
        seams: &[SeamLine],
        borders: &[BorderLine],
        junctions: usize,
        cracks: usize,
        feet: &Feet,
    ) -> Counts {
        let mut faces = Sets::new(self.triangles.len());
        let mut rims = Sets::new(self.kept.len());
        let mut on_rim = vec![false; self.kept.len()];
        let (mut irregular_edges, mut stray_marks) = (0, 0);
        // Corners of triangles at a vertex, joined over edges of any kind.
        let mut fans = Sets::new(3 * self.triangles.len());
        let corner = |slot: u32, v: u32| {
            let face = slot / 3;
            let c = self.triangles[face as usize];
            3 * face + c.iter().position(|&w| w == v).unwrap_or(0) as u32
        };
        for e in 0..self.edges.len() {
            let uses = self.edges.uses(e);
            let ends = self.edges.ends[e];
            for pair in uses.windows(2) {
                faces.join(pair[0] / 3, pair[1] / 3);
                for v in ends {
                    fans.join(corner(pair[0], v), corner(pair[1], v));
                }
            }
            if uses.len() == 1 {
                rims.join(ends[0], ends[1]);
                on_rim[ends[0] as usize] = true;
                on_rim[ends[1] as usize] = true;
            }
            irregular_edges +=
                usize::from(uses.len() > 2 && self.edges.line[e] != Some(Line::Seam));
            stray_marks += usize::from(
                uses.len() == 2 && self.edges.line[e].is_some_and(|l| l != Line::Crease),
            );
        }
        let roots = |sets: &mut Sets, count: usize| {
            (0..count as u32).filter(|&n| sets.find(n) == n).count()
        };
        let fan_count = roots(&mut fans, 3 * self.triangles.len());
        let of_kind = |kind| borders.iter().filter(|b| b.kind == kind).count();
        let degenerate = |c: &&[u32; 3]| {
            let [p, q, r] = c.map(|v| self.at(v));
            let longest = [q - p, r - q, p - r].map(DVec3::length_squared);
            let longest = longest[0].max(longest[1]).max(longest[2]);
            (q - p).cross(r - p).length() <= DEGENERATE * longest
        };
        Counts {
            vertices: self.kept.len(),
            edges: self.edges.len(),
            triangles: self.triangles.len(),
            sheets: self.sheets.count(),
            seams: seams.len(),
            closed_seams: seams.iter().filter(|s| s.closed).count(),
            junctions,
            coping_borders: of_kind(BorderKind::Coping),
            fading_borders: of_kind(BorderKind::Fading),
            components: roots(&mut faces, self.triangles.len()),
            boundary_components: (0..self.kept.len() as u32)
                .filter(|&v| on_rim[v as usize] && rims.find(v) == v)
                .count(),
            euler: self.kept.len() as i64 - self.edges.len() as i64 + self.triangles.len() as i64,
            cracks,
            irregular_edges,
            stray_marks,
            pinches: fan_count - self.kept.len(),
            non_orientable_sheets: self.sheets.twisted.iter().filter(|&&t| t).count(),
            degenerate_triangles: self.triangles.iter().filter(degenerate).count()
                + self.repeated_corners,
            lone_feet: feet.lone(),
        }
    }
}

/// A triangle is degenerate if twice its area is below this many squares of
/// its longest edge.
const DEGENERATE: f64 = 1e-10;

fn seam_ends(seam: &SeamLine, meetings: &[Meeting]) -> Option<[SeamEnd; 2]> {
    let (false, &[first, .., last]) = (seam.closed, seam.path.as_slice()) else {
        return None;
    };
    Some([first, last].map(|v| match meetings[v as usize] {
        Meeting { junction: true, .. } => SeamEnd::Junction,
        Meeting { coping: true, .. } => SeamEnd::Coping,
        Meeting { fading: true, .. } => SeamEnd::Fading,
        _ => SeamEnd::Crack,
    }))
}
