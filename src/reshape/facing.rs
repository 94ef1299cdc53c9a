//! Which way triangles of a complex face, and how an edit would turn them.

use glam::DVec3;
use smallvec::SmallVec;

use super::complex::Complex;
use super::shape::{Shape, crossing_gap};

/// A triangle keeps its direction if its normal turns by less than 60 degrees.
pub(super) const TURN: f64 = 0.5;

/// Flatter triangles have no normal to trust: on a curved sheet the sagitta
/// of the long side rivals the height.
pub(super) const TRUSTED: f64 = 0.05;

/// Two triangles of one sheet, and those across their other diagonal.
pub(super) struct Flip {
    /// The edge's ends, then the apexes that would be joined.
    pub(super) corners: [u32; 4],
    pub(super) old: [Shape; 2],
    /// Of [`Self::triangles`].
    pub(super) new: [Shape; 2],
    /// How far the two diagonals pass each other.
    pub(super) gap: f64,
}

impl Flip {
    /// The triangles after the flip.
    pub(super) fn triangles(&self) -> [[u32; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, d, c], [d, b, c]]
    }

    /// Sine of the worst angle before and after.
    pub(super) fn sines(&self) -> [f64; 2] {
        [&self.old, &self.new].map(|pair| pair[0].sine.min(pair[1].sine))
    }
}

impl Complex {
    /// What flipping an edge would do; `None` where it cannot be flipped, or
    /// where a triangle would face another way than those before did.
    pub(super) fn flip_of(&self, a: u32, b: u32) -> Option<Flip> {
        let [(_, c), (_, d)] = self.wings(a, b)?;
        if self.adjacent(c, d) {
            return None;
        }
        // In one orientation: abc and bad before, adc and dbc after.
        let old = [[a, b, c], [b, a, d]].map(|t| self.shape(t));
        let new = [[a, d, c], [d, b, c]].map(|t| self.shape(t));
        let trusted: SmallVec<[DVec3; 2]> = (old.iter())
            .filter(|s| s.flatness >= TRUSTED)
            .map(|s| s.normal)
            .collect();
        let agree = |s: &Shape| trusted.iter().all(|n| n.dot(s.normal) >= TURN);
        if !new.iter().all(agree) || new[0].normal.dot(new[1].normal) < TURN {
            return None;
        }
        let gap = crossing_gap([a, b].map(|v| self.at(v)), [c, d].map(|v| self.at(v)))?;
        Some(Flip {
            corners: [a, b, c, d],
            old,
            new,
            gap,
        })
    }

    /// Shape of a triangle.
    pub(super) fn shape(&self, corners: [u32; 3]) -> Shape {
        Shape::of(corners.map(|v| self.at(v)))
    }

    /// Shape of a triangle whose corner `v` would lie at `to`.
    pub(super) fn shape_with(&self, corners: [u32; 3], v: u32, to: DVec3) -> Shape {
        Shape::of(corners.map(|w| if w == v { to } else { self.at(w) }))
    }

    /// Sine of the worst angle of the triangles at a vertex.
    pub(super) fn worst_around(&self, v: u32) -> f64 {
        let around = self.around(v).iter();
        let shapes = around.filter_map(|&t| Some(self.shape(self.corners(t)?)));
        shapes.fold(1.0, |worst, shape| worst.min(shape.sine))
    }

    /// Sine of the worst angle at a vertex if it lay at `to`; `None` if a
    /// triangle would turn over.
    pub(super) fn moved(&self, v: u32, to: DVec3) -> Option<f64> {
        let mut worst: f64 = 1.0;
        for &t in self.around(v) {
            let c = self.corners(t)?;
            let (old, new) = (self.shape(c), self.shape_with(c, v, to));
            if !self.keeps_direction(t, c, &old, &new) {
                return None;
            }
            worst = worst.min(new.sine);
        }
        Some(worst)
    }

    /// Whether a triangle that changes a corner still faces the same way.
    ///
    /// If it had no normal to trust, it is held against those of its
    /// neighbours that have one.
    pub(super) fn keeps_direction(&self, t: u32, c: [u32; 3], old: &Shape, new: &Shape) -> bool {
        if old.flatness >= TRUSTED {
            return old.normal.dot(new.normal) >= TURN;
        }
        let mut told = false;
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            let Some(wings) = self.wings(a, b) else {
                continue;
            };
            let Some(&(_, apex)) = wings.iter().find(|w| w.0 != t) else {
                continue;
            };
            // Turned as this triangle is, whatever the neighbour's own turn.
            let neighbour = self.shape([b, a, apex]);
            if neighbour.flatness >= TRUSTED {
                told = true;
                if neighbour.normal.dot(new.normal) < 0.0 {
                    return false;
                }
            }
        }
        told || old.normal.dot(new.normal) >= 0.0
    }
}
