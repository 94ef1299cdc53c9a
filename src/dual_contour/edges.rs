//! Crossed edges and their Hermite data (section V of the paper).
//!
//! An edge is crossed where its two nodes lie on different sides (Definition
//! 2). Both ends are valid nodes: values change by at most the distance walked,
//! and where they do not, `settle` saw to it. Each edge, owned by the block of
//! its lower node, is solved once.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::band::Band;
use super::block::{Bits, Block, block_of, local, node_of};
use super::grid::Grid;
use super::implicit::{Crossing, Implicit, Sample};

/// How the crossings were found; Table V of the paper for one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CrossingCounts {
    /// Crossed edges.
    pub edges: u64,
    /// Solved after so many splits of the edge: 0, 1, 2, and so on; the last
    /// counts all beyond.
    pub by_splits: [u64; 8],
    /// Closest-point queries.
    pub queries: u64,
}

impl CrossingCounts {
    fn add(&mut self, crossing: &Crossing) {
        let last = self.by_splits.len() - 1;
        self.edges += 1;
        self.by_splits[usize::from(crossing.splits).min(last)] += 1;
        self.queries += u64::from(crossing.queries);
    }

    fn plus(mut self, other: CrossingCounts) -> CrossingCounts {
        self.edges += other.edges;
        self.queries += other.queries;
        for (sum, n) in self.by_splits.iter_mut().zip(other.by_splits) {
            *sum += n;
        }
        self
    }
}

/// Where the surface crosses an edge, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hermite {
    pub point: DVec3,
    /// Unit outward normal.
    pub normal: DVec3,
    pub element: u32,
}

/// The crossed edges of a block.
#[derive(Clone, Debug)]
pub(super) struct EdgeBlock {
    pub key: IVec3,
    /// By axis: edges from a node upwards that are crossed.
    pub crossed: [Bits; 3],
    /// By axis: nodes inside the solid, as far as their edges are crossed.
    inside: Bits,
    /// Number of the first crossing of each axis.
    start: [u32; 3],
    /// Coordinate along the edge's axis and element, x edges first.
    crossings: Vec<(f64, u32)>,
}

/// All crossed edges.
pub(super) struct Edges {
    /// Sorted by key.
    pub blocks: Vec<EdgeBlock>,
    pub counts: CrossingCounts,
    places: FxHashMap<IVec3, u32>,
}

impl Edges {
    /// Solves every crossed edge of the band.
    pub fn solve(solid: &impl Implicit, grid: &Grid, band: Band) -> Edges {
        let solved: Vec<(EdgeBlock, CrossingCounts)> = band
            .blocks
            .par_iter()
            .filter_map(|block| solve_block(solid, grid, &band, block))
            .collect();
        let counts = solved
            .iter()
            .fold(CrossingCounts::default(), |sum, (_, c)| sum.plus(*c));
        let blocks: Vec<EdgeBlock> = solved.into_iter().map(|(block, _)| block).collect();
        let places = (0..).zip(&blocks).map(|(i, b)| (b.key, i)).collect();
        Edges {
            blocks,
            counts,
            places,
        }
    }

    /// The block with this key; none if no edge of it is crossed.
    pub fn block(&self, key: IVec3) -> Option<&EdgeBlock> {
        self.places.get(&key).map(|&i| &self.blocks[i as usize])
    }
}

impl EdgeBlock {
    /// Whether the node, the lower end of a crossed edge, lies inside.
    pub fn is_inside(&self, local: usize) -> bool {
        self.inside.get(local)
    }

    /// Node with this local number.
    pub fn node(&self, local: usize) -> IVec3 {
        node_of(self.key, local)
    }

    /// Coordinate of the crossing along its axis, and its element, for a crossed
    /// edge.
    pub fn crossing(&self, axis: usize, local: usize) -> (f64, u32) {
        self.crossings[self.start[axis] as usize + self.crossed[axis].rank(local)]
    }

    /// Hermite data of the edge upwards from a node, if it is crossed.
    pub fn hermite(
        &self,
        solid: &impl Implicit,
        grid: &Grid,
        axis: usize,
        local: usize,
    ) -> Option<Hermite> {
        if !self.crossed[axis].get(local) {
            return None;
        }
        let (along, element) = self.crossing(axis, local);
        let mut point = grid.node(self.node(local));
        point[axis] = along;
        let (_, normal) = solid.element(point, element);
        Some(Hermite {
            point,
            normal,
            element,
        })
    }
}

/// A valid node, found again from its element.
///
/// An element does not know on which side of the part a node lies; where that
/// decides, the node is asked for again.
fn end(solid: &impl Implicit, at: DVec3, block: &Block, local: usize) -> Sample {
    let element = block.elements[block.valid.rank(local)];
    let (value, gradient) = solid.element(at, element);
    if (value < 0.0) == block.inside.get(local) {
        Sample {
            value,
            gradient,
            unsigned: value.abs(),
            element,
        }
    } else {
        solid.sample(at, element)
    }
}

fn solve_block(
    solid: &impl Implicit,
    grid: &Grid,
    band: &Band,
    block: &Block,
) -> Option<(EdgeBlock, CrossingCounts)> {
    let mut out = EdgeBlock {
        key: block.key,
        crossed: [Bits::default(); 3],
        inside: Bits::default(),
        start: [0; 3],
        crossings: Vec::new(),
    };
    let mut counts = CrossingCounts::default();
    for axis in 0..3 {
        out.start[axis] = out.crossings.len() as u32;
        let step = IVec3::AXES[axis];
        let beyond = band.place(block.key + step).map(|i| &band.blocks[i]);
        for from in block.valid.ones() {
            let node = node_of(block.key, from);
            let next = node + step;
            let (there, to) = if block_of(next) == block.key {
                (Some(block), local(next))
            } else {
                (beyond, local(next))
            };
            let Some(there) = there.filter(|b| b.valid.get(to)) else {
                continue;
            };
            if block.inside.get(from) == there.inside.get(to) {
                continue;
            }
            let ends = [grid.node(node), grid.node(next)];
            let samples = [
                end(solid, ends[0], block, from),
                end(solid, ends[1], there, to),
            ];
            let crossing = solid.crossing(ends, samples);
            counts.add(&crossing);
            let along = ends[0][axis] + crossing.t * (ends[1][axis] - ends[0][axis]);
            let along = grid.between(axis, [ends[0][axis], ends[1][axis]], along);
            out.crossed[axis].set(from);
            if block.inside.get(from) {
                out.inside.set(from);
            }
            out.crossings.push((along, crossing.element));
        }
    }
    out.crossings.shrink_to_fit();
    (!out.crossings.is_empty()).then_some((out, counts))
}
