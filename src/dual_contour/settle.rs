//! Sides without gaps, whatever the function.
//!
//! The filters tell the sides of most nodes from a value near by. That is right
//! for a function that changes by at most the way; but a solid made of pieces
//! may have a step where one ends, and then nodes of different sides can be
//! neighbours without being valid. They are asked for themselves here, and so
//! are the nodes around such an edge that lie in no block yet, until nothing is
//! missing: every edge between different sides has two valid ends, and the
//! corners of all cells around it are known. The contour of such sides is
//! closed. A function that keeps its promise has none of this to do.

use glam::IVec3;
use rayon::prelude::*;

use super::band::{Band, is_within};
use super::block::{Block, SIDE, block_of, layer, local, node_of};
use super::grid::Grid;
use super::implicit::Implicit;

/// What a block lacks.
#[derive(Default)]
struct Lack {
    /// Nodes at an edge between different sides that are not valid.
    nodes: Vec<IVec3>,
    /// Blocks around such an edge that are not there.
    blocks: Vec<IVec3>,
}

impl Band {
    /// Asks for what is missing; how many queries that took.
    pub fn settle(&mut self, solid: &impl Implicit, grid: &Grid) -> u64 {
        let mut asked = 0;
        loop {
            let lack: Vec<Lack> = self.blocks.par_iter().map(|b| self.lack(b)).collect();
            let mut nodes: Vec<IVec3> = lack.iter().flat_map(|l| &l.nodes).copied().collect();
            let mut keys: Vec<IVec3> = lack.iter().flat_map(|l| &l.blocks).copied().collect();
            if nodes.is_empty() && keys.is_empty() {
                return asked;
            }
            keys.sort_unstable_by_key(IVec3::to_array);
            keys.dedup();
            // Of a new block every node is asked for.
            for key in keys {
                self.blocks.push(Block::empty(key));
                nodes.extend((0..SIDE.pow(3) as usize).map(|at| node_of(key, at)));
            }
            self.sort();
            let rim = grid.cells();
            nodes.retain(|node| node.cmpge(IVec3::ZERO).all() && node.cmple(rim).all());
            nodes.sort_unstable_by_key(IVec3::to_array);
            nodes.dedup();
            asked += nodes.len() as u64;
            let samples: Vec<_> = nodes
                .par_iter()
                .map(|&node| solid.sample(grid.node(node), self.near(node)))
                .collect();
            for (&node, sample) in nodes.iter().zip(&samples) {
                if let Some(place) = self.place(block_of(node)) {
                    let inside = sample.value < 0.0 && is_within(node, rim);
                    self.blocks[place].learn(local(node), inside, sample.element);
                }
            }
        }
    }

    /// An element likely near a node.
    fn near(&self, node: IVec3) -> u32 {
        let block = self.place(block_of(node)).map(|i| &self.blocks[i]);
        block.and_then(|b| b.elements.first().copied()).unwrap_or(0)
    }

    fn lack(&self, block: &Block) -> Lack {
        let mut lack = Lack::default();
        let at = |key: IVec3| self.place(key).map(|i| &self.blocks[i]);
        for axis in 0..3 {
            let beyond = at(block.key + IVec3::AXES[axis]);
            let next = block.inside.step_down(beyond.map(|b| &b.inside), axis);
            // By lower node. Into a block that is not there leads no crossed
            // edge: what it lacks is on the side of its neighbour.
            let mut crossed = block.inside.xor(&next);
            if beyond.is_none() {
                crossed = crossed.without(&layer(axis, true));
            }
            if crossed.is_empty() {
                continue;
            }
            let valid_next = block.valid.step_down(beyond.map(|b| &b.valid), axis);
            for lower in crossed.without(&block.valid).ones() {
                lack.nodes.push(node_of(block.key, lower));
            }
            for lower in crossed.without(&valid_next).ones() {
                lack.nodes
                    .push(node_of(block.key, lower) + IVec3::AXES[axis]);
            }
            // The cells around an edge reach one node to either side of it.
            let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
            for side in (-1..=1).flat_map(|j| (-1..=1).map(move |k| [j, k])) {
                let mut reaching = crossed;
                for (across, side) in [b, c].into_iter().zip(side) {
                    if side != 0 {
                        reaching = reaching.and(&layer(across, side > 0));
                    }
                }
                for along in 0..2 {
                    let last = layer(axis, true);
                    if along == 1 {
                        reaching = reaching.and(&last);
                    }
                    let mut key = block.key;
                    key[axis] += along;
                    key[b] += side[0];
                    key[c] += side[1];
                    if !reaching.is_empty() && self.place(key).is_none() {
                        lack.blocks.push(key);
                    }
                }
            }
        }
        lack
    }
}
