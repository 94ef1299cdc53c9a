//! Nearest-point search: f32 finds the candidates, f64 decides.
//!
//! The descent measures four triangles at a time in f32 and keeps those that
//! may be nearest given the error of that arithmetic. Only they are measured in
//! f64, by the same code as a brute-force search, so the answer is the same bit
//! for bit. As a rule one to three triangles a query are left.

use std::ops::Range;

use glam::{DVec3, Vec4};

use super::FaceId;
use super::block::LANES;
use super::frame::Frame;
use super::tree::{Child, Query, Tree};
use super::triangle::{Closest, Triangle};

/// Best triangle so far.
///
/// Ordered by computed distance, then face. Squares are compared first, and
/// roots only taken near a tie, because two squares may share a root.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub distance: f64,
    /// Every square above this has a root above `distance`.
    square_limit: f64,
    face: FaceId,
    pub found: Option<(usize, Closest)>,
}

impl Best {
    pub fn none() -> Best {
        Best::within(f64::INFINITY)
    }

    /// Accepts triangles at a distance of at most `distance`.
    pub fn within(distance: f64) -> Best {
        Best {
            distance,
            square_limit: distance * distance * (1.0 + 1e-15),
            face: FaceId(u32::MAX),
            found: None,
        }
    }

    #[inline]
    pub fn offer(&mut self, triangles: &[Triangle], slot: usize, p: DVec3) {
        self.offer_unless(triangles, slot, p, |_| false);
    }

    /// The same but for a closest point that is hidden.
    #[inline]
    pub fn offer_unless(
        &mut self,
        triangles: &[Triangle],
        slot: usize,
        p: DVec3,
        is_hidden: impl FnOnce(DVec3) -> bool,
    ) {
        let triangle = &triangles[slot];
        let closest = triangle.closest(p);
        if closest.square <= self.square_limit {
            let distance = closest.square.sqrt();
            let better = distance < self.distance
                || (distance == self.distance && triangle.face < self.face);
            if better && !is_hidden(closest.point) {
                *self = Best {
                    distance,
                    square_limit: closest.square * (1.0 + 1e-15),
                    face: triangle.face,
                    found: Some((slot, closest)),
                };
            }
        }
    }
}

/// Triangles that do not count for some points.
pub(super) trait Hiding {
    /// Whether one of these slots may be hidden from some point.
    fn may_hide(&self, slots: Range<usize>) -> bool;

    /// Whether a point of the triangle in a slot is hidden from `p`.
    fn hides(&self, slot: usize, p: DVec3, point: DVec3) -> bool;
}

/// Nothing is hidden.
pub(super) struct Open;

impl Hiding for Open {
    #[inline]
    fn may_hide(&self, _: Range<usize>) -> bool {
        false
    }

    #[inline]
    fn hides(&self, _: usize, _: DVec3, _: DVec3) -> bool {
        false
    }
}

/// Offers to `best` every triangle of the tree that may beat it and is not hidden.
pub(super) fn search(
    tree: &Tree,
    triangles: &[Triangle],
    frame: Frame,
    p: DVec3,
    mut best: Best,
    hiding: &impl Hiding,
) -> Best {
    let Some(query) = Query::new(frame, p) else {
        for slot in tree.slots() {
            best.offer_unless(triangles, slot, p, |point| hiding.hides(slot, p, point));
        }
        return best;
    };
    let mut limit = query.limit(best.distance);
    let mut least = f32::INFINITY;
    let mut candidates = Candidates::new();
    tree.descend(&query, limit, |leaf, squares| {
        let mut near = lanes_within(leaf, squares, limit);
        if near == 0 {
            return limit;
        }
        if hiding.may_hide(tree.leaf_slots(leaf)) {
            // A hidden one bounds nothing: they are measured at once.
            while near != 0 {
                let slot = tree.leaf_slots(leaf).start + near.trailing_zeros() as usize;
                near &= near - 1;
                best.offer_unless(triangles, slot, p, |point| hiding.hides(slot, p, point));
            }
            return limit.min(query.limit(best.distance));
        }
        let nearest = squares.min_element();
        if nearest < least {
            least = nearest;
            limit = limit.min(query.limit_beside(nearest));
            near = lanes_within(leaf, squares, limit);
        }
        let first = tree.leaf_slots(leaf).start;
        let squares = squares.to_array();
        while near != 0 {
            let lane = near.trailing_zeros() as usize % LANES;
            near &= near - 1;
            if candidates.is_full() {
                candidates.drop_beyond(limit);
                if candidates.is_full() {
                    candidates.settle(limit, &mut best, triangles, p);
                    limit = limit.min(query.limit(best.distance));
                }
            }
            candidates.push(squares[lane], first + lane);
        }
        limit
    });
    candidates.settle(limit, &mut best, triangles, p);
    best
}

/// Calls `visit` with the slot of every triangle that may be at a distance of
/// at most `radius` (part units), and perhaps with others.
pub(super) fn each_near(
    tree: &Tree,
    frame: Frame,
    p: DVec3,
    radius: f64,
    mut visit: impl FnMut(usize),
) {
    let Some(query) = Query::new(frame, p) else {
        tree.slots().for_each(visit);
        return;
    };
    let limit = query.limit(radius);
    tree.descend(&query, limit, |leaf, squares| {
        let mut near = lanes_within(leaf, squares, limit);
        while near != 0 {
            visit(tree.leaf_slots(leaf).start + near.trailing_zeros() as usize);
            near &= near - 1;
        }
        limit
    });
}

/// Bits of the leaf's lanes whose square is within the limit.
#[inline]
fn lanes_within(leaf: Child, squares: Vec4, limit: f32) -> u32 {
    squares.cmple(Vec4::splat(limit)).bitmask() & ((1 << leaf.count()) - 1)
}

/// Triangles still in the running, in no order: rough square and slot.
struct Candidates {
    list: [(f32, u32); Candidates::ROOM],
    len: usize,
}

impl Candidates {
    /// More than meet at an ordinary vertex; when more tie, they are settled
    /// in batches.
    const ROOM: usize = 16;

    #[inline]
    fn new() -> Candidates {
        Candidates {
            list: [(0.0, 0); Candidates::ROOM],
            len: 0,
        }
    }

    #[inline]
    fn is_full(&self) -> bool {
        self.len == Candidates::ROOM
    }

    #[inline]
    fn push(&mut self, square: f32, slot: usize) {
        self.list[self.len] = (square, slot as u32);
        self.len += 1;
    }

    fn drop_beyond(&mut self, limit: f32) {
        let mut kept = 0;
        for i in 0..self.len {
            if self.list[i].0 <= limit {
                self.list[kept] = self.list[i];
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// Offers those within the limit to `best`, and forgets all.
    #[inline]
    fn settle(&mut self, limit: f32, best: &mut Best, triangles: &[Triangle], p: DVec3) {
        for &(square, slot) in &self.list[..self.len] {
            if square <= limit {
                best.offer(triangles, slot as usize, p);
            }
        }
        self.len = 0;
    }
}
