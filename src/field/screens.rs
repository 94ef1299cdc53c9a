//! Coping that hides walls: what lies across a gap from the end of a wall is not
//! its footpoint, however near.
//!
//! Coping is nobody's nearest point (Bloomenthal 2011, section 4), so from inside a
//! wall the nearest wall point may lie beyond its end, on another wall, wherever the
//! gap between them is less than half as wide as the wall is thick: the flanges of a
//! folded box, a rib that stops short of a wall. The paper's parts have no such gaps.
//! Here a wall point that the segment to it leaves the part for is passed over.
//!
//! Few walls lie so close before coping. They are found once, with the coping that
//! may hide them; only they are held against it, and a part without any is searched
//! as if there were no such thing.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use super::frame::Frame;
use super::nearest::{self, Best, Hiding};
use super::topology::position_key;
use super::tree::Tree;
use super::triangle::Triangle;

/// In tree units: what is before a triangle or behind it by less lies on it, and what
/// passes it by less goes through it. Walks decide by ties, which are less.
const NEAR: f64 = 1e-6;

/// Coping triangles are halved so often at most, to be looked at piece by piece.
const HALVINGS: u32 = 12;

/// Cosine of the angle between normals of coping within which it is of one end.
const SAME_END: f64 = 0.1;

/// The wall triangles that coping may hide.
#[derive(Clone, Debug, Default)]
pub(super) struct Screens {
    /// Coping triangles, by slot, before each such wall triangle.
    before: FxHashMap<u32, Vec<u32>>,
    /// By slot of the wall tree; empty if there are none.
    is_hidden: Vec<bool>,
    near: f64,
}

impl Screens {
    /// Of triangles by slot, those of both trees.
    pub fn new(
        triangles: &[Triangle],
        [wall_tree, coping_tree]: [&Tree; 2],
        frame: Frame,
    ) -> Screens {
        let near = NEAR / frame.scale;
        if wall_tree.slots().is_empty() {
            return Screens::default();
        }
        let corners = Corners::new(triangles, coping_tree.slots());
        let pairs: Vec<(u32, u32)> = coping_tree
            .slots()
            .into_par_iter()
            .flat_map_iter(|coping| {
                let search = Search {
                    triangles,
                    wall_tree,
                    frame,
                    coping: &triangles[coping],
                    normal: triangles[coping].normal(),
                    near,
                };
                let (mut walls, reach) = search.walls_before();
                if !walls.is_empty() {
                    let end = corners.of_end(triangles, coping, reach);
                    let ends = |c: &DVec3| end.contains(&position_key(*c));
                    walls.retain(|&wall| !triangles[wall as usize].corners.iter().any(ends));
                }
                walls.into_iter().map(move |wall| (wall, coping as u32))
            })
            .collect();
        let mut screens = Screens {
            near,
            ..Screens::default()
        };
        if !pairs.is_empty() {
            screens.is_hidden = vec![false; wall_tree.slots().end];
        }
        for (wall, coping) in pairs {
            screens.is_hidden[wall as usize] = true;
            screens.before.entry(wall).or_default().push(coping);
        }
        screens
    }

    /// Whether the way from `p` to the point of a wall triangle leads out of the part
    /// through coping.
    #[inline]
    pub fn hide(&self, triangles: &[Triangle], slot: usize, p: DVec3, point: DVec3) -> bool {
        let hidden = self.is_hidden.get(slot).is_some_and(|hidden| *hidden);
        hidden && self.leaves(triangles, slot, p, point)
    }

    fn leaves(&self, triangles: &[Triangle], slot: usize, p: DVec3, point: DVec3) -> bool {
        let before = self.before.get(&(slot as u32));
        before.into_iter().flatten().any(|&coping| {
            let coping = &triangles[coping as usize];
            let normal = coping.normal();
            let height = |x: DVec3| normal.dot(x - coping.corners[0]);
            let (behind, ahead) = (-height(p), height(point));
            if behind < -self.near || ahead <= self.near {
                return false;
            }
            let through = p.lerp(point, (behind / (behind + ahead)).max(0.0));
            coping.closest(through).square <= self.near * self.near
        })
    }
}

/// Screens with the triangles they speak of.
pub(super) struct Screened<'a> {
    pub screens: &'a Screens,
    pub triangles: &'a [Triangle],
}

impl Hiding for Screened<'_> {
    #[inline]
    fn may_hide(&self, slots: Range<usize>) -> bool {
        (self.screens.is_hidden.get(slots)).is_some_and(|hidden| hidden.contains(&true))
    }

    #[inline]
    fn hides(&self, slot: usize, p: DVec3, point: DVec3) -> bool {
        self.screens.hide(self.triangles, slot, p, point)
    }
}

