//! Which triangles use an edge, and in which direction.

use rayon::slice::ParallelSliceMut;

use super::sets::Sets;
use super::{FaceId, TriMesh};

/// One triangle's use of one undirected edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeUse {
    /// Vertices of the edge, lower index first.
    pub edge: [u32; 2],
    /// The triangle.
    pub face: FaceId,
    /// Whether the triangle runs from `edge[0]` to `edge[1]`.
    pub forward: bool,
}

/// All edge uses of a mesh, sorted by edge, then by triangle.
///
/// Triangles with a repeated corner have no edges here: they close nothing
/// and open nothing.
#[derive(Clone, Debug)]
pub struct EdgeUses {
    uses: Vec<EdgeUse>,
}

/// How often edges of each kind occur.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeCensus {
    /// Edges of one triangle.
    pub open: usize,
    /// Edges of two triangles that run it in opposite directions.
    pub manifold: usize,
    /// Edges of two triangles that run it in the same direction.
    pub misoriented: usize,
    /// Edges of three or more triangles, as many one way as the other.
    pub balanced: usize,
    /// Edges of three or more triangles that do not pair up.
    pub unbalanced: usize,
}

impl EdgeCensus {
    /// Whether every edge is run equally often in both directions.
    pub fn is_closed(&self) -> bool {
        self.open == 0 && self.misoriented == 0 && self.unbalanced == 0
    }
}

/// What the uses of one edge amount to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EdgeKind {
    Open,
    Manifold,
    Misoriented,
    Balanced,
    Unbalanced,
}

/// The kind of an edge from all its uses.
pub(super) fn kind(uses: &[EdgeUse]) -> EdgeKind {
    let forward = uses.iter().filter(|u| u.forward).count();
    let paired = 2 * forward == uses.len();
    match (uses.len(), paired) {
        (0 | 1, _) => EdgeKind::Open,
        (2, true) => EdgeKind::Manifold,
        (2, false) => EdgeKind::Misoriented,
        (_, true) => EdgeKind::Balanced,
        (_, false) => EdgeKind::Unbalanced,
    }
}

impl EdgeUses {
    /// Collects and sorts the edge uses of a mesh.
    pub fn new(mesh: &TriMesh) -> EdgeUses {
        let mut uses = Vec::with_capacity(3 * mesh.triangles.len());
        for (index, &[a, b, c]) in mesh.triangles.iter().enumerate() {
            if a == b || b == c || c == a {
                continue;
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                uses.push(EdgeUse {
                    edge: [from.min(to), from.max(to)],
                    face: FaceId(index as u32),
                    forward: from < to,
                });
            }
        }
        // No two uses are equal, so the order does not depend on threads.
        uses.par_sort_unstable();
        EdgeUses { uses }
    }

    /// One slice an edge, in order of vertex indices.
    pub fn by_edge(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.uses.chunk_by(|a, b| a.edge == b.edge)
    }

    /// Counts of the kinds of edge.
    pub fn census(&self) -> EdgeCensus {
        let mut census = EdgeCensus::default();
        for uses in self.by_edge() {
            *match kind(uses) {
                EdgeKind::Open => &mut census.open,
                EdgeKind::Manifold => &mut census.manifold,
                EdgeKind::Misoriented => &mut census.misoriented,
                EdgeKind::Balanced => &mut census.balanced,
                EdgeKind::Unbalanced => &mut census.unbalanced,
            } += 1;
        }
        census
    }

    /// The first edge of a kind, with its uses.
    pub(super) fn first(&self, wanted: EdgeKind) -> Option<&[EdgeUse]> {
        self.by_edge().find(|uses| kind(uses) == wanted)
    }

    /// Labels triangles that hang together through edges, in order of their
    /// lowest triangle; a triangle with a repeated corner is one by itself.
    ///
    /// Returns the label of each of `face_count` triangles and the number of labels.
    pub fn components(&self, face_count: usize) -> (Vec<u32>, usize) {
        let mut sets = Sets::new(face_count);
        for uses in self.by_edge() {
            for pair in uses.windows(2) {
                sets.join(pair[0].face.0, pair[1].face.0);
            }
        }
        sets.labels()
    }
}

impl TriMesh {
    /// Edge uses of the mesh; indices must be in range.
    pub fn edges(&self) -> EdgeUses {
        EdgeUses::new(self)
    }
}
