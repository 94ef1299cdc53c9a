//! The first triangle that a ray meets.
//!
//! The same tests as in `hits`, but near boxes come first and the segment is
//! cut short at what was met, so that the rest of the part costs nothing.

use glam::{DVec3, Vec4};
use smallvec::SmallVec;

use super::hits::{Segment, touch};
use super::tree::{Child, Node, Tree};
use super::{Field, Hit};

/// Boxes still to open: the least distance along the ray at which each may be
/// met, as a fraction of the whole segment.
type Stack = SmallVec<[(f32, Child); 96]>;

pub(super) fn first_hit(field: &Field, from: DVec3, to: DVec3) -> Option<Hit> {
    if !from.is_finite() || !to.is_finite() {
        return None;
    }
    let mut search = Search {
        field,
        from,
        to,
        best: None,
    };
    for tree in [&field.wall_tree, &field.coping_tree] {
        search.run(tree);
    }
    search.best
}

struct Search<'a> {
    field: &'a Field,
    from: DVec3,
    to: DVec3,
    best: Option<Hit>,
}

impl Search<'_> {
    fn run(&mut self, tree: &Tree) {
        if tree.nodes.is_empty() {
            return;
        }
        let mut stack = Stack::new();
        stack.push((0.0, Child::ROOT));
        let reach = self.best.map_or(1.0, |hit| hit.t);
        let mut segment = self.segment(reach);
        let order = Order::new(self.field, self.from, self.to);
        let mut limit = reach as f32;
        while let Some((at, child)) = stack.pop() {
            if at > limit {
                continue;
            }
            if !child.is_leaf() {
                push_near(&tree.nodes[child.index()], &segment, &order, &mut stack);
                continue;
            }
            if self.visit(tree, child)
                && let Some(hit) = self.best
            {
                segment = self.segment(hit.t);
                limit = hit.t as f32 + order.slack;
            }
        }
    }

    /// The segment up to a fraction of the way; a little longer, so that a tie
    /// is not lost.
    fn segment(&self, reach: f64) -> Segment {
        let end = self.from + (self.to - self.from) * (reach * (1.0 + 1e-9));
        Segment::new(self.field.frame, self.from, end)
    }

    /// Whether a triangle of the leaf comes before what was met so far; of
    /// equal places the lowest face.
    fn visit(&mut self, tree: &Tree, leaf: Child) -> bool {
        let mut nearer = false;
        for triangle in &self.field.triangles[tree.leaf_slots(leaf)] {
            if let Some(t) = touch(triangle, self.from, self.to) {
                let face = triangle.face;
                let before = |best: Hit| t < best.t || (t == best.t && face < best.face);
                if self.best.is_none_or(before) {
                    self.best = Some(Hit { t, face });
                    nearer = true;
                }
            }
        }
        nearer
    }
}

/// Distance of boxes along the segment, for the order in which to open them.
struct Order {
    /// Direction over squared length, in tree units.
    along: [f32; 3],
    from: [f32; 3],
    /// Covers the rounding of f32.
    slack: f32,
}

impl Order {
    fn new(field: &Field, from: DVec3, to: DVec3) -> Order {
        let (a, b) = (field.frame.to_tree(from), field.frame.to_tree(to));
        let step = b - a;
        let square = step.length_squared();
        let along = if square > 0.0 {
            step / square
        } else {
            DVec3::ZERO
        };
        let size = a.abs().max_element().max(1.0) * along.abs().max_element();
        Order {
            along: along.to_array().map(|x| x as f32),
            from: a.to_array().map(|x| x as f32),
            slack: (4e-6 * size) as f32,
        }
    }

    /// Least fraction of the way at which any point of the four boxes of one
    /// half of a node lies.
    fn entries(&self, node: &Node, half: usize) -> Vec4 {
        let mut sum = Vec4::splat(-self.slack);
        for axis in 0..3 {
            let slope = Vec4::splat(self.along[axis]);
            let start = Vec4::splat(self.from[axis]);
            let (low, high) = (node.low[axis][half], node.high[axis][half]);
            sum += ((low - start) * slope).min((high - start) * slope);
        }
        sum
    }
}

/// Pushes the children that the segment meets, the nearest last.
fn push_near(node: &Node, segment: &Segment, order: &Order, stack: &mut Stack) {
    let mut meets = segment.meets(node, 0) | segment.meets(node, 1) << 4;
    if meets == 0 {
        return;
    }
    let entries = [
        order.entries(node, 0).to_array(),
        order.entries(node, 1).to_array(),
    ];
    let bottom = stack.len();
    while meets != 0 {
        let lane = meets.trailing_zeros() as usize;
        meets &= meets - 1;
        let child = node.child[lane];
        if child == Child::EMPTY {
            continue;
        }
        let entry = (entries[lane / 4][lane % 4], child);
        let mut place = stack.len();
        while place > bottom && stack[place - 1].0 < entry.0 {
            place -= 1;
        }
        stack.insert(place, entry);
    }
}
