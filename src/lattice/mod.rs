//! The cubic lattice, six tetrahedra a cell (Bloomenthal 2011, section 3).
//!
//! A cell is cut along its main diagonal (Kuhn's subdivision): each
//! tetrahedron is a monotone walk from the cell's low node to its high node
//! that steps once along each axis. Every simplex is therefore a start node
//! and one or more *steps*, disjoint sets of axes, and is named by an integer
//! that all its neighbours compute alike:
//!
//! ```text
//!   edge   n -> n+s                    7 a node
//!   face   n -> n+s -> n+s+r          12 a node
//!   tetra  n -> n+a -> n+a+b -> n+xyz  6 a node (a, b single axes)
//! ```
//!
//! Nothing here knows what is stored under a name.

mod boxes;

use glam::{DVec3, IVec3};

pub use boxes::CellBox;

/// Bits of one node coordinate inside a key.
const COORDINATE_BITS: u32 = 19;
const COORDINATE_MASK: u64 = (1 << COORDINATE_BITS) - 1;

/// Largest number of cells along one axis that a key can name.
pub const MAX_CELLS_PER_AXIS: u32 = (1 << COORDINATE_BITS) - 4;

/// A set of lattice axes: bit 0 is x, bit 1 is y, bit 2 is z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Axes(u8);

impl Axes {
    const ALL: Axes = Axes(7);

    fn offset(self) -> IVec3 {
        IVec3::new(
            (self.0 & 1) as i32,
            (self.0 >> 1 & 1) as i32,
            (self.0 >> 2 & 1) as i32,
        )
    }

    fn union(self, other: Axes) -> Axes {
        Axes(self.0 | other.0)
    }

    fn complement(self) -> Axes {
        Axes(!self.0 & 7)
    }

    fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Non-empty proper subsets, in increasing order.
    fn proper_subsets(self) -> impl Iterator<Item = Axes> {
        (1..self.0).filter(move |m| m & !self.0 == 0).map(Axes)
    }

    /// Non-empty subsets, itself included.
    fn subsets(self) -> impl Iterator<Item = Axes> {
        (1..=self.0).filter(move |m| m & !self.0 == 0).map(Axes)
    }
}

/// A lattice point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeKey(u64);

impl NodeKey {
    fn new(at: IVec3) -> NodeKey {
        debug_assert!(at.min_element() >= 0 && (at.max_element() as u64) <= COORDINATE_MASK);
        let pack = |v: i32| v as u64 & COORDINATE_MASK;
        NodeKey(pack(at.z) << (2 * COORDINATE_BITS) | pack(at.y) << COORDINATE_BITS | pack(at.x))
    }

    fn coordinates(self) -> IVec3 {
        let part = |k: u32| (self.0 >> (k * COORDINATE_BITS) & COORDINATE_MASK) as i32;
        IVec3::new(part(0), part(1), part(2))
    }

    fn step(self, axes: Axes) -> NodeKey {
        NodeKey::new(self.coordinates() + axes.offset())
    }

    /// The node behind; none beyond the low side of the lattice.
    fn back(self, axes: Axes) -> Option<NodeKey> {
        let at = self.coordinates() - axes.offset();
        (at.min_element() >= 0).then(|| NodeKey::new(at))
    }
}

/// A lattice edge; all tetrahedra round it find the same crossings under it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EdgeKey(u64);

impl EdgeKey {
    /// Its name as a number, for files.
    pub fn to_bits(self) -> u64 {
        self.0
    }

    /// The edge of a number; of one that [`EdgeKey::to_bits`] never gave, one
    /// that no lattice has.
    pub fn from_bits(bits: u64) -> EdgeKey {
        EdgeKey(bits)
    }

    fn new(start: NodeKey, step: Axes) -> EdgeKey {
        EdgeKey(start.0 << 3 | step.0 as u64)
    }

    fn parts(self) -> (NodeKey, Axes) {
        (NodeKey(self.0 >> 3), Axes((self.0 & 7) as u8))
    }

    /// The two ends, low node first.
    pub fn nodes(self) -> [NodeKey; 2] {
        let (n, s) = self.parts();
        [n, n.step(s)]
    }

    /// Every face that has this edge: four or six of them, fewer on the low
    /// side of the lattice.
    pub fn faces(self) -> impl Iterator<Item = FaceKey> {
        let (n, s) = self.parts();
        let rest = s.complement();
        let first = rest.subsets().map(move |r| FaceKey::new(n, s, r));
        let second = rest
            .subsets()
            .filter_map(move |r| Some(FaceKey::new(n.back(r)?, r, s)));
        let long = s
            .proper_subsets()
            .map(move |p| FaceKey::new(n, p, Axes(s.0 & !p.0)));
        first.chain(second).chain(long)
    }
}

/// A triangle between two tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceKey(u64);

impl FaceKey {
    /// Its name as a number, for files.
    pub fn to_bits(self) -> u64 {
        self.0
    }

    /// The face of a number; of one that [`FaceKey::to_bits`] never gave, one
    /// that no lattice has.
    pub fn from_bits(bits: u64) -> FaceKey {
        FaceKey(bits)
    }

