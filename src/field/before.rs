//! Which walls stand before a coping triangle, so near that a point behind it may take
//! them for its own: see `screens`.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use super::frame::Frame;
use super::nearest::{self, Best, Hiding};
use super::screens::NEAR;
use super::topology::position_key;
use super::tree::Tree;
use super::triangle::Triangle;

/// A coping triangle is halved so often at most, to be looked at piece by piece.
const HALVINGS: u32 = 12;

/// Cosine of the angle between normals of a wall and of coping from which one stands
/// across the way out of the other: a rib's end that leans by six degrees does not lead
/// to the wall that it stands on.
const ACROSS: f64 = 0.1;

/// All walls, and coping by the places of its corners.
pub(super) struct Before<'a> {
    triangles: &'a [Triangle],
    wall_tree: &'a Tree,
    frame: Frame,
    /// Normals of coping triangles about a place.
    coping_at: FxHashMap<[u64; 3], SmallVec<[DVec3; 4]>>,
    /// By slot of a wall triangle, whether coping touches it.
    touches: Vec<bool>,
}

impl<'a> Before<'a> {
    /// Of triangles by slot.
    pub fn new(
        triangles: &'a [Triangle],
        wall_tree: &'a Tree,
        coping: Range<usize>,
        frame: Frame,
    ) -> Before<'a> {
        let mut coping_at: FxHashMap<_, SmallVec<[DVec3; 4]>> = FxHashMap::default();
        for coping in &triangles[coping] {
            let normal = coping.normal();
            for corner in coping.corners {
                let normals = coping_at.entry(position_key(corner)).or_default();
                if !normals.contains(&normal) {
                    normals.push(normal);
                }
            }
        }
        let is_coping = |c: DVec3| coping_at.contains_key(&position_key(c));
        let touches = |wall: &Triangle| wall.corners.into_iter().any(is_coping);
        Before {
            triangles,
            wall_tree,
            frame,
            touches: (triangles[wall_tree.slots()].par_iter().map(touches)).collect(),
            coping_at,
        }
    }

    /// Slots of wall triangles on the outer side of coping triangles that are nearer to
    /// some point of one than the walls that it closes, and stand across the way out of
    /// it, or meet one that does; and perhaps of others.
    pub fn walls(&self, copings: &[Triangle]) -> Vec<u32> {
        let mut found = Vec::new();
        let mut hint = None;
        for coping in copings {
            self.find(&Coping::new(coping, self.frame), &mut hint, &mut found);
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Adds those of one coping triangle; `hint` is a wall near by.
    fn find(&self, coping: &Coping, hint: &mut Option<usize>, found: &mut Vec<u32>) {
        let mut open = vec![(coping.triangle.corners, 0.0, 0)];
        while let Some((corners, room, halvings)) = open.pop() {
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let reach = corners.map(|c| c.distance(middle)).into_iter();
            let reach = reach.fold(0.0, f64::max);
            let own = self.own_distance(coping, middle, hint);
            // All points of the piece are closer than `reach` to its middle.
            let radius = own + 2.0 * reach;
            let across = |wall: u32| self.is_across(coping, wall);
            let across = self.all_before(coping, middle, radius, across);
            if across.is_empty() {
                continue;
            }
            let room = own.max(room);
            if reach <= room || halvings == HALVINGS {
                let places = |wall: u32| self.triangles[wall as usize].corners.map(position_key);
                let known: FxHashSet<_> = across.into_iter().flat_map(places).collect();
                let meets = |wall: u32| places(wall).iter().any(|at| known.contains(at));
                found.extend(self.all_before(coping, middle, radius, meets));
                continue;
            }
            let side = |i: usize| corners[i].distance_squared(corners[(i + 1) % 3]);
            let longest = (0..3).max_by(|&i, &j| side(i).total_cmp(&side(j)));
            let [a, b, c] = [0, 1, 2].map(|k| corners[(longest.unwrap_or(0) + k) % 3]);
            let half = a.midpoint(b);
            open.push(([a, half, c], room, halvings + 1));
            open.push(([half, b, c], room, halvings + 1));
        }
    }

    /// Distance of a point of the coping to the walls that it closes.
    fn own_distance(&self, coping: &Coping, p: DVec3, hint: &mut Option<usize>) -> f64 {
        let mut best = Best::none();
        if let Some(wall) = *hint {
            best.offer_unless(self.triangles, wall, p, |point| coping.is_before(point));
        }
        let best = nearest::search(self.wall_tree, self.triangles, self.frame, p, best, coping);
        *hint = best.found.map(|(wall, _)| wall).or(*hint);
        best.distance
    }

    /// Wall triangles wanted of those that reach before the coping, no farther from a point
    /// than `radius`.
    fn all_before(
        &self,
        coping: &Coping,
        p: DVec3,
        radius: f64,
        is_wanted: impl Fn(u32) -> bool,
    ) -> Vec<u32> {
        let mut found = Vec::new();
        // Coping without a wall closes none.
        if !radius.is_finite() {
            return found;
        }
        let middle = self.frame.to_tree(p);
        let reach = radius * self.frame.scale + NEAR;
        let near = |low: DVec3, high: DVec3| {
            let away = (low - middle).max(middle - high).max(DVec3::ZERO);
            away.length_squared() <= reach * reach && coping.may_be_passed_by(low, high)
        };
        self.wall_tree.visit_boxes(near, |slot| {
            let wall = &self.triangles[slot];
            if coping.is_passed_by(wall)
                && is_wanted(slot as u32)
                && wall.closest(p).square <= radius * radius
            {
                found.push(slot as u32);
            }
        });
        found
    }

    /// Whether a wall stands across the way out of the coping, or coping about it does, at
    /// the other side of a slit.
    fn is_across(&self, coping: &Coping, wall: u32) -> bool {
        let [a, b, c] = self.triangles[wall as usize].corners;
        let normal = (b - a).cross(c - a);
        normal.dot(coping.normal).abs() > ACROSS * normal.length()
            || self.touches[wall as usize]
                && (self.coping_about(wall)).any(|other| other.dot(coping.normal) < -ACROSS)
    }

    /// Normals of coping that has a corner of a wall triangle.
    fn coping_about(&self, wall: u32) -> impl Iterator<Item = DVec3> {
        let corners = self.triangles[wall as usize].corners.into_iter();
        let about = corners.filter_map(|c| self.coping_at.get(&position_key(c)));
        about.flatten().copied()
    }
}

/// One coping triangle.
struct Coping<'a> {
    triangle: &'a Triangle,
    normal: DVec3,
    /// Part units.
    near: f64,
    /// First corner, tree units.
    corner: DVec3,
}

impl Coping<'_> {
    fn new(triangle: &Triangle, frame: Frame) -> Coping<'_> {
        Coping {
            triangle,
            normal: triangle.normal(),
            near: NEAR / frame.scale,
            corner: frame.to_tree(triangle.corners[0]),
        }
    }

    fn is_before(&self, x: DVec3) -> bool {
        self.normal.dot(x - self.triangle.corners[0]) > self.near
    }

    fn is_passed_by(&self, wall: &Triangle) -> bool {
        wall.corners.iter().any(|&c| self.is_before(c))
    }

    /// Whether some of a box, in tree units, is before it.
    fn may_be_passed_by(&self, low: DVec3, high: DVec3) -> bool {
        let middle = self.normal.dot(0.5 * (low + high) - self.corner);
        middle + self.normal.abs().dot(0.5 * (high - low)) > NEAR
    }
}

/// A wall that is before it is none that it closes.
impl Hiding for Coping<'_> {
    fn may_hide(&self, _: Range<usize>) -> bool {
        true
    }

    fn hides(&self, _: usize, _: DVec3, point: DVec3) -> bool {
        self.is_before(point)
    }
}
