//! The sheet graph, made from the mid-surface alone.

use glam::DVec3;
use petgraph::Undirected;
use petgraph::graph::{Graph, NodeIndex};
use rayon::prelude::*;
use serde::Serialize;

use super::edges::Edges;
use super::sheets::shapes;
use super::{BorderKind, MidSurface, Seam, VertexKind, segments};
use crate::mesh::sets::Sets;

/// Least, middle and greatest of some figures; all 0 of none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Span {
    /// Least.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Greatest.
    pub max: f64,
}

impl Span {
    /// Span of the figures given.
    pub fn of(figures: impl IntoIterator<Item = f64>) -> Span {
        let mut all: Vec<f64> = figures.into_iter().collect();
        all.sort_unstable_by(f64::total_cmp);
        match (all.first(), all.get(all.len() / 2), all.last()) {
            (Some(&min), Some(&median), Some(&max)) => Span { min, median, max },
            _ => Span::default(),
        }
    }
}

/// What is known of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SheetData {
    /// Number of triangles.
    pub triangles: usize,
    /// Area, square part units.
    pub area: f64,
    /// Euler characteristic of the sheet by itself, cut loose along its seams:
    /// 1 for a disc, 0 for a ring.
    pub euler: i64,
    /// Closed curves that bound the loose sheet, whether seam or border.
    pub boundary_loops: usize,
    /// Whether it has two sides.
    pub orientable: bool,
    /// Thickness at its vertices, part units. Seam vertices, where a third
    /// wall ties, are left out as long as there are others.
    pub thickness: Span,
    /// Object angle at the same vertices, degrees.
    pub angle: Span,
}

/// How a seam ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SeamEnd {
    /// On a border at a coping face.
    Coping,
    /// At a junction: where seams meet, or inside.
    Junction,
    /// On a fading border.
    Fading,
    /// At a crack: something is missing there.
    Crack,
}

/// What is known of a seam besides its [`Seam`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SeamData {
    /// Length, part units.
    pub length: f64,
    /// Ends of an open seam, in the order of its path.
    pub ends: Option<[SeamEnd; 2]>,
}

/// What is known of a border besides its [`Border`](super::Border).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BorderData {
    /// Length, part units.
    pub length: f64,
}

/// Counts of the whole mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Vertices.
    pub vertices: usize,
    /// Edges.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Sheets.
    pub sheets: usize,
    /// Seams, loops included.
    pub seams: usize,
    /// Seams that are loops.
    pub closed_seams: usize,
    /// Vertices where seams meet or end inside.
    pub junctions: usize,
    /// Border pieces at coping faces.
    pub coping_borders: usize,
    /// Border pieces where the object angle fades.
    pub fading_borders: usize,
    /// Pieces that hang together over edges.
    pub components: usize,
    /// Connected pieces of the free boundary, cracks included.
    pub boundary_components: usize,
    /// Vertices less edges plus triangles.
    pub euler: i64,
    /// Edges with one triangle and no border mark.
    pub cracks: usize,
    /// Edges with three or more triangles and no seam mark.
    pub irregular_edges: usize,
    /// Lines inside sheets along which they bend: what fins leave.
    pub creases: usize,
    /// Vertices that hold pieces together by a point only, each counted once
    /// for every piece beyond the first.
    pub pinches: usize,
    /// Sheets with one side only.
    pub non_orientable_sheets: usize,
    /// Triangles without area to speak of.
    pub degenerate_triangles: usize,
    /// Vertices with fewer than two separate footpoints.
    pub lone_feet: usize,
}

/// Node of the sheet graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Node {
    /// A sheet, by its number.
    Sheet(u32),
    /// A seam, by its place in [`MidSurface::seams`].
    Seam(u32),
}

/// An edge with one triangle and no border there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crack {
    /// Middle of the edge.
    pub at: DVec3,
    /// Its length.
    pub length: f64,
}

/// Sheets and the seams between them, with what is known of each.
///
/// A seam joins three or more sheet sides, so the graph has two kinds of
/// nodes: sheets and seams, and one edge for each side of a sheet that a seam
/// holds. A sheet that folds back on itself has two edges to the seam. Two
/// sheets are neighbours if they share a seam node.
#[derive(Clone, Debug, Default)]
pub struct SheetGraph {
    graph: Graph<Node, (), Undirected>,
    sheets: Vec<SheetData>,
    seams: Vec<SeamData>,
    borders: Vec<BorderData>,
    cracks: Vec<Crack>,
    counts: Counts,
}

