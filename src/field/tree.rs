//! Eight-wide bounding volume tree over triangles, and the pruned descent.
//!
//! obvhs builds a binary tree by surface area; it is then collapsed into nodes
//! of eight children whose boxes lie side by side, so that one loop over eight
//! lanes measures them all.
//!
//! # Why the pruning is safe
//!
//! Boxes are f32 in *tree units*: part units, minus the part's centre, times a
//! power of two that brings the part into `[-1, 1]`. Every box is rounded
//! outward. A query point is rounded once to f32, which moves it by at most
//! [`Query::slack`]; the box distance is then computed with a relative error of
//! a few `2^-24`. A limit made by [`Query::limit`] adds the slack and a relative
//! margin of `1e-6`, so a box is passed over only when each of its triangles is
//! truly farther than the limit.

use std::ops::Range;

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;

use super::triangle::Triangle;

/// Children a node.
pub(super) const WIDTH: usize = 8;

/// Triangles a leaf holds at most.
const LEAF: u32 = 4;

/// One f32 for each child of a node.
pub(super) type Lanes = [f32; WIDTH];

/// Part units to tree units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub centre: DVec3,
    /// Power of two: multiplying by it is exact.
    pub scale: f64,
}

impl Frame {
    /// Frame of the box `low..high`; any finite frame for an empty box.
    pub fn new(low: DVec3, high: DVec3) -> Frame {
        let centre = (low + high) * 0.5;
        let half = (high - low).max_element() * 0.5;
        if !centre.is_finite() || !half.is_finite() {
            return Frame {
                centre: DVec3::ZERO,
                scale: 1.0,
            };
        }
        let exponent = half.max(1e-290).log2().ceil();
        Frame {
            centre,
            scale: (-exponent).exp2(),
        }
    }

    #[inline]
    pub fn to_tree(self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.scale
    }
}

/// A query point in tree units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    p: [f32; 3],
    /// How far rounding may have moved the point and the boxes.
    slack: f64,
    scale: f64,
}

impl Query {
    #[inline]
    pub fn new(frame: Frame, p: DVec3) -> Query {
        let local = frame.to_tree(p);
        Query {
            p: [local.x as f32, local.y as f32, local.z as f32],
            // Three coordinates, each rounded by 2^-24 of itself: sqrt(3) 2^-24
            // < 2^-23 of the greatest. 1e-15 covers the f64 steps before.
            slack: local.abs().max_element() * 1.2e-7 + 1e-15,
            scale: frame.scale,
        }
    }

    /// Squared limit in tree units that keeps every triangle at a distance of
    /// at most `distance` (part units).
    #[inline]
    pub fn limit(&self, distance: f64) -> f32 {
        let reach = distance * self.scale + self.slack;
        // The last factor covers the rounding to f32 as well.
        (reach * reach * (1.0 + 4e-6)) as f32
    }
}

/// Where a child slot of a node leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

const LEAF_BIT: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;

impl Child {
    pub const EMPTY: Child = Child(u32::MAX);

    fn node(index: usize) -> Child {
        Child(index as u32)
    }

    fn leaf(first: usize, count: usize) -> Child {
        Child(LEAF_BIT | ((count as u32 - 1) << COUNT_SHIFT) | first as u32)
    }

    #[inline]
    pub fn is_leaf(self) -> bool {
        self.0 & LEAF_BIT != 0
    }

    /// Index of the node.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Triangle slots of the leaf.
    #[inline]
    pub fn slots(self) -> Range<usize> {
        let first = (self.0 & ((1 << COUNT_SHIFT) - 1)) as usize;
        let count = ((self.0 & !LEAF_BIT) >> COUNT_SHIFT) as usize + 1;
        first..first + count
    }
}

/// Eight boxes and where they lead; 256 bytes.
///
/// Empty slots come last, with a box that nothing meets.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    pub low: [Lanes; 3],
    pub high: [Lanes; 3],
    pub child: [Child; WIDTH],
}

impl Node {
    fn empty() -> Node {
        Node {
            low: [[f32::INFINITY; WIDTH]; 3],
            high: [[f32::NEG_INFINITY; WIDTH]; 3],
            child: [Child::EMPTY; WIDTH],
        }
    }

    /// Squared distances from `p` to the eight boxes.
    #[inline]
    fn squares(&self, p: [f32; 3]) -> Lanes {
        let mut squares = [0.0; WIDTH];
        for ((low, high), x) in self.low.iter().zip(&self.high).zip(p) {
            for lane in 0..WIDTH {
                let gap = (low[lane] - x).max(x - high[lane]).max(0.0);
                squares[lane] += gap * gap;
            }
        }
        squares
    }
}

/// Nodes still to visit. Each visit takes one and adds at most eight, so the
/// stack holds at most `7 depth + 1`: 64 inline entries serve a depth of nine
/// full levels, and a deeper tree spills to the heap instead of failing.
type Stack = SmallVec<[(f32, Child); 64]>;

/// The tree. Node 0 is the root; children stand after their parents.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
}

