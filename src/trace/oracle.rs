//! An independent answer to what a face or a tetrahedron holds, for tests:
//! every point inside the part is labelled by the wall that holds its nearest
//! wall point (the lower envelope of the wall distances), and the mid-surface
//! runs where labels change.
//!
//! A wall is what hangs together over triangle edges without passing coping,
//! so it serves parts on which that parts all walls: plates, bends, and
//! extruded tees and crosses.

use glam::DVec3;

use crate::field::Field;
use crate::mesh::sets::Sets;
use crate::mesh::{FaceId, Part};
use crate::walls::{Separation, Walls};

/// A part with its walls labelled.
pub(super) struct Oracle {
    pub(super) part: Part,
    pub(super) field: Field,
    labels: Vec<u32>,
}

/// A small generator of numbers, the same in every run.
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// From 0 up to 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point of a box.
    pub(super) fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        low + (high - low) * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

impl Oracle {
    /// A part of the `fixtures` folder.
    pub(super) fn new(name: &str) -> Oracle {
        let part = crate::surface::shapes::part(name);
        let field = Field::new(&part);
        let triangles = &part.mesh().triangles;
        let wall = |t: usize| !field.is_coping(FaceId(t as u32));
        let mut sets = Sets::new(triangles.len());
        let mut sides: Vec<([u32; 2], u32)> = (triangles.iter().enumerate())
            .filter(|(t, _)| wall(*t))
            .flat_map(|(t, c)| {
                [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]]
                    .map(|[a, b]| ([a.min(b), a.max(b)], t as u32))
            })
            .collect();
        sides.sort_unstable();
        for pair in sides.windows(2).filter(|p| p[0].0 == p[1].0) {
            sets.join(pair[0].1, pair[1].1);
        }
        let labels = (0..triangles.len() as u32).map(|t| sets.find(t)).collect();
        Oracle {
            part,
            field,
            labels,
        }
    }

    /// The walls as the followers see them.
    pub(super) fn walls(&self) -> Walls<'_> {
        let separation = Separation {
            min_angle: crate::extract::DEFAULT_ANGLE,
            keep_fins_from: None,
        };
        Walls::new(&self.part, &self.field, separation)
    }

    /// The wall that a triangle belongs to.
    pub(super) fn of(&self, face: FaceId) -> u32 {
        self.labels[face.index()]
    }

    /// The wall nearest to a point; none outside the part.
    pub(super) fn label(&self, p: DVec3) -> Option<u32> {
        let inside = self.field.inside(p);
        inside.then(|| self.of(self.field.footpoint(p).face))
    }

    /// Pairs of walls, in order, between which the label changes along a
    /// segment, sampled at so many steps; the part's own boundary is none.
    pub(super) fn changes(&self, from: DVec3, to: DVec3, steps: usize) -> Vec<[u32; 2]> {
        let labels: Vec<Option<u32>> = (0..=steps)
            .map(|k| self.label(from.lerp(to, k as f64 / steps as f64)))
            .collect();
        (labels.windows(2))
            .filter_map(|w| match (w[0], w[1]) {
                (Some(a), Some(b)) if a != b => Some([a, b]),
                _ => None,
            })
            .collect()
    }
}
