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
//! outward. Query points are rounded to f32 once; both that and the arithmetic
//! on boxes and blocks are covered by [`Query::error`], which every limit adds
//! before it is squared. So a box or a lane is passed over only when its
//! triangles are truly farther than the limit asks for.

use std::ops::Range;

use super::block::{self, Block, LANES};
use super::frame::Frame;
use super::triangle::Triangle;
use glam::{DVec3, Vec3A, Vec4};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;

/// Children a node.
pub(super) const WIDTH: usize = 8;

/// Triangles a leaf holds at most: one block.
const LEAF: u32 = LANES as u32;

/// One f32 for each child of a node.
pub(super) type Lanes = [Vec4; WIDTH / 4];

/// A query point in tree units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub p: [f32; 3],
    /// Bound on the error of any f32 distance in this query.
    error: f32,
    scale: f64,
}

/// Greatest coordinate, in tree units, of a query that f32 can serve: squares
/// of squares stay finite.
const FAR: f64 = 1e15;

impl Query {
    /// None for a point too far out for f32, or not a number.
    #[inline]
    pub fn new(frame: Frame, p: DVec3) -> Option<Query> {
        let local = frame.to_tree(p);
        let near = local.x.abs() <= FAR && local.y.abs() <= FAR && local.z.abs() <= FAR;
        near.then(|| Query {
            p: [local.x as f32, local.y as f32, local.z as f32],
            error: block::error(local.abs().max_element()) as f32,
            scale: frame.scale,
        })
    }

    /// Limit that keeps every triangle at a distance of at most `distance`
    /// (part units).
    #[inline]
    pub fn limit(&self, distance: f64) -> f32 {
        let reach = (distance * self.scale) as f32 + self.error;
        reach * reach * ROUNDING
    }

    /// Limit that keeps every triangle that may be as near as one whose square
    /// came out as `square`: both may be off, so the error counts twice.
    #[inline]
    pub fn limit_beside(&self, square: f32) -> f32 {
        let reach = square.sqrt() + 2.0 * self.error;
        reach * reach * ROUNDING
    }
}

/// Covers the few `2^-24` that computing a limit itself may lose.
const ROUNDING: f32 = 1.0 + 1e-6;

/// Where a child slot of a node leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

const LEAF_BIT: u32 = 1 << 31;
const COUNT_SHIFT: u32 = 27;

impl Child {
    pub const EMPTY: Child = Child(u32::MAX);
    pub const ROOT: Child = Child(0);

    fn node(index: usize) -> Child {
        Child(index as u32)
    }

    fn leaf(block: usize, count: usize) -> Child {
        Child(LEAF_BIT | ((count as u32 - 1) << COUNT_SHIFT) | block as u32)
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

    /// Index of the leaf's block.
    #[inline]
    pub fn block(self) -> usize {
        (self.0 & ((1 << COUNT_SHIFT) - 1)) as usize
    }

    /// Triangles in the leaf.
    #[inline]
    pub fn count(self) -> usize {
        ((self.0 & !LEAF_BIT) >> COUNT_SHIFT) as usize + 1
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
            low: [[Vec4::INFINITY; WIDTH / 4]; 3],
            high: [[Vec4::NEG_INFINITY; WIDTH / 4]; 3],
            child: [Child::EMPTY; WIDTH],
        }
    }

    /// Squared distances from `p` to the four boxes of half `half`.
    #[inline]
    fn squares(&self, p: [Vec4; 3], half: usize) -> Vec4 {
        let gap = |axis: usize| {
            let below = self.low[axis][half] - p[axis];
            let above = p[axis] - self.high[axis][half];
            below.max(above).max(Vec4::ZERO)
        };
        let (x, y, z) = (gap(0), gap(1), gap(2));
        x * x + y * y + z * z
    }