impl SheetGraph {
    /// The graph of a surface.
    pub fn of(surface: &MidSurface) -> SheetGraph {
        let measure = Measure::new(surface);
        let mut graph = Graph::new_undirected();
        for n in 0..surface.sheet_count() {
            graph.add_node(Node::Sheet(n));
        }
        for (n, seam) in (0..).zip(surface.seams()) {
            let node = graph.add_node(Node::Seam(n));
            for &sheet in &seam.sheets {
                graph.add_edge(NodeIndex::new(sheet as usize), node, ());
            }
        }
        let (sheets, cracks) = (measure.sheets(), measure.cracks());
        let counts = measure.counts(cracks.len(), &sheets);
        SheetGraph {
            graph,
            sheets,
            seams: measure.seams(),
            borders: (surface.borders().iter())
                .map(|b| BorderData {
                    length: measure.length(&b.path, b.closed),
                })
                .collect(),
            cracks,
            counts,
        }
    }

    /// Edges that end without a border, in order of their vertices: something
    /// is missing there.
    pub fn cracks(&self) -> &[Crack] {
        &self.cracks
    }

    /// The graph of sheet and seam nodes: sheets first, in order of their
    /// numbers, then seams.
    pub fn graph(&self) -> &Graph<Node, (), Undirected> {
        &self.graph
    }

    /// Sheets by number.
    pub fn sheets(&self) -> &[SheetData] {
        &self.sheets
    }

    /// Seams in the order of the surface's seams.
    pub fn seams(&self) -> &[SeamData] {
        &self.seams
    }

    /// Borders in the order of the surface's borders.
    pub fn borders(&self) -> &[BorderData] {
        &self.borders
    }

    /// Counts of the whole mesh.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Total area, square part units.
    pub fn area(&self) -> f64 {
        self.sheets.iter().map(|s| s.area).sum()
    }

    /// Seams at a sheet, ascending; twice if it has two sides there.
    pub fn seams_of(&self, sheet: u32) -> Vec<u32> {
        self.around(sheet, |node| match node {
            Node::Seam(n) => Some(n),
            Node::Sheet(_) => None,
        })
    }

    /// Sheets that share a seam with a sheet, ascending, each once, without
    /// the sheet itself.
    pub fn neighbours(&self, sheet: u32) -> Vec<u32> {
        let mut all: Vec<u32> = (self.seams_of(sheet).into_iter())
            .flat_map(|seam| {
                self.around(self.sheets.len() as u32 + seam, |node| match node {
                    Node::Sheet(n) => Some(n),
                    Node::Seam(_) => None,
                })
            })
            .filter(|&n| n != sheet)
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn around(&self, node: u32, pick: impl Fn(Node) -> Option<u32>) -> Vec<u32> {
        let mut all: Vec<u32> = (self.graph.neighbors(NodeIndex::new(node as usize)))
            .filter_map(|n| pick(self.graph[n]))
            .collect();
        all.sort_unstable();
        all
    }
}

/// A surface with its edges, to be measured.
struct Measure<'s> {
    surface: &'s MidSurface,
    triangles: Vec<[u32; 3]>,
    edges: Edges,
    /// Lines at each vertex.
    on: Vec<Lines>,
}

/// Lines that run through a vertex.
#[derive(Clone, Copy, Default)]
struct Lines {
    seam: bool,
    coping: bool,
    fading: bool,
}

