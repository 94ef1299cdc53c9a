//! The re-thickened solid as a function.

use glam::DVec3;

use super::ends::Ends;
use super::slab::Slab;
use super::surface::BallSurface;
use super::tree::Tree;
use crate::dual_contour::{Bracket, Crossing, Implicit, Sample, hybrid};
use crate::mesh::Bounds;

/// Union of the slabs of all triangles, each cut off at flat ends near it.
///
/// The function is the least over the triangles of the greater of slab and
/// cut. Elements are the triangles, then the planes of the ends: a slab is
/// smooth all round, so creases are only where slabs or planes meet.
pub(super) struct SlabSolid {
    slabs: Vec<Slab>,
    tree: Tree,
    ends: Ends,
    bounds: Bounds,
    /// Values below this are zero.
    tolerance: f64,
}

/// Steps to an element's own crossing.
const ROOT_STEPS: usize = 40;

impl SlabSolid {
    pub fn new(surface: &BallSurface) -> SlabSolid {
        let of = |t: &[u32; 3]| {
            let corners = t.map(|v| surface.positions[v as usize]);
            Slab::new(corners, t.map(|v| surface.radii[v as usize]))
        };
        let slabs: Vec<Slab> = surface.triangles.iter().map(of).collect();
        let used = surface.triangles.iter().flatten().map(|&v| v as usize);
        let bounds = Bounds::of(used.flat_map(|v| {
            let (p, r) = (surface.positions[v], surface.radii[v]);
            [p - r, p + r]
        }));
        SlabSolid {
            tree: Tree::build(&slabs),
            ends: Ends::new(surface, &slabs),
            slabs,
            tolerance: 1e-13 * (bounds.diagonal() + bounds.center().abs().max_element()),
            bounds,
        }
    }

    /// A box around the surface.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// A slab with its cut: value, gradient and what decides.
    fn cut_slab(&self, slab: u32, p: DVec3, limit: f64) -> Option<Sample> {
        let shape = &self.slabs[slab as usize];
        let ball = shape.nearest(p);
        if ball.value > limit {
            return None;
        }
        let cut = self.ends.beyond(slab, shape.greatest_radius(), p);
        let (value, gradient, element) = match cut {
            Some((beyond, end)) if beyond > ball.value => {
                let (_, outward) = self.ends.plane(end, p);
                (beyond, outward, self.slabs.len() as u32 + end)
            }
            _ => (ball.value, shape.direction(p, &ball), slab),
        };
        Some(Sample {
            value,
            gradient,
            unsigned: value.abs(),
            element,
        })
    }

    /// The slab with the least value at a point, cuts aside, if that is less
    /// than `limit`.
    fn nearest_slab(&self, p: DVec3, limit: f64) -> Option<u32> {
        let mut nearest = (limit, None);
        self.tree.search(p, limit, |slab| {
            let value = self.slabs[slab as usize].nearest(p).value;
            if value < nearest.0 {
                nearest = (value, Some(slab));
            }
            nearest.0
        });
        nearest.1
    }

    /// Slab to start the search with.
    fn slab_of(&self, element: u32) -> Option<u32> {
        let slabs = self.slabs.len() as u32;
        if element < slabs {
            Some(element)
        } else {
            self.ends.triangle(element - slabs)
        }
    }

    /// Where an element's own surface crosses a piece of a segment, if its
    /// ends are on different sides: false position, with the Illinois rule.
    fn root(&self, element: u32, from: DVec3, to: DVec3) -> Option<f64> {
        let at = |t: f64| self.element(from.lerp(to, t), element).0;
        let (mut low, mut high) = ((0.0, at(0.0)), (1.0, at(1.0)));
        if !(low.1 < 0.0 && high.1 > 0.0) {
            return None;
        }
        let mut last = 0;
        for _ in 0..ROOT_STEPS {
            let t: f64 = low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1));
            let value = at(t);
            if value.abs() <= 0.1 * self.tolerance || !(low.0 < t && t < high.0) {
                return Some(t);
            }
            if value < 0.0 {
                low = (t, value);
                if last == -1 {
                    high.1 *= 0.5;
                }
                last = -1;
            } else {
                high = (t, value);
                if last == 1 {
                    low.1 *= 0.5;
                }
                last = 1;
            }
        }
        Some(0.5 * (low.0 + high.0))
    }
}

impl Implicit for SlabSolid {
    fn sample(&self, p: DVec3, hint: u32) -> Sample {
        let nothing = Sample {
            value: f64::INFINITY,
            gradient: DVec3::Z,
            unsigned: f64::INFINITY,
            element: u32::MAX,
        };
        let hinted = self.slab_of(hint);
        let mut best = hinted
            .and_then(|slab| self.cut_slab(slab, p, f64::INFINITY))
            .unwrap_or(nothing);
        self.tree.search(p, best.value, |slab| {
            if let Some(found) = self.cut_slab(slab, p, best.value)
                && (found.value, found.element) < (best.value, best.element)
            {
                best = found;
            }
            best.value
        });
        best
    }

    fn element(&self, p: DVec3, element: u32) -> (f64, DVec3) {
        let slabs = self.slabs.len() as u32;
        if element < slabs {
            let slab = &self.slabs[element as usize];
            let ball = slab.nearest(p);
            (ball.value, slab.direction(p, &ball))
        } else if ((element - slabs) as usize) < self.ends.len() {
            self.ends.plane(element - slabs, p)
        } else {
            (f64::INFINITY, DVec3::Z)
        }
    }

    fn covered(&self, p: DVec3, element: u32, tolerance: f64) -> Option<u32> {
        let is_slab = (element as usize) < self.slabs.len();
        is_slab.then(|| self.nearest_slab(p, -tolerance)).flatten()
    }

    /// The one slab that meets cuts is any: the nearest. Where several meet,
    /// each is meant.
    fn stand_in(&self, p: DVec3, elements: &mut [u32]) {
        let count = self.slabs.len();
        let mut slabs = elements.iter_mut().filter(|e| (**e as usize) < count);
        if let (Some(slab), None) = (slabs.next(), slabs.next()) {
            let value = self.slabs[*slab as usize].nearest(p).value;
            *slab = self.nearest_slab(p, value).unwrap_or(*slab);
        }
    }

    /// The elements at the ends guess by their own crossing.
    fn crossing(&self, ends: [DVec3; 2], samples: [Sample; 2]) -> Crossing {
        let guess = |bracket: &Bracket| {
            let [from, to] = bracket.ends;
            let elements = bracket.samples.map(|s| s.element).into_iter();
            elements
                .filter(|_| !bracket.shaky)
                .find_map(|element| self.root(element, from, to))
        };
        hybrid(self, ends, samples, 1.0, self.tolerance, guess).crossing
    }
}