impl Tree {
    /// Builds the tree over `triangles`, and sorts them into leaf order.
    ///
    /// Leaf slots are places in the returned order plus `first_slot`.
    pub fn build(triangles: &mut Vec<Triangle>, frame: Frame, first_slot: usize) -> Tree {
        if triangles.is_empty() {
            return Tree::default();
        }
        let boxes: Vec<Aabb> = triangles.iter().map(|t| padded_box(t, frame)).collect();
        let binary = binary_tree(&boxes);
        let mut build = Build {
            counts: subtree_counts(&binary),
            binary: &binary,
            order: Vec::with_capacity(triangles.len()),
            nodes: Vec::new(),
            first_slot,
        };
        build.add_root();
        let Build { order, nodes, .. } = build;
        *triangles = order
            .iter()
            .map(|&i| triangles[i as usize].clone())
            .collect();
        Tree { nodes }
    }

    /// Visits the leaves whose box is within `limit` (squared, tree units),
    /// near ones first. `visit` gets the leaf's slots and returns the limit
    /// from there on.
    #[inline]
    pub fn descend(
        &self,
        query: &Query,
        mut limit: f32,
        mut visit: impl FnMut(Range<usize>) -> f32,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = Stack::new();
        stack.push((0.0, Child::node(0)));
        while let Some((square, child)) = stack.pop() {
            // Written so that a square that is not a number is visited.
            if square > limit {
                continue;
            }
            if child.is_leaf() {
                limit = visit(child.slots());
                continue;
            }
            let node = &self.nodes[child.index()];
            let squares = node.squares(query.p);
            let bottom = stack.len();
            for (lane, &square) in squares.iter().enumerate() {
                let child = node.child[lane];
                if square <= limit && child != Child::EMPTY {
                    // Insertion sort, nearest on top.
                    stack.push((square, child));
                    let mut i = stack.len() - 1;
                    while i > bottom && stack[i - 1].0 < square {
                        stack[i] = stack[i - 1];
                        i -= 1;
                    }
                    stack[i] = (square, child);
                }
            }
        }
    }
}

/// Box of a triangle in tree units, rounded outward.
fn padded_box(triangle: &Triangle, frame: Frame) -> Aabb {
    let corners = triangle.corners.map(|c| frame.to_tree(c));
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    Aabb::new(
        Vec3A::new(round_down(low.x), round_down(low.y), round_down(low.z)),
        Vec3A::new(round_up(high.x), round_up(high.y), round_up(high.z)),
    )
}

fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x {
        near.next_down()
    } else {
        near
    }
}

fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

fn binary_tree(boxes: &[Aabb]) -> Bvh2 {
    let indices = (0..boxes.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        indices,
        SortPrecision::U64,
        2,
    );
    ReinsertionOptimizer::default().run(&mut binary, 0.1, None);
    binary
}

/// Triangles below each binary node.
fn subtree_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    let mut stack = vec![(0, false)];
    while let Some((index, done)) = stack.pop() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            counts[index] = node.prim_count;
        } else if done {
            counts[index] = counts[first] + counts[first + 1];
        } else {
            stack.extend([(index, true), (first, false), (first + 1, false)]);
        }
    }
    counts
}

struct Build<'a> {
    binary: &'a Bvh2,
    counts: Vec<u32>,
    order: Vec<u32>,
    nodes: Vec<Node>,
    first_slot: usize,
}

impl Build<'_> {
    /// Collapses from the root, with a list of open nodes instead of recursion.
    fn add_root(&mut self) {
        self.nodes.push(Node::empty());
        let mut open = vec![(0, 0)];
        while let Some((wide, binary)) = open.pop() {
            for (lane, child) in self.children(binary).into_iter().enumerate() {
                let target = if self.counts[child] <= LEAF {
                    self.add_leaf(child)
                } else {
                    open.push((self.nodes.len(), child));
                    self.nodes.push(Node::empty());
                    Child::node(self.nodes.len() - 1)
                };
                let bounds = *self.binary.nodes[child].aabb();
                let node = &mut self.nodes[wide];
                for axis in 0..3 {
                    node.low[axis][lane] = bounds.min[axis];
                    node.high[axis][lane] = bounds.max[axis];
                }
                node.child[lane] = target;
            }
        }
    }

    /// Up to eight binary descendants of `root`, found by opening the one of
    /// greatest surface again and again.
    fn children(&self, root: usize) -> Vec<usize> {
        let mut children = vec![root];
        while children.len() < WIDTH {
            let widest = (0..children.len())
                .filter(|&i| self.counts[children[i]] > LEAF)
                .max_by(|&i, &j| {
                    self.surface(children[i])
                        .total_cmp(&self.surface(children[j]))
                });
            let Some(widest) = widest else { break };
            let first = self.binary.nodes[children[widest]].first_index as usize;
            children[widest] = first;
            children.push(first + 1);
        }
        children
    }

    fn surface(&self, index: usize) -> f32 {
        self.binary.nodes[index].aabb().half_area()
    }

    fn add_leaf(&mut self, root: usize) -> Child {
        let first = self.order.len();
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index];
            let start = node.first_index as usize;
            if node.is_leaf() {
                let end = start + node.prim_count as usize;
                self.order
                    .extend(&self.binary.primitive_indices[start..end]);
            } else {
                stack.extend([start + 1, start]);
            }
        }
        Child::leaf(self.first_slot + first, self.order.len() - first)
    }
}