    fn new(start: NodeKey, first: Axes, second: Axes) -> FaceKey {
        FaceKey(start.0 << 6 | (first.0 as u64) << 3 | second.0 as u64)
    }

    fn parts(self) -> (NodeKey, Axes, Axes) {
        (
            NodeKey(self.0 >> 6),
            Axes((self.0 >> 3 & 7) as u8),
            Axes((self.0 & 7) as u8),
        )
    }

    /// The three corners, in the order of the walk.
    pub fn nodes(self) -> [NodeKey; 3] {
        let (n, a, b) = self.parts();
        [n, n.step(a), n.step(a.union(b))]
    }

    /// The three edges; edge `i` lies opposite corner `(i + 2) % 3`, that is
    /// it joins corners `i` and `(i + 1) % 3`.
    pub fn edges(self) -> [EdgeKey; 3] {
        let (n, a, b) = self.parts();
        [
            EdgeKey::new(n, a),
            EdgeKey::new(n.step(a), b),
            EdgeKey::new(n, a.union(b)),
        ]
    }

    /// The two tetrahedra that share this face; one on the low side of the lattice.
    pub fn tetrahedra(self) -> impl Iterator<Item = TetKey> {
        let (n, a, b) = self.parts();
        let rest = a.union(b).complement();
        let (first, second) = if rest.is_empty() {
            // One of the two steps is a pair of axes, walked in either order.
            let pair = if a.0.count_ones() == 2 { a } else { b };
            let low = Axes(pair.0 & pair.0.wrapping_neg());
            let high = Axes(pair.0 & !low.0);
            if pair == a {
                (TetKey::new(n, low, high), Some(TetKey::new(n, high, low)))
            } else {
                (TetKey::new(n, a, low), Some(TetKey::new(n, a, high)))
            }
        } else {
            let behind = n.back(rest).map(|n| TetKey::new(n, rest, a));
            (TetKey::new(n, a, b), behind)
        };
        std::iter::once(first).chain(second)
    }
}

/// A tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TetKey(u64);

impl TetKey {
    fn new(start: NodeKey, first: Axes, second: Axes) -> TetKey {
        debug_assert!(first.0.count_ones() == 1 && second.0.count_ones() == 1 && first != second);
        TetKey(start.0 << 6 | (first.0 as u64) << 3 | second.0 as u64)
    }

    fn parts(self) -> (NodeKey, Axes, Axes, Axes) {
        let (a, b) = (Axes((self.0 >> 3 & 7) as u8), Axes((self.0 & 7) as u8));
        (NodeKey(self.0 >> 6), a, b, a.union(b).complement())
    }

    /// The four corners, in the order of the walk.
    pub fn nodes(self) -> [NodeKey; 4] {
        let (n, a, b, _) = self.parts();
        [n, n.step(a), n.step(a.union(b)), n.step(Axes::ALL)]
    }

    /// The four faces; face `i` lies opposite corner `i`.
    pub fn faces(self) -> [FaceKey; 4] {
        let (n, a, b, c) = self.parts();
        [
            FaceKey::new(n.step(a), b, c),
            FaceKey::new(n, a.union(b), c),
            FaceKey::new(n, a, b.union(c)),
            FaceKey::new(n, a, b),
        ]
    }

    /// The six edges.
    pub fn edges(self) -> [EdgeKey; 6] {
        let (n, a, b, c) = self.parts();
        [
            EdgeKey::new(n, a),
            EdgeKey::new(n.step(a), b),
            EdgeKey::new(n.step(a.union(b)), c),
            EdgeKey::new(n, a.union(b)),
            EdgeKey::new(n.step(a), b.union(c)),
            EdgeKey::new(n, Axes::ALL),
        ]
    }

    /// Low node of the cell that holds this tetrahedron.
    pub fn cell(self) -> NodeKey {
        self.parts().0
    }

    /// The six of a cell.
    fn of_cell(cell: IVec3) -> impl Iterator<Item = TetKey> {
        let axes = [Axes(1), Axes(2), Axes(4)];
        let pairs = axes.into_iter().flat_map(move |a| axes.map(|b| (a, b)));
        (pairs.filter(|(a, b)| a != b)).map(move |(a, b)| TetKey::new(NodeKey::new(cell), a, b))
    }

    /// Its name as a number, for files.
    pub fn to_bits(self) -> u64 {
        self.0
    }

    /// The tetrahedron of a number; of one that [`TetKey::to_bits`] never gave,
    /// one that no lattice has.
    pub fn from_bits(bits: u64) -> TetKey {
        TetKey(bits)
    }

    /// The block of cells that holds it, for blocks of `2^bits` cells an edge.
    pub fn block(self, bits: u32) -> BlockKey {
        let at = self.cell().coordinates();
        BlockKey(NodeKey::new(IVec3::new(
            at.x >> bits,
            at.y >> bits,
            at.z >> bits,
        )))
    }
}

/// A cube of cells, so many along each edge as whoever names it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BlockKey(NodeKey);

/// Where the lattice lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    origin: DVec3,
    cell: f64,
}

