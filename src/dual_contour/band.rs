//! The narrow band: the grid nodes near the surface, and on which side they
//! lie (section IV of the paper).
//!
//! Boxes of `box_cells` cells are tested at their centre, and those that may
//! hold a valid node are split in eight down to two cells. A box whose centre
//! has a value beyond `cell + radius of its circumsphere` holds no valid node
//! (Remark 1; with the sign, Remarks 3a and 3b: the bands of a grown and a
//! shrunk offset are told apart by the value itself, overlapping or not,
//! because |value| compares with both at once). A valid node is one whose value
//! is at most a cell from zero (Definition 1), so both ends of every crossed
//! edge are valid; where the function has a step, `settle` sees to that.
//!
//! Two things are ours. A box's centre is a grid node, so that the test of a
//! box of two cells is also the first of its eight nodes, and the others are
//! left out when the centre's value already says that they are not valid. And
//! nodes are kept in blocks of 8 x 8 x 8: a bit a node for side and validity,
//! and four bytes for each valid one, so memory grows with the surface.
//! A node belongs to the box of which it is not on an upper face; what that box
//! says of it holds.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use serde::Serialize;
use smallvec::SmallVec;

use super::block::{Bits, Block, SIDE, block_of, local};
use super::grid::Grid;
use super::implicit::{Implicit, Sample};
use crate::settings::progress::{Stop, Stopped};

/// Which filters are on; all of them, except to measure what each is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filters {
    /// Cells along a box of the bounding box filter: 8 to 1024, other numbers count as the
    /// next power of two of these.
    pub box_cells: i32,
    /// Use the side of the box's centre.
    pub signed: bool,
    /// Split boxes that stay.
    pub octree: bool,
}

impl Default for Filters {
    fn default() -> Filters {
        Filters {
            box_cells: 32,
            signed: true,
            octree: true,
        }
    }
}

impl Filters {
    /// Cells along a box, a power of two, one block or more.
    fn box_side(&self) -> i32 {
        let wanted = self.box_cells.clamp(SIDE, 1024);
        wanted.unsigned_abs().next_power_of_two().cast_signed()
    }
}

/// How many nodes each filter left; Table IV of the paper for one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct FilterCounts {
    /// Nodes of the whole grid.
    pub nodes: u64,
    /// Nodes in boxes that the bounding box filter left.
    pub after_boxes: u64,
    /// Of these, nodes in boxes that the signed distance filter left.
    pub after_signs: u64,
    /// Distance computations in all, with those that tested boxes: what the
    /// octree filter left.
    pub distances: u64,
    /// Of these, tests of boxes whose centre was not needed as a node.
    pub box_tests: u64,
    /// Nodes within a cell of the surface.
    pub valid: u64,
}

/// Whether a node is not on the rim of the grid, where everything is outside.
pub(super) fn is_within(node: IVec3, last: IVec3) -> bool {
    node.cmpgt(IVec3::ZERO).all() && node.cmplt(last).all()
}

/// The valid nodes.
pub(super) struct Band {
    /// Sorted by key; each has at least one valid node.
    pub blocks: Vec<Block>,
    pub counts: FilterCounts,
    places: FxHashMap<IVec3, u32>,
}

impl Band {
    /// Evaluates the function around its zero set. `tick` is called with boxes
    /// done and boxes in all.
    pub fn build(
        solid: &impl Implicit,
        grid: &Grid,
        filters: Filters,
        tick: impl Fn(u64, u64) + Sync,
        stop: &Stop,
    ) -> Result<Band, Stopped> {
        let side = filters.box_side();
        let nodes = grid.cells() + 1;
        let boxes = (nodes + side - 1) / side;
        let total = boxes.as_i64vec3().element_product() as u64;
        let done = AtomicU64::new(0);
        let tallies = Tallies::default();
        let parts: Result<Vec<Vec<Block>>, Stopped> = (0..total)
            .into_par_iter()
            .map(|i| {
                stop.heed()?;
                let i = i as i64;
                let (x, y) = (i64::from(boxes.x), i64::from(boxes.y));
                let place = IVec3::new((i % x) as i32, (i / x % y) as i32, (i / (x * y)) as i32);
                let mut search = Search {
                    solid,
                    grid,
                    filters,
                    nodes,
                    counts: FilterCounts::default(),
                    blocks: Vec::new(),
                };
                search.top_box(place * side);
                tallies.add(&search.counts);
                tick(done.fetch_add(1, Ordering::Relaxed) + 1, total);
                Ok(search.blocks)
            })
            .collect();
        let mut counts = tallies.total();
        counts.nodes = nodes.as_i64vec3().element_product() as u64;
        let mut band = Band {
            blocks: parts?.into_iter().flatten().collect(),
            counts,
            places: FxHashMap::default(),
        };
        band.sort();
        band.counts.distances += band.settle(solid, grid);
        Ok(band)
    }

