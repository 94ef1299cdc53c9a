//! Bounding volume tree over slabs.

use glam::DVec3;
use smallvec::SmallVec;

use super::slab::Slab;
use crate::mesh::Bounds;

/// Slabs a leaf holds at most.
const LEAF: usize = 4;

/// Relative to the greatest coordinate: what rounding may add to a bound.
const SLACK: f64 = 1e-14;

/// Binary tree, split at the median of the longest side.
///
/// A node knows the box of its *triangles* and their greatest radius: no slab
/// below has a value less than the distance to the box less that radius. The
/// box of the slabs would tell nothing of points inside it.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Slabs by leaf, with what bounds them.
    order: Vec<(Reach, u32)>,
    slack: f64,
}

/// Bounds triangles and the radii of their balls.
#[derive(Clone, Copy, Debug)]
struct Reach {
    bounds: Bounds,
    radius: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    reach: Reach,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// The other child follows its sibling's subtree; the first is next.
    Inner { second: u32 },
    /// Places in the order.
    Leaf { start: u32, end: u32 },
}

impl Tree {
    pub fn build(slabs: &[Slab]) -> Tree {
        let mut order: Vec<u32> = (0..slabs.len() as u32).collect();
        let mut nodes = Vec::with_capacity(slabs.len());
        let corners = slabs.iter().flat_map(|s| s.corners());
        let far = corners.fold(0.0, |far: f64, p| far.max(p.abs().max_element()));
        let greatest = slabs.iter().map(Slab::greatest_radius).fold(0.0, f64::max);
        if !slabs.is_empty() {
            split(slabs, &mut order, 0, &mut nodes);
        }
        let own = |s: u32| (Reach::of(&[&slabs[s as usize]]), s);
        Tree {
            nodes,
            order: order.into_iter().map(own).collect(),
            slack: SLACK * (far + greatest),
        }
    }

    /// Calls `look` with every slab whose value at `p` may be at most `limit`,
    /// nearer nodes first; it returns the limit from then on.
    pub fn search(&self, p: DVec3, mut limit: f64, mut look: impl FnMut(u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack: SmallVec<[(f64, u32); 64]> = SmallVec::new();
        stack.push((self.bound(0, p), 0));
        while let Some((bound, at)) = stack.pop() {
            if bound > limit {
                continue;
            }
            match self.nodes[at as usize].kind {
                Kind::Leaf { start, end } => {
                    for (reach, slab) in &self.order[start as usize..end as usize] {
                        if reach.least(p) - self.slack <= limit {
                            limit = look(*slab);
                        }
                    }
                }
                Kind::Inner { second } => {
                    let near = (self.bound(at + 1, p), at + 1);
                    let far = (self.bound(second, p), second);
                    let (near, far) = if near.0 <= far.0 {
                        (near, far)
                    } else {
                        (far, near)
                    };
                    stack.push(far);
                    stack.push(near);
                }
            }
        }
    }

    /// No slab below the node has a lower value at `p`.
    fn bound(&self, node: u32, p: DVec3) -> f64 {
        self.nodes[node as usize].reach.least(p) - self.slack
    }
}

impl Reach {
    fn of(slabs: &[&Slab]) -> Reach {
        let radii = slabs.iter().map(|s| s.greatest_radius());
        Reach {
            bounds: Bounds::of(slabs.iter().flat_map(|s| s.corners())),
            radius: radii.fold(0.0, f64::max),
        }
    }

    /// No slab has a lower value at `p`, short of rounding.
    fn least(&self, p: DVec3) -> f64 {
        let out = (self.bounds.min - p).max(p - self.bounds.max);
        out.max(DVec3::ZERO).length() - self.radius
    }
}

/// Appends the subtree of the slabs in `order`, which begins at `start` of the
/// whole order.
fn split(slabs: &[Slab], order: &mut [u32], start: usize, nodes: &mut Vec<Node>) {
    let all: Vec<&Slab> = order.iter().map(|&s| &slabs[s as usize]).collect();
    let reach = Reach::of(&all);
    let at = nodes.len();
    let leaf = Kind::Leaf {
        start: start as u32,
        end: (start + order.len()) as u32,
    };
    nodes.push(Node { reach, kind: leaf });
    if order.len() <= LEAF {
        return;
    }
    let axis = reach.bounds.size().max_position();
    let key = |s: &u32| -> f64 { slabs[*s as usize].corners().map(|c| c[axis]).iter().sum() };
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    let (low, high) = order.split_at_mut(middle);
    split(slabs, low, start, nodes);
    let second = nodes.len() as u32;
    nodes[at].kind = Kind::Inner { second };
    split(slabs, high, start + middle, nodes);
}