impl<'s> Measure<'s> {
    fn new(surface: &'s MidSurface) -> Measure<'s> {
        let triangles: Vec<[u32; 3]> = surface.triangles().iter().map(|t| t.corners).collect();
        let edges = Edges::new(&triangles);
        let mut on = vec![Lines::default(); surface.vertices().len()];
        for &v in surface.seams().iter().flat_map(|s| &s.path) {
            on[v as usize].seam = true;
        }
        for border in surface.borders() {
            for &v in &border.path {
                match border.kind {
                    BorderKind::Coping => on[v as usize].coping = true,
                    BorderKind::Fading => on[v as usize].fading = true,
                }
            }
        }
        Measure {
            surface,
            triangles,
            edges,
            on,
        }
    }

    fn at(&self, v: u32) -> DVec3 {
        self.surface.position(v)
    }

    fn length(&self, path: &[u32], closed: bool) -> f64 {
        segments(path, closed)
            .map(|[a, b]| (self.at(a) - self.at(b)).length())
            .sum()
    }

    /// Edges of one triangle that are on no border.
    fn cracks(&self) -> Vec<Crack> {
        let mut bordered = vec![false; self.edges.len()];
        for border in self.surface.borders() {
            for [a, b] in segments(&border.path, border.closed) {
                if let Some(e) = self.edges.find(a, b) {
                    bordered[e] = true;
                }
            }
        }
        (0..self.edges.len())
            .filter(|&e| self.edges.uses(e).len() == 1 && !bordered[e])
            .map(|e| {
                let [a, b] = self.edges.ends[e].map(|v| self.at(v));
                Crack {
                    at: 0.5 * (a + b),
                    length: (b - a).length(),
                }
            })
            .collect()
    }

    fn seams(&self) -> Vec<SeamData> {
        (self.surface.seams().iter())
            .map(|seam| SeamData {
                length: self.length(&seam.path, seam.closed),
                ends: self.seam_ends(seam),
            })
            .collect()
    }

    fn seam_ends(&self, seam: &Seam) -> Option<[SeamEnd; 2]> {
        let (false, &[first, .., last]) = (seam.closed, seam.path.as_slice()) else {
            return None;
        };
        Some([first, last].map(|v| {
            let on = self.on[v as usize];
            if self.surface.vertices()[v as usize].kind == VertexKind::Junction {
                SeamEnd::Junction
            } else if on.coping {
                SeamEnd::Coping
            } else if on.fading {
                SeamEnd::Fading
            } else {
                SeamEnd::Crack
            }
        }))
    }

    /// Areas, shapes and spans of thickness and angle.
    fn sheets(&self) -> Vec<SheetData> {
        let sheet_of: Vec<u32> = self.surface.triangles().iter().map(|t| t.sheet).collect();
        let count = self.surface.sheet_count() as usize;
        let mut data: Vec<SheetData> = shapes(&self.triangles, &self.edges, &sheet_of, count)
            .iter()
            .map(|shape| SheetData {
                euler: shape.euler,
                boundary_loops: shape.loops,
                orientable: !shape.twisted,
                ..SheetData::default()
            })
            .collect();
        // A vertex counts once in each of its sheets, and apart if on a seam.
        let mut members: Vec<(u32, bool, u32)> = Vec::with_capacity(3 * self.triangles.len());
        for t in self.surface.triangles() {
            let [p, q, r] = t.corners.map(|v| self.at(v));
            let sheet = &mut data[t.sheet as usize];
            sheet.area += 0.5 * (q - p).cross(r - p).length();
            sheet.triangles += 1;
            members.extend((t.corners).map(|v| (t.sheet, self.on[v as usize].seam, v)));
        }
        members.sort_unstable();
        members.dedup();
        let vertices = self.surface.vertices();
        let angles: Vec<f64> = vertices.par_iter().map(|v| v.object_angle()).collect();
        for group in members.chunk_by(|a, b| a.0 == b.0) {
            let off_seam = group.iter().filter(|m| !m.1).count();
            let counted = &group[..if off_seam > 0 { off_seam } else { group.len() }];
            let sheet = &mut data[group[0].0 as usize];
            let thickness = |v: u32| vertices[v as usize].ball.thickness;
            sheet.thickness = Span::of(counted.iter().map(|m| thickness(m.2)));
            sheet.angle = Span::of(counted.iter().map(|m| angles[m.2 as usize]));
        }
        data
    }

    fn counts(&self, cracks: usize, sheets: &[SheetData]) -> Counts {
        let surface = self.surface;
        let vertices = surface.vertices().len();
        let mut faces = Sets::new(self.triangles.len());
        let mut rims = Sets::new(vertices);
        let mut on_rim = vec![false; vertices];
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
        }
        let roots = |sets: &mut Sets, count: usize| {
            (0..count as u32).filter(|&n| sets.find(n) == n).count()
        };
        let fan_count = roots(&mut fans, 3 * self.triangles.len());
        let mut used = vec![false; vertices];
        for &v in self.triangles.iter().flatten() {
            used[v as usize] = true;
        }
        let of_kind = |kind| surface.borders().iter().filter(|b| b.kind == kind).count();
        let degenerate = |c: &&[u32; 3]| {
            let [p, q, r] = c.map(|v| self.at(v));
            let longest = [q - p, r - q, p - r].map(DVec3::length_squared);
            let longest = longest[0].max(longest[1]).max(longest[2]);
            (q - p).cross(r - p).length() <= DEGENERATE * longest
        };
        Counts {
            vertices,
            edges: self.edges.len(),
            triangles: self.triangles.len(),
            sheets: surface.sheet_count() as usize,
            seams: surface.seams().len(),
            closed_seams: surface.seams().iter().filter(|s| s.closed).count(),
            junctions: surface.junctions().len(),
            coping_borders: of_kind(BorderKind::Coping),
            fading_borders: of_kind(BorderKind::Fading),
            components: roots(&mut faces, self.triangles.len()),
            boundary_components: (0..vertices as u32)
                .filter(|&v| on_rim[v as usize] && rims.find(v) == v)
                .count(),
            euler: vertices as i64 - self.edges.len() as i64 + self.triangles.len() as i64,
            cracks,
            irregular_edges: surface.seams().iter().map(|s| s.unmarked).sum(),
            creases: surface.creases().len(),
            // A vertex without triangles has no fan.
            pinches: fan_count - used.iter().filter(|used| **used).count(),
            non_orientable_sheets: sheets.iter().filter(|s| !s.orientable).count(),
            degenerate_triangles: self.triangles.iter().filter(degenerate).count(),
            lone_feet: (surface.vertices().iter())
                .filter(|v| v.ball.footpoints.len() < 2)
                .count(),
        }
    }
}

/// A triangle is degenerate if twice its area is below this many squares of
/// its longest edge.
const DEGENERATE: f64 = 1e-10;