    /// Puts the blocks in order.
    pub fn sort(&mut self) {
        self.blocks.par_sort_unstable_by_key(|b| b.key.to_array());
        let places = (0..).zip(&self.blocks).map(|(i, b)| (b.key, i));
        self.places = places.collect();
    }

    /// Place of a block in `blocks`.
    pub fn place(&self, key: IVec3) -> Option<usize> {
        self.places.get(&key).map(|&i| i as usize)
    }
}

/// Sums over boxes, which end in any order.
#[derive(Default)]
struct Tallies([AtomicU64; 5]);

impl Tallies {
    fn add(&self, c: &FilterCounts) {
        let each = [
            c.after_boxes,
            c.after_signs,
            c.distances,
            c.box_tests,
            c.valid,
        ];
        for (sum, n) in self.0.iter().zip(each) {
            sum.fetch_add(n, Ordering::Relaxed);
        }
    }

    fn total(self) -> FilterCounts {
        let [after_boxes, after_signs, distances, box_tests, valid] =
            self.0.map(AtomicU64::into_inner);
        FilterCounts {
            nodes: 0,
            after_boxes,
            after_signs,
            distances,
            box_tests,
            valid,
        }
    }
}

/// The search of one box of the bounding box filter.
struct Search<'a, I> {
    solid: &'a I,
    grid: &'a Grid,
    filters: Filters,
    /// Nodes along each axis.
    nodes: IVec3,
    counts: FilterCounts,
    blocks: Vec<Block>,
}

/// A block being filled.
struct Fill {
    block: Block,
    /// Local number and element of the valid nodes, in the order found.
    found: Vec<(u16, u32)>,
    /// The grid's last node.
    last: IVec3,
}