impl Lattice {
    /// Covers the box `low..high` with cells of edge `cell`, one cell of margin.
    ///
    /// CAD parts are aligned with the axes and their mid-planes love lattice
    /// planes. The origin is therefore shifted by fixed fractions of a cell,
    /// so chosen that neither they nor their differences (the diagonal faces)
    /// are near a simple ratio.
    ///
    /// Returns `None` where the box needs more than [`MAX_CELLS_PER_AXIS`].
    pub fn covering(low: DVec3, high: DVec3, cell: f64) -> Option<Lattice> {
        const SHIFT: DVec3 = DVec3::new(0.381_966_011, 0.745_213_729, 0.173_648_178);
        let cells = (high - low) / cell;
        let most = cells.max_element() + 4.0;
        if most.is_nan() || most >= MAX_CELLS_PER_AXIS as f64 {
            return None;
        }
        Some(Lattice {
            origin: low - (SHIFT + 1.0) * cell,
            cell,
        })
    }

    /// Edge length of a cell, in part units.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Low corner of a cell.
    fn corner(&self, cell: IVec3) -> DVec3 {
        self.origin + cell.as_dvec3() * self.cell
    }

    /// Position of a node.
    pub fn position(&self, node: NodeKey) -> DVec3 {
        self.origin + node.coordinates().as_dvec3() * self.cell
    }

    /// The tetrahedron that holds a point of the covered box.
    pub fn locate(&self, p: DVec3) -> TetKey {
        let local = (p - self.origin) / self.cell;
        let base = local.floor().max(DVec3::ZERO);
        let f = local - base;
        // The walk steps along the largest fraction first.
        let mut axes = [(f.x, Axes(1)), (f.y, Axes(2)), (f.z, Axes(4))];
        axes.sort_by(|a, b| b.0.total_cmp(&a.0));
        TetKey::new(NodeKey::new(base.as_ivec3()), axes[0].1, axes[1].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn some_tetrahedra() -> Vec<TetKey> {
        let n = NodeKey::new(IVec3::new(5, 9, 3));
        let axes = [Axes(1), Axes(2), Axes(4)];
        let mut out = Vec::new();
        for a in axes {
            for b in axes {
                if a != b {
                    out.push(TetKey::new(n, a, b));
                }
            }
        }
        out
    }

    #[test]
    fn six_tetrahedra_fill_a_cell() {
        let lattice = Lattice {
            origin: DVec3::ZERO,
            cell: 2.0,
        };
        let volume: f64 = some_tetrahedra()
            .iter()
            .map(|t| {
                let [a, b, c, d] = t.nodes().map(|n| lattice.position(n));
                (b - a).cross(c - a).dot(d - a).abs() / 6.0
            })
            .sum();
        assert!((volume - 8.0).abs() < 1e-12);
    }

    #[test]
    fn faces_and_tetrahedra_name_each_other() {
        for t in some_tetrahedra() {
            for (i, f) in t.faces().into_iter().enumerate() {
                assert!(f.tetrahedra().any(|other| other == t));
                let corners: BTreeSet<_> = f.nodes().into_iter().collect();
                let nodes = t.nodes();
                assert!(
                    !corners.contains(&nodes[i]),
                    "face {i} lies opposite corner {i}"
                );
                assert!(corners.iter().all(|c| nodes.contains(c)));
                for other in f.tetrahedra() {
                    assert!(other.faces().contains(&f));
                }
            }
        }
    }

    #[test]
    fn edges_join_their_corners_and_know_their_faces() {
        for t in some_tetrahedra() {
            for f in t.faces() {
                for (i, e) in f.edges().into_iter().enumerate() {
                    assert!(t.edges().contains(&e));
                    let corners = f.nodes();
                    let mut want = match i {
                        0 => [corners[0], corners[1]],
                        1 => [corners[1], corners[2]],
                        _ => [corners[0], corners[2]],
                    };
                    want.sort();
                    let mut got = e.nodes();
                    got.sort();
                    assert_eq!(got, want);
                    let faces: Vec<_> = e.faces().collect();
                    assert!(faces.contains(&f));
                    assert!(faces.iter().all(|g| g.edges().contains(&e)));
                    assert_eq!(faces.iter().collect::<BTreeSet<_>>().len(), faces.len());
                }
            }
        }
    }

    #[test]
    fn a_point_is_located_in_a_tetrahedron_that_holds_it() {
        let lattice = Lattice::covering(DVec3::ZERO, DVec3::splat(10.0), 0.7).unwrap();
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..1000 {
            let p = DVec3::new(random(), random(), random()) * 10.0;
            let [a, b, c, d] = lattice.locate(p).nodes().map(|n| lattice.position(n));
            let m = glam::DMat3::from_cols(b - a, c - a, d - a).inverse() * (p - a);
            assert!(m.min_element() > -1e-12 && m.element_sum() < 1.0 + 1e-12);
        }
    }

    #[test]
    fn a_lattice_too_fine_for_its_keys_is_refused() {
        assert!(Lattice::covering(DVec3::ZERO, DVec3::splat(1.0), 1e-9).is_none());
        assert!(Lattice::covering(DVec3::ZERO, DVec3::splat(1.0), f64::NAN).is_none());
    }
}
