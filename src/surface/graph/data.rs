//! The sheet graph.

use petgraph::Undirected;
use petgraph::graph::{Graph, NodeIndex};
use serde::Serialize;

use crate::surface::SeamLine;

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

/// What is known of a seam besides its [`SeamLine`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SeamData {
    /// Length, part units.
    pub length: f64,
    /// Whether it has edges that no follower gave as a seam.
    pub irregular: bool,
    /// Ends of an open seam, in the order of its path.
    pub ends: Option<[SeamEnd; 2]>,
}

/// What is known of a border besides its
/// [`BorderLine`](crate::surface::BorderLine).
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
    /// Edges inside a sheet that a follower marked as seam or border: the
    /// crease that a fin leaves.
    pub stray_marks: usize,
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
    /// A seam, by its place in
    /// [`MidSurface::seams`](crate::surface::MidSurface::seams).
    Seam(u32),
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
    counts: Counts,
}

impl SheetGraph {
    /// Invariants: one entry of `seams` for each of `lines`, whose sheets are
    /// places in `sheets`.
    pub(super) fn new(
        sheets: Vec<SheetData>,
        seams: Vec<SeamData>,
        lines: &[SeamLine],
        borders: Vec<BorderData>,
        counts: Counts,
    ) -> SheetGraph {
        let mut graph = Graph::new_undirected();
        for n in 0..sheets.len() {
            graph.add_node(Node::Sheet(n as u32));
        }
        for (n, line) in lines.iter().enumerate() {
            let seam = graph.add_node(Node::Seam(n as u32));
            for &sheet in &line.sheets {
                graph.add_edge(NodeIndex::new(sheet as usize), seam, ());
            }
        }
        SheetGraph {
            graph,
            sheets,
            seams,
            borders,
            counts,
        }
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