    /// Pushes the children within the limit, the nearest last.
    #[inline(always)]
    fn push_near(&self, p: [Vec4; 3], limit: f32, stack: &mut Stack) {
        let (first, second) = (self.squares(p, 0), self.squares(p, 1));
        let bound = Vec4::splat(limit);
        let mut near = first.cmple(bound).bitmask() | second.cmple(bound).bitmask() << 4;
        let squares = [first.to_array(), second.to_array()];
        let bottom = stack.len;
        while near != 0 {
            let lane = near.trailing_zeros() as usize % WIDTH;
            near &= near - 1;
            stack.insert(squares[lane / 4][lane % 4], self.child[lane], bottom);
        }
    }

    /// Lower and upper corner of a child's box.
    pub fn bounds(&self, lane: usize) -> (DVec3, DVec3) {
        let corner = |side: &[Lanes; 3]| {
            DVec3::from([0, 1, 2].map(|axis| f64::from(side[axis][lane / 4][lane % 4])))
        };
        (corner(&self.low), corner(&self.high))
    }
}

/// Children still to visit.
struct Stack {
    /// Square and child in one number: squares are not negative, so that the
    /// numbers sort as the squares do.
    keys: [u64; Stack::ROOM],
    len: usize,
}

impl Stack {
    /// A power of two, so that masking an index costs less than checking it.
    const ROOM: usize = 128;

    #[inline]
    fn new() -> Stack {
        Stack {
            keys: [0; Stack::ROOM],
            len: 0,
        }
    }

    #[inline]
    fn has_room(&self) -> bool {
        self.len + WIDTH <= Stack::ROOM
    }

    /// Insertion sort of the entries from `bottom` on, nearest last.
    #[inline(always)]
    fn insert(&mut self, square: f32, child: Child, bottom: usize) {
        let key = (u64::from(square.to_bits()) << 32) | u64::from(child.0);
        let mut i = self.len;
        while i > bottom && self.keys[(i - 1) % Stack::ROOM] < key {
            self.keys[i % Stack::ROOM] = self.keys[(i - 1) % Stack::ROOM];
            i -= 1;
        }
        self.keys[i % Stack::ROOM] = key;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<(f32, Child)> {
        self.len = self.len.checked_sub(1)?;
        let key = self.keys[self.len % Stack::ROOM];
        Some((f32::from_bits((key >> 32) as u32), Child(key as u32)))
    }
}

/// The tree. Node 0 is the root; children stand after their parents.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    blocks: Vec<Block>,
    /// First triangle slot of each block.
    firsts: Vec<u32>,
    /// Slots of all triangles.
    slots: Range<usize>,
}

impl Tree {
    /// Builds the tree over `triangles`, and sorts them into leaf order.
    ///
    /// Slots are places in the returned order plus `first_slot`.
    pub fn build(triangles: &mut Vec<Triangle>, frame: Frame, first_slot: usize) -> Tree {
        if triangles.is_empty() {
            return Tree::default();
        }
        let mut boxes: Vec<Aabb> = triangles.iter().map(|t| padded_box(t, frame)).collect();
        tell_twins_apart(&mut boxes);
        let binary = binary_tree(&boxes);
        let mut build = Build {
            counts: subtree_counts(&binary),
            binary: &binary,
            order: Vec::with_capacity(triangles.len()),
            nodes: Vec::new(),
            starts: Vec::new(),
        };
        build.add_root();
        let Build {
            order,
            nodes,
            mut starts,
            ..
        } = build;
        // Makes room for the triangles' copy.
        drop(binary);
        *triangles = order
            .iter()
            .map(|&i| triangles[i as usize].clone())
            .collect();
        starts.push(order.len());
        let blocks = starts
            .windows(2)
            .map(|w| Block::new(&triangles[w[0]..w[1]], frame))
            .collect();
        starts.pop();
        Tree {
            nodes,
            blocks,
            firsts: starts
                .into_iter()
                .map(|s| (first_slot + s) as u32)
                .collect(),
            slots: first_slot..first_slot + triangles.len(),
        }
    }

