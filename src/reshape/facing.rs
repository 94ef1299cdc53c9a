//! Which way triangles of a complex face, and how an edit would turn them.

use glam::DVec3;

use super::complex::Complex;
use super::shape::Shape;

/// A triangle keeps its direction if its normal turns by less than 60 degrees.
pub(super) const TURN: f64 = 0.5;

/// Flatter triangles have no normal to trust: on a curved sheet the sagitta
/// of the long side rivals the height.
pub(super) const TRUSTED: f64 = 0.05;

impl Complex {
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
