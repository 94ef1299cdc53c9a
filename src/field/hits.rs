//! Which triangles a segment touches.
//!
//! Signs of tetrahedron volumes decide, each with Shewchuk's static bound on
//! its rounding error ("Adaptive precision floating-point arithmetic and fast
//! robust geometric predicates", 1997). A sign that the bound cannot certify
//! counts as "on the plane", so a triangle is rejected only on proof.

use glam::{BVec4A, DVec3, Vec4};
use smallvec::SmallVec;

use super::frame::Frame;
use super::tree::{Child, Node, Tree};
use super::triangle::Triangle;
use super::{Field, Hit};

/// `(7 + 56 e) e` with `e = 2^-53`: relative to the permanent of the
/// determinant; Shewchuk's bound A for `orient3d`.
const VOLUME_ERROR: f64 = 7.771_561_172_376_103e-16;

/// Slack, in fractions of the segment, for a segment that runs in the plane of
/// a triangle and only touches a corner.
const IN_PLANE_SLACK: f64 = 1e-12;

pub(super) fn hits(field: &Field, from: DVec3, to: DVec3, out: &mut Vec<Hit>) {
    out.clear();
    if !from.is_finite() || !to.is_finite() {
        return;
    }
    let segment = Segment::new(field.frame, from, to);
    for tree in [&field.wall_tree, &field.coping_tree] {
        segment.for_each_leaf(tree, |child| {
            for triangle in &field.triangles[tree.leaf_slots(child)] {
                if let Some(t) = touch(triangle, from, to) {
                    let face = triangle.face;
                    out.push(Hit { t, face });
                }
            }
        });
    }
    out.sort_unstable_by(|a, b| a.t.total_cmp(&b.t).then(a.face.cmp(&b.face)));
}

/// A segment in tree units, doubled so that boxes need no halving.
pub(super) struct Segment {
    /// Sum of the two ends.
    middle: [f32; 3],
    /// Difference of the two ends.
    along: [f32; 3],
    /// Added to every box, on both sides together.
    pad: f32,
}

impl Segment {
    pub fn new(frame: Frame, from: DVec3, to: DVec3) -> Segment {
        let (a, b) = (frame.to_tree(from), frame.to_tree(to));
        let f32s = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32];
        let reach = a.abs().max(b.abs()).max_element().max(1.0);
        Segment {
            middle: f32s(a + b),
            along: f32s(b - a),
            // Every product in the test below errs by a few 2^-24 of
            // `reach` times one component of `along`; the pad adds 2^-19 of
            // `reach` times the same component.
            pad: (reach * 2e-6) as f32,
        }
    }

    /// Separating axes of segment and box, for the four boxes of one half of a
    /// node: bit set where none of the six parts them. Conservative by `pad`.
    pub fn meets(&self, node: &Node, half: usize) -> u32 {
        let along = self.along.map(Vec4::splat);
        let steep = along.map(Vec4::abs);
        let middle =
            |k: usize| Vec4::splat(self.middle[k]) - (node.low[k][half] + node.high[k][half]);
        let size = |k: usize| node.high[k][half] - node.low[k][half] + Vec4::splat(self.pad);
        let m = [middle(0), middle(1), middle(2)];
        let h = [size(0), size(1), size(2)];
        let mut apart = BVec4A::FALSE;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            apart |= m[i].abs().cmpgt(h[i] + steep[i]);
            let turn = (m[i] * along[j] - m[j] * along[i]).abs();
            apart |= turn.cmpgt(h[i] * steep[j] + h[j] * steep[i]);
        }
        !apart.bitmask() & 15
    }

    fn for_each_leaf(&self, tree: &Tree, mut visit: impl FnMut(Child)) {
        if tree.nodes.is_empty() {
            return;
        }
        // Holds at most `7 depth + 1` nodes; deeper trees spill to the heap.
        let mut stack: SmallVec<[usize; 64]> = SmallVec::new();
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &tree.nodes[index];
            let meets = self.meets(node, 0) | self.meets(node, 1) << 4;
            for (lane, child) in node.child.into_iter().enumerate() {
                if meets & (1 << lane) != 0 && child != Child::EMPTY {
                    if child.is_leaf() {
                        visit(child);
                    } else {
                        stack.push(child.index());
                    }
                }
            }
        }
    }
}

/// Six times the signed volume of a tetrahedron: zero when its sign is not
/// certain.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let (a, b, c) = (a - d, b - d, c - d);
    let (bc, cb) = (b.x * c.y, c.x * b.y);
    let (ca, ac) = (c.x * a.y, a.x * c.y);
    let (ab, ba) = (a.x * b.y, b.x * a.y);
    let det = a.z * (bc - cb) + b.z * (ca - ac) + c.z * (ab - ba);
    let permanent = a.z.abs() * (bc.abs() + cb.abs())
        + b.z.abs() * (ca.abs() + ac.abs())
        + c.z.abs() * (ab.abs() + ba.abs());
    if det.abs() > VOLUME_ERROR * permanent {
        det
    } else {
        0.0
    }
}

/// Whether the segment touches the triangle, and where first.
pub(super) fn touch(triangle: &Triangle, from: DVec3, to: DVec3) -> Option<f64> {
    let [a, b, c] = triangle.corners;
    let (start, end) = (volume(a, b, c, from), volume(a, b, c, to));
    if start * end > 0.0 || (start > 0.0) == (end > 0.0) && start != 0.0 && end != 0.0 {
        return None;
    }
    if start == 0.0 && end == 0.0 {
        return touch_in_plane(triangle, from, to);
    }
    // The line passes the triangle when it turns one way round one edge and
    // the other way round another.
    let turns = [
        volume(from, to, a, b),
        volume(from, to, b, c),
        volume(from, to, c, a),
    ];
    if turns.iter().any(|&v| v > 0.0) && turns.iter().any(|&v| v < 0.0) {
        return None;
    }
    Some((start / (start - end)).clamp(0.0, 1.0))
}

/// The same for a segment in the triangle's plane: clipped by the three edges
/// in the coordinate plane in which the triangle is largest.
fn touch_in_plane(triangle: &Triangle, from: DVec3, to: DVec3) -> Option<f64> {
    let normal = triangle.normal();
    let steep = normal.abs();
    let (i, j) = if steep.x >= steep.y && steep.x >= steep.z {
        (1, 2)
    } else if steep.y >= steep.z {
        (2, 0)
    } else {
        (0, 1)
    };
    let turn = if normal[3 - i - j] < 0.0 { -1.0 } else { 1.0 };
    // Twice the area of (start, end, p), positive inside; zero if in doubt.
    let side = |start: DVec3, end: DVec3, p: DVec3| {
        let left = (end[i] - start[i]) * (p[j] - start[j]);
        let right = (end[j] - start[j]) * (p[i] - start[i]);
        let area = left - right;
        // Twice Shewchuk's bound for `orient2d`: the doubt of the third
        // coordinate is of the same order.
        let error = 6.7e-16 * (left.abs() + right.abs());
        if area.abs() > error { turn * area } else { 0.0 }
    };
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for k in 0..3 {
        let (start, end) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
        let (first, last) = (side(start, end, from), side(start, end, to));
        if first < 0.0 && last < 0.0 {
            return None;
        }
        if first < 0.0 {
            enter = enter.max(first / (first - last));
        }
        if last < 0.0 {
            leave = leave.min(first / (first - last));
        }
    }
    (enter <= leave + IN_PLANE_SLACK).then_some(enter)
}