    /// Slots of all triangles.
    pub fn slots(&self) -> Range<usize> {
        self.slots.clone()
    }

    /// Triangle slots of a leaf.
    #[inline]
    pub fn leaf_slots(&self, leaf: Child) -> Range<usize> {
        let first = self.firsts[leaf.block()] as usize;
        first..first + leaf.count()
    }

    /// Visits the slots of the triangles of all leaves in boxes that are wanted, which
    /// come as their lower and upper corners in tree units.
    pub fn visit_boxes(
        &self,
        is_wanted: impl Fn(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(usize),
    ) {
        let mut open: SmallVec<[Child; 64]> = SmallVec::new();
        open.extend((!self.nodes.is_empty()).then_some(Child::ROOT));
        while let Some(child) = open.pop() {
            if child.is_leaf() {
                self.leaf_slots(child).for_each(&mut visit);
                continue;
            }
            let node = &self.nodes[child.index()];
            for lane in (0..WIDTH).take_while(|lane| node.child[*lane] != Child::EMPTY) {
                let (low, high) = node.bounds(lane);
                if is_wanted(low, high) {
                    open.push(node.child[lane]);
                }
            }
        }
    }

    /// Visits the leaves whose box is within `limit`, near ones first.
    ///
    /// `visit` gets the leaf and the rough squared distances of its triangles
    /// (free lanes repeat the last) and returns the limit from there on.
    #[inline]
    pub fn descend(&self, query: &Query, limit: f32, mut visit: impl FnMut(Child, Vec4) -> f32) {
        if !self.nodes.is_empty() {
            // An infinite limit would let empty slots pass.
            let limit = limit.min(f32::MAX);
            let p = query.p.map(Vec4::splat);
            self.descend_from(Child::node(0), p, limit, &mut visit);
        }
    }

    fn descend_from<F: FnMut(Child, Vec4) -> f32>(
        &self,
        mut child: Child,
        p: [Vec4; 3],
        mut limit: f32,
        visit: &mut F,
    ) -> f32 {
        let mut stack = Stack::new();
        loop {
            if child.is_leaf() {
                limit = visit(child, self.blocks[child.block()].squares(p)).min(f32::MAX);
            } else if stack.has_room() {
                self.nodes[child.index()].push_near(p, limit, &mut stack);
            } else {
                // A node adds at most seven, so only a tree more than 17 nodes
                // deep comes here, and the recursion is 17 times less deep.
                limit = self.descend_from(child, p, limit, visit);
            }
            child = loop {
                match stack.pop() {
                    None => return limit,
                    Some((square, child)) if square <= limit => break child,
                    Some(_) => {}
                }
            };
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

/// Widens boxes that are equal, each by little and another amount.
///
/// The builder joins boxes that are each other's nearest. Where all are equal, all
/// have the same nearest one, and every pass over them joins a single pair.
fn tell_twins_apart(boxes: &mut [Aabb]) {
    /// Tree units: more than rounding of areas, far less than parts of a part.
    const STEP: f32 = 2.4e-7;
    let bits = |i: u32| {
        let Aabb { min, max } = boxes[i as usize];
        [min, max].map(|corner| corner.to_array().map(f32::to_bits))
    };
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.sort_unstable_by_key(|&i| (bits(i), i));
    let twins: Vec<Vec<u32>> = order
        .chunk_by(|&i, &j| bits(i) == bits(j))
        .filter(|run| run.len() > 1)
        .map(<[u32]>::to_vec)
        .collect();
    for (rank, i) in twins.iter().flat_map(|run| (0_u32..).zip(run)) {
        // Bits of a multiplicative hash, 0 to 63 of either: neighbours in rank are
        // far apart.
        let hash = rank.wrapping_mul(0x9E37_79B9);
        let [low, high] = [hash >> 26, (hash >> 20) & 63].map(|steps| steps as f32 * STEP);
        let twin = &mut boxes[*i as usize];
        twin.min -= Vec3A::splat(low);
        twin.max += Vec3A::splat(high);
    }
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
    ReinsertionOptimizer::default().run(&mut binary, 0.5, None);
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
    /// Place in `order` where each block starts.
    starts: Vec<usize>,
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
                    node.low[axis][lane / 4][lane % 4] = bounds.min[axis];
                    node.high[axis][lane / 4][lane % 4] = bounds.max[axis];
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
        let start = self.order.len();
        self.starts.push(start);
        let mut stack = vec![root];
        while let Some(index) = stack.pop() {
            let node = &self.binary.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                let end = first + node.prim_count as usize;
                self.order
                    .extend(&self.binary.primitive_indices[first..end]);
            } else {
                stack.extend([first + 1, first]);
            }
        }
        Child::leaf(self.starts.len() - 1, self.order.len() - start)
    }
}

#[cfg(test)]
mod tests {
    use super::super::FaceId;
    use super::*;

    #[test]
    fn equal_boxes_are_told_apart_and_widened_only() {
        let one = Aabb::new(Vec3A::ZERO, Vec3A::ONE);
        let other = Aabb::new(Vec3A::ZERO, Vec3A::splat(0.5));
        let mut boxes = vec![one; 1000];
        boxes.push(other);
        tell_twins_apart(&mut boxes);
        assert_eq!(boxes[1000].max, other.max);
        assert!((boxes.iter()).all(|b| b.min.cmple(Vec3A::ZERO).all()));
        assert!(boxes[..1000].iter().all(|b| b.max.cmpge(Vec3A::ONE).all()));
        let corner = |b: &Aabb| [b.min.x, b.max.x].map(f32::to_bits);
        let mut corners: Vec<_> = boxes[..1000].iter().map(corner).collect();
        corners.sort_unstable();
        corners.dedup();
        assert!(corners.len() > 500, "{}", corners.len());
    }

    /// A binary tree that is a mere chain gives a stack fuller than its room.
    #[test]
    fn a_tree_deeper_than_the_stack_is_descended_by_recursion() {
        let corners = |i: usize| {
            let x = i as f64 / 4000.0;
            [
                DVec3::new(x, 0.0, 0.0),
                DVec3::new(x, 1.0, 0.0),
                DVec3::new(x, 0.0, 1.0),
            ]
        };
        let triangles: Vec<_> = (0..4000)
            .map(|i| Triangle::new(corners(i), FaceId(i as u32)))
            .collect();
        let frame = Frame::new(DVec3::ZERO, DVec3::ONE);
        // A chain of nodes with up to seven leaves each. Every box is the whole
        // part, so nothing is pruned, and nodes sort before leaves.
        let mut tree = Tree {
            slots: 0..4000,
            ..Tree::default()
        };
        let links: Vec<_> = triangles.chunks(7 * LANES).collect();
        for (i, link) in links.iter().enumerate() {
            let mut children = Vec::new();
            for leaf in link.chunks(LANES) {
                children.push(Child::leaf(tree.blocks.len(), leaf.len()));
                tree.firsts.push(leaf[0].face.0);
                tree.blocks.push(Block::new(leaf, frame));
            }
            if i + 1 < links.len() {
                children.push(Child::node(i + 1));
            }
            let mut node = Node::empty();
            for (lane, child) in children.into_iter().enumerate() {
                node.child[lane] = child;
                for axis in 0..3 {
                    node.low[axis][lane / 4][lane % 4] = -1.0;
                    node.high[axis][lane / 4][lane % 4] = 1.0;
                }
            }
            tree.nodes.push(node);
        }
        let query = Query::new(frame, DVec3::splat(0.3)).expect("a near point");
        let mut seen = vec![0; triangles.len()];
        tree.descend(&query, f32::INFINITY, |leaf, _| {
            for slot in tree.leaf_slots(leaf) {
                seen[slot] += 1;
            }
            f32::INFINITY
        });
        assert!(seen.iter().all(|&n| n == 1));
    }
}
