//! Coping that hides walls: what lies across a gap from the end of a wall is not
//! its footpoint, however near.
//!
//! Coping is nobody's nearest point (Bloomenthal 2011, section 4), so from inside a
//! wall the nearest wall point may lie beyond its end, on another wall, wherever the
//! gap between them is less than half as wide as the wall is thick: the flanges of a
//! folded box, a rib that stops short of a wall. The paper's parts have no such gaps.
//! Here a wall point that the segment to it leaves the part for is passed over.
//!
//! Few walls lie so near before coping. They are found once (see `before`); only they
//! are held against the coping between, and a part without any is searched as if
//! there were no such thing.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::before::Before;
use super::frame::Frame;
use super::nearest::{self, Hiding};
use super::tree::Tree;
use super::triangle::Triangle;

/// In tree units: what is before a triangle or behind it by less lies on it. Walks
/// decide by ties, which are less.
pub(super) const NEAR: f64 = 1e-6;

/// Cosine of the angle between normals of coping within which facets are of one end.
/// Facets of a rim lean to and fro: one before the border of another hides nothing.
const SAME_END: f64 = 0.1;

/// Coping triangles that one task looks at.
const CHUNK: usize = 256;

/// The wall triangles that coping may hide.
#[derive(Clone, Debug, Default)]
pub(super) struct Screens {
    /// By slot of the wall tree; empty if there are none.
    is_hidden: Vec<bool>,
}

impl Screens {
    /// Of triangles by slot, those of both trees.
    pub fn new(
        triangles: &[Triangle],
        [wall_tree, coping_tree]: [&Tree; 2],
        frame: Frame,
    ) -> Screens {
        let mut screens = Screens::default();
        if wall_tree.slots().is_empty() || coping_tree.slots().is_empty() {
            return screens;
        }
        let before = Before::new(triangles, wall_tree, coping_tree.slots(), frame);
        // Those that follow each other lie near each other.
        let chunks = (triangles[coping_tree.slots()].par_chunks(CHUNK))
            .map(|chunk| before.walls(chunk))
            .collect::<Vec<_>>();
        if chunks.iter().any(|found| !found.is_empty()) {
            screens.is_hidden = vec![false; wall_tree.slots().end];
        }
        for wall in chunks.into_iter().flatten() {
            screens.is_hidden[wall as usize] = true;
        }
        screens
    }
}

/// Screens with the triangles they speak of.
#[derive(Clone, Copy)]
pub(super) struct Screened<'a> {
    pub screens: &'a Screens,
    pub triangles: &'a [Triangle],
    pub coping_tree: &'a Tree,
    pub frame: Frame,
}

impl Screened<'_> {
    /// Whether the way from `p` to the point of a wall leaves the part through coping.
    fn leaves(&self, wall: &Triangle, p: DVec3, point: DVec3) -> bool {
        let near = NEAR / self.frame.scale;
        let ends = [p, point].map(|x| self.frame.to_tree(x));
        let low = ends[0].min(ends[1]) - 2.0 * NEAR;
        let high = ends[0].max(ends[1]) + 2.0 * NEAR;
        let mut leaves = false;
        let about = |l: DVec3, h: DVec3| l.cmple(high).all() && h.cmpge(low).all();
        self.coping_tree.visit_boxes(about, |coping| {
            let coping = &self.triangles[coping];
            let normal = coping.normal();
            let height = |x: DVec3| normal.dot(x - coping.corners[0]);
            let (behind, ahead) = (-height(p), height(point));
            if leaves || behind < -near || ahead <= near {
                return;
            }
            let through = p.lerp(point, (behind / (behind + ahead)).max(0.0));
            leaves = coping.closest(through).square <= near * near
                && !self.is_of_end(wall, point, p.distance(point), normal);
        });
        leaves
    }

    /// Whether a wall touches the end that coping of such a normal is of, no farther than
    /// `reach` from a point.
    fn is_of_end(&self, wall: &Triangle, point: DVec3, reach: f64, normal: DVec3) -> bool {
        let mut found = false;
        nearest::each_near(self.coping_tree, self.frame, point, reach, |coping| {
            let coping = &self.triangles[coping];
            found |= coping.corners.iter().any(|c| wall.corners.contains(c))
                && coping.normal().dot(normal) > SAME_END
                && coping.closest(point).square <= reach * reach;
        });
        found
    }
}

impl Hiding for Screened<'_> {
    #[inline]
    fn may_hide(&self, slots: Range<usize>) -> bool {
        (self.screens.is_hidden.get(slots)).is_some_and(|hidden| hidden.contains(&true))
    }

    #[inline]
    fn hides(&self, slot: usize, p: DVec3, point: DVec3) -> bool {
        self.screens.is_hidden.get(slot) == Some(&true)
            && self.leaves(&self.triangles[slot], p, point)
    }
}