/// Coping triangles by the places of their corners.
struct Corners {
    at: FxHashMap<[u64; 3], SmallVec<[u32; 8]>>,
}

impl Corners {
    fn new(triangles: &[Triangle], coping: Range<usize>) -> Corners {
        let mut at: FxHashMap<[u64; 3], SmallVec<[u32; 8]>> = FxHashMap::default();
        for slot in coping {
            for corner in triangles[slot].corners {
                at.entry(position_key(corner))
                    .or_default()
                    .push(slot as u32);
            }
        }
        Corners { at }
    }

    /// Places of the corners of the end of a wall that a coping triangle is part of: of
    /// coping that hangs together with it and faces where it does. Facets of a rim lean
    /// to and fro, and one before the other hides nothing. No farther away than a few
    /// times `near`.
    fn of_end(&self, triangles: &[Triangle], coping: usize, near: f64) -> FxHashSet<[u64; 3]> {
        let normal = triangles[coping].normal();
        let middle = middle(triangles[coping].corners);
        let mut found = FxHashSet::default();
        let mut seen: FxHashSet<u32> = [coping as u32].into_iter().collect();
        let mut open = vec![coping as u32];
        while let Some(slot) = open.pop() {
            for corner in triangles[slot as usize].corners {
                let key = position_key(corner);
                if corner.distance(middle) > 4.0 * near || !found.insert(key) {
                    continue;
                }
                for &other in self.at.get(&key).into_iter().flatten() {
                    let faces_there = triangles[other as usize].normal().dot(normal) > SAME_END;
                    if faces_there && seen.insert(other) {
                        open.push(other);
                    }
                }
            }
        }
        found
    }
}

/// The search for walls before one coping triangle.
struct Search<'a> {
    triangles: &'a [Triangle],
    wall_tree: &'a Tree,
    frame: Frame,
    coping: &'a Triangle,
    normal: DVec3,
    near: f64,
}

impl Search<'_> {
    /// Slots of wall triangles that are nearer to some point of the coping, on its
    /// outer side, than the walls it closes are, and perhaps of others; with a distance
    /// from the coping's middle within which all of them have points.
    fn walls_before(&self) -> (Vec<u32>, f64) {
        let mut found = Vec::new();
        let mut farthest = 0.0_f64;
        let whole = middle(self.coping.corners);
        let mut open = vec![(self.coping.corners, 0.0, 0)];
        while let Some((corners, room, halvings)) = open.pop() {
            let middle = middle(corners);
            let reach = corners.map(|c| c.distance(middle)).into_iter();
            let reach = reach.fold(0.0, f64::max);
            let own = self.own_distance(middle);
            // All points of the piece are closer than `reach` to its middle.
            let radius = own + 2.0 * reach;
            if !radius.is_finite() || !self.has_walls_before(middle, radius) {
                continue;
            }
            let room = own.max(room);
            if reach <= room || halvings == HALVINGS {
                self.each_before(middle, radius, |wall| found.push(wall));
                farthest = farthest.max(whole.distance(middle) + radius);
                continue;
            }
            let side = |i: usize| corners[i].distance_squared(corners[(i + 1) % 3]);
            let longest = (0..3)
                .max_by(|&i, &j| side(i).total_cmp(&side(j)))
                .unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
            let half = a.midpoint(b);
            open.push(([a, half, c], room, halvings + 1));
            open.push(([half, b, c], room, halvings + 1));
        }
        found.sort_unstable();
        found.dedup();
        (found, farthest)
    }

    fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x - self.coping.corners[0])
    }

    /// Distance of a point of the coping to the walls that are not before it.
    fn own_distance(&self, p: DVec3) -> f64 {
        nearest::search(
            self.wall_tree,
            self.triangles,
            self.frame,
            p,
            Best::none(),
            self,
        )
        .distance
    }

    fn has_walls_before(&self, p: DVec3, radius: f64) -> bool {
        let mut any = false;
        self.each_before(p, radius, |_| any = true);
        any
    }

    fn each_before(&self, p: DVec3, radius: f64, mut visit: impl FnMut(u32)) {
        nearest::each_near(self.wall_tree, self.frame, p, radius, |slot| {
            let wall = &self.triangles[slot];
            if wall.corners.iter().any(|&c| self.height(c) > self.near) {
                visit(slot as u32);
            }
        });
    }
}

/// What is before the coping.
impl Hiding for Search<'_> {
    fn may_hide(&self, _: Range<usize>) -> bool {
        true
    }

    fn hides(&self, _: usize, _: DVec3, point: DVec3) -> bool {
        self.height(point) > self.near
    }
}

fn middle(corners: [DVec3; 3]) -> DVec3 {
    (corners[0] + corners[1] + corners[2]) / 3.0
}