impl<I: Implicit> Search<'_, I> {
    /// Nodes of a box, those beyond the grid left out.
    fn nodes_in(&self, low: IVec3, side: i32) -> u64 {
        let high = (low + side).min(self.nodes);
        (high - low).max(IVec3::ZERO).as_i64vec3().element_product() as u64
    }

    fn sample(&mut self, at: IVec3, hint: u32) -> Sample {
        self.counts.distances += 1;
        self.solid.sample(self.grid.node(at), hint)
    }

    /// Greatest value of a valid node: a cell, and what the rounding of the
    /// planes may add.
    fn width(&self) -> f64 {
        1.011 * self.grid.cell()
    }

    /// Greatest value at a box's centre with a valid node in the box: the
    /// circumsphere and a cell more.
    ///
    /// A box may stand over the grid's rim; its centre is then taken to the
    /// rim, and nodes beyond do not count.
    fn reach(&self, low: IVec3, side: i32) -> f64 {
        let centre = self.grid.node(low + side / 2);
        let below = centre - self.grid.node(low);
        let above = self.grid.node(low + side) - centre;
        self.width() + below.max(above).length()
    }

    fn top_box(&mut self, low: IVec3) {
        let side = self.filters.box_side();
        let centre = self.sample(low + side / 2, 0);
        self.counts.box_tests += 1;
        let reach = self.reach(low, side);
        if centre.unsigned > reach {
            return;
        }
        self.counts.after_boxes += self.nodes_in(low, side);
        if self.filters.signed && centre.value.abs() > reach {
            return;
        }
        self.counts.after_signs += self.nodes_in(low, side);
        self.outer(low, side, centre.element);
    }

    /// Nodes may be valid in this box of a block or more.
    fn outer(&mut self, low: IVec3, side: i32, hint: u32) {
        if side == SIDE {
            return self.fill(low, hint);
        }
        for low in eighths(low, side) {
            if low.cmpge(self.nodes).any() {
                continue;
            }
            let mut hint = hint;
            if self.filters.octree {
                let centre = self.sample(low + side / 4, hint);
                self.counts.box_tests += 1;
                if self.far(&centre) > self.reach(low, side / 2) {
                    continue;
                }
                hint = centre.element;
            }
            self.outer(low, side / 2, hint);
        }
    }

    /// How far the filters that are on know the value to be from zero.
    fn far(&self, sample: &Sample) -> f64 {
        if self.filters.signed {
            sample.value.abs()
        } else {
            sample.unsigned
        }
    }

    fn fill(&mut self, low: IVec3, hint: u32) {
        let mut fill = Fill {
            block: Block {
                key: block_of(low),
                valid: Bits::default(),
                inside: Bits::default(),
                elements: Vec::new(),
            },
            found: Vec::new(),
            last: self.nodes - 1,
        };
        for low in eighths(low, SIDE) {
            self.inner(&mut fill, low, SIDE / 2, hint);
        }
        if !fill.found.is_empty() {
            fill.found.sort_unstable();
            fill.block.elements = fill.found.iter().map(|&(_, element)| element).collect();
            self.counts.valid += fill.found.len() as u64;
            self.blocks.push(fill.block);
        }
    }

    /// A box within a block.
    fn inner(&mut self, fill: &mut Fill, low: IVec3, side: i32, hint: u32) {
        if low.cmpge(self.nodes).any() {
            return;
        }
        if !self.filters.octree {
            for node in box_nodes(low, side) {
                self.node(fill, node, hint);
            }
            return;
        }
        let at = (low + side / 2).min(self.nodes - 1);
        let centre = self.sample(at, hint);
        if self.far(&centre) > self.reach(low, side) {
            self.counts.box_tests += 1;
            for node in box_nodes(low, side) {
                fill.side(node, centre.value);
            }
        } else if side > 2 {
            self.counts.box_tests += 1;
            for low in eighths(low, side) {
                self.inner(fill, low, side / 2, centre.element);
            }
        } else {
            // Each value bounds those of the nodes around it.
            let mut known = SmallVec::<[(DVec3, f64); 8]>::new();
            known.push((self.grid.node(at), centre.value));
            fill.node(at, &centre, self.width());
            for node in box_nodes(low, side).filter(|&node| node != at) {
                let p = self.grid.node(node);
                let bound = |&(q, value): &(DVec3, f64)| value.abs() - p.distance(q);
                let tightest = known.iter().find(|k| bound(k) > self.width());
                if let Some((_, value)) = tightest {
                    fill.side(node, *value);
                } else if node.cmplt(self.nodes).all() {
                    let sample = self.sample(node, centre.element);
                    known.push((p, sample.value));
                    fill.node(node, &sample, self.width());
                }
            }
        }
    }

    fn node(&mut self, fill: &mut Fill, node: IVec3, hint: u32) {
        if node.cmplt(self.nodes).all() {
            let sample = self.sample(node, hint);
            fill.node(node, &sample, self.width());
        }
    }
}

impl Fill {
    fn side(&mut self, node: IVec3, value: f64) {
        if value < 0.0 && is_within(node, self.last) {
            self.block.inside.set(local(node));
        }
    }

    fn node(&mut self, node: IVec3, sample: &Sample, width: f64) {
        self.side(node, sample.value);
        if sample.value.abs() <= width {
            self.block.valid.set(local(node));
            self.found.push((local(node) as u16, sample.element));
        }
    }
}

/// Low corners of the eight halves of a box.
fn eighths(low: IVec3, side: i32) -> impl Iterator<Item = IVec3> {
    box_nodes(IVec3::ZERO, 2).map(move |corner| low + corner * (side / 2))
}

/// Nodes that belong to a box, x fastest.
fn box_nodes(low: IVec3, side: i32) -> impl Iterator<Item = IVec3> {
    (0..side).flat_map(move |z| {
        (0..side).flat_map(move |y| (0..side).map(move |x| low + IVec3::new(x, y, z)))
    })
}
