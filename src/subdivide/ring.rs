//! The surface around one extraordinary vertex, by stepping to sub-patches.
//!
//! After one step of the whole mesh, the two rings of faces around an
//! extraordinary vertex depend on themselves alone. A step halves them; the
//! part that it leaves free is regular, three patches a sector:
//!
//! ```text
//!   b
//!   2 +-----+-----+        new points, spacing 1; the vertex is at (0, 0).
//!     |  C  |  B  |        Sector i lies between spoke i (along a) and
//!   1 +-----+-----+        spoke i + 1 (along b).
//!     |again|  A  |
//!   0 +-----+-----+-- a
//!     0     1     2
//! ```
//!
//! The paper names eigen-decomposition for this. Stepping gives the same
//! points; it needs no table of eigenvectors for each valence, and serves
//! boundaries, creases, darts and corners alike. All is relative to the limit point, which each step takes
//! out anew, so that a relative accuracy near that of f64 stays at any depth.

use std::sync::Arc;

use glam::DVec3;

use super::dart::Mask;
use super::patch::Patch;
use super::refine::Quads;
use super::sharp::{Rule, Sector};

/// Points within a distance of the vertex, in steps along the spokes.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    sectors: usize,
    closed: bool,
    centre_rule: Centre,
    /// 2 after extraction, 3 after a step.
    radius: usize,
    centre: DVec3,
    /// Point (a, b) of sector i, a in `1..=radius`, b in `0..=radius`. An open
    /// ring has one sector more for its last spoke, b = 0 alone.
    points: Vec<DVec3>,
}

/// How the vertex itself moves.
#[derive(Clone, Debug)]
enum Centre {
    Smooth,
    /// As a smooth one, but to another limit.
    Dart(Arc<Mask>),
    Crease,
    Corner,
}

/// A place of a ring, for the arithmetic below.
type At = (usize, usize);

impl Ring {
    fn empty(sectors: usize, closed: bool, radius: usize, centre_rule: Centre) -> Ring {
        let stored = sectors + usize::from(!closed);
        Ring {
            sectors,
            closed,
            centre_rule,
            radius,
            centre: DVec3::ZERO,
            points: vec![DVec3::ZERO; stored * radius * (radius + 1)],
        }
    }

    fn slot(&self, sector: usize, (a, b): At) -> usize {
        let sector = if self.closed {
            sector % self.sectors
        } else {
            sector
        };
        (sector * self.radius + a - 1) * (self.radius + 1) + b
    }

    fn get(&self, sector: usize, (a, b): At) -> DVec3 {
        match (a, b) {
            (0, 0) => self.centre,
            // The other spoke of the sector is the first of the next.
            (0, _) => self.points[self.slot(sector + 1, (b, 0))],
            _ => self.points[self.slot(sector, (a, b))],
        }
    }

    fn set(&mut self, sector: usize, at: At, point: DVec3) {
        let slot = self.slot(sector, at);
        self.points[slot] = point;
    }

    /// The sector clockwise of one.
    fn before(&self, sector: usize) -> usize {
        if sector == 0 {
            self.sectors - 1
        } else {
            sector - 1
        }
    }

    /// A ring of another radius around the same vertex, without points.
    fn like(&self, radius: usize) -> Ring {
        Ring::empty(self.sectors, self.closed, radius, self.centre_rule.clone())
    }

    /// Whether a spoke lies on a cut.
    fn rim(&self, spoke: usize) -> bool {
        !self.closed && (spoke == 0 || spoke == self.sectors)
    }

    /// The two rings around a vertex in a sector of a mesh, relative to the limit
    /// point, which is returned too; `fine` is that mesh refined once.
    pub fn around(fine: &Quads, sector: &Sector) -> (Ring, DVec3) {
        let cage = fine.cage();
        let (faces, closed) = (sector.faces as usize, sector.closed);
        let centre_rule = match sector.rule {
            Rule::Smooth => Centre::Smooth,
            Rule::Dart => Centre::Dart(Arc::new(Mask::new(faces))),
            Rule::Crease => Centre::Crease,
            Rule::Corner => Centre::Corner,
        };
        let mut ring = Ring::empty(faces, closed, 2, centre_rule);
        // The half-edge of the face at that corner which leaves the vertex.
        let first = 4 * sector.first + sector.first % 4;
        ring.centre = cage.position(cage.origin(first));
        for (sector, h) in cage.sector(first).enumerate() {
            let ends = |h: u32| cage.position(cage.end(h));
            ring.set(sector, (1, 0), ends(h));
            ring.set(sector, (1, 1), ends(cage.next(h)));
            // Over the two inner edges of the old face; they have twins.
            if let Some(right) = cage.twin(cage.next(h)) {
                let far = cage.next(right);
                ring.set(sector, (2, 0), ends(far));
                ring.set(sector, (2, 1), ends(cage.next(far)));
                if let Some(corner) = cage.twin(cage.next(cage.next(far))) {
                    ring.set(sector, (2, 2), ends(cage.next(corner)));
                }
            }
            if let Some(above) = cage.twin(cage.next(cage.next(h))) {
                let far = cage.next(above);
                ring.set(sector, (1, 2), ends(far));
                if !closed && sector + 1 == ring.sectors {
                    let last = cage.position(cage.origin(cage.prev(h)));
                    ring.set(sector + 1, (1, 0), last);
                    ring.set(sector + 1, (2, 0), ends(cage.next(far)));
                }
            }
        }
        let limit = ring.limit();
        ring.shift(limit);
        (ring, limit)
    }

    /// Limit point of the vertex: (2.2), or that of a crease's curve.
    fn limit(&self) -> DVec3 {
        match &self.centre_rule {
            Centre::Smooth => {
                let n = self.sectors as f64;
                let [edges, faces] = self.sums();
                (n * n * self.centre + 4.0 * edges + faces) / (n * (n + 5.0))
            }
            Centre::Dart(mask) => {
                let edge = |i| self.get(i, (1, 0));
                mask.weigh(self.centre, edge, |i| self.get(i, (1, 1)))
            }
            Centre::Crease => (4.0 * self.centre + self.ends()) / 6.0,
            Centre::Corner => self.centre,
        }
    }

    /// Sums of the edge neighbours and of the face neighbours.
    fn sums(&self) -> [DVec3; 2] {
        let mut sums = [DVec3::ZERO; 2];
        for sector in 0..self.sectors {
            sums[0] += self.get(sector, (1, 0));
            sums[1] += self.get(sector, (1, 1));
        }
        sums
    }

    /// Sum of the neighbours on both cuts.
    fn ends(&self) -> DVec3 {
        self.get(0, (1, 0)) + self.get(self.sectors, (1, 0))
    }

    fn shift(&mut self, by: DVec3) {
        self.centre -= by;
        self.points.iter_mut().for_each(|p| *p -= by);
    }

    /// The ring at half the spacing, three points wide.
    pub fn step(&self) -> Ring {
        let mut new = self.like(3);
        let spokes = self.sectors + usize::from(!self.closed);
        for spoke in 0..spokes {
            self.step_spoke(spoke, &mut new);
        }
        for i in 0..self.sectors {
            let at = |a, b| self.get(i, (a, b));
            let face = |a, b| 0.25 * (at(a, b) + at(a + 1, b) + at(a + 1, b + 1) + at(a, b + 1));
            for (a, b) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                new.set(i, (2 * a + 1, 2 * b + 1), face(a, b));
            }
            let edge = |p: At, q: At, around: [At; 4]| {
                let others: DVec3 = around.iter().map(|&(a, b)| at(a, b)).sum();
                0.375 * (at(p.0, p.1) + at(q.0, q.1)) + 0.0625 * others
            };
            let across = [(0, 0), (0, 1), (2, 0), (2, 1)];
            new.set(i, (2, 1), edge((1, 0), (1, 1), across));
            let across = [(0, 1), (0, 2), (2, 1), (2, 2)];
            new.set(i, (2, 3), edge((1, 1), (1, 2), across));
            let across = [(0, 0), (1, 0), (0, 2), (1, 2)];
            new.set(i, (1, 2), edge((0, 1), (1, 1), across));
            let across = [(1, 0), (2, 0), (1, 2), (2, 2)];
            new.set(i, (3, 2), edge((1, 1), (2, 1), across));
            let edges = at(0, 1) + at(2, 1) + at(1, 0) + at(1, 2);
            let faces = at(0, 0) + at(2, 0) + at(2, 2) + at(0, 2);
            let vertex = 0.5625 * at(1, 1) + 0.09375 * edges + 0.015625 * faces;
            new.set(i, (2, 2), vertex);
        }
        new.centre = self.step_centre();
        // What is left of the limit point is rounding: relative to the ring it
        // would double with every step.
        let rest = new.limit();
        new.shift(rest);
        new
    }

    /// (2.1) at the vertex itself, or the rule of creases.
    fn step_centre(&self) -> DVec3 {
        match self.centre_rule {
            Centre::Smooth | Centre::Dart(_) => {
                let n = self.sectors as f64;
                let [edges, faces] = self.sums();
                (1.0 - 7.0 / (4.0 * n)) * self.centre
                    + 1.5 / (n * n) * edges
                    + 0.25 / (n * n) * faces
            }
            Centre::Crease => 0.75 * self.centre + 0.125 * self.ends(),
            Centre::Corner => self.centre,
        }
    }

    /// New points on a spoke.
    fn step_spoke(&self, i: usize, new: &mut Ring) {
        let (v, e, f) = (self.centre, self.get(i, (1, 0)), self.get(i, (2, 0)));
        if self.rim(i) {
            new.set(i, (1, 0), 0.5 * (v + e));
            new.set(i, (2, 0), 0.75 * e + 0.125 * (v + f));
            new.set(i, (3, 0), 0.5 * (e + f));
            return;
        }
        let left = |a| self.get(i, (a, 1));
        let right = |a| self.get(self.before(i), (1, a));
        let sides = |a| left(a) + right(a);
        new.set(i, (1, 0), 0.375 * (v + e) + 0.0625 * (sides(0) + sides(1)));
        let vertex = 0.5625 * e + 0.09375 * (v + f + sides(1)) + 0.015625 * (sides(0) + sides(2));
        new.set(i, (2, 0), vertex);
        new.set(i, (3, 0), 0.375 * (e + f) + 0.0625 * (sides(1) + sides(2)));
    }

    /// The inner two rings of a stepped ring, for the next step.
    pub fn inner(&self) -> Ring {
        let mut ring = self.like(2);
        ring.centre = self.centre;
        for sector in 0..self.sectors + usize::from(!self.closed) {
            for a in 1..=2 {
                for b in 0..=2 {
                    ring.set(sector, (a, b), self.points[self.slot(sector, (a, b))]);
                }
            }
        }
        ring
    }

    /// Point beside a sector: a or b may be -1, over a spoke.
    fn beside(&self, sector: usize, a: isize, b: isize) -> DVec3 {
        // A phantom row mirrors the inner one in the boundary.
        let mirror = |on: DVec3, inside: DVec3| 2.0 * on - inside;
        match (usize::try_from(a), usize::try_from(b)) {
            (Ok(a), Ok(b)) => self.get(sector, (a, b)),
            (Ok(a), Err(_)) if self.rim(sector) => {
                mirror(self.get(sector, (a, 0)), self.get(sector, (a, 1)))
            }
            (Ok(a), Err(_)) => self.get(self.before(sector), (1, a)),
            (Err(_), Ok(b)) if self.rim(sector + 1) => {
                mirror(self.get(sector, (0, b)), self.get(sector, (1, b)))
            }
            (Err(_), Ok(b)) => self.get(sector + 1, (b, 1)),
            // No patch reaches over two spokes.
            (Err(_), Err(_)) => self.centre,
        }
    }

    /// Patches A, B and C of a sector, whose vertex is corner `corner` of a
    /// face; `size` is the spacing in that face's parameters.
    pub fn patches(&self, sector: usize, corner: usize, size: f64, origin: DVec3) -> [Patch; 3] {
        [(1, 0), (1, 1), (0, 1)].map(|(a0, b0): (isize, isize)| {
            let net: [[DVec3; 4]; 4] = std::array::from_fn(|p| {
                std::array::from_fn(|q| {
                    self.beside(sector, a0 - 1 + p as isize, b0 - 1 + q as isize)
                })
            });
            let (a, b) = (a0 as f64 * size, b0 as f64 * size);
            let (a1, b1) = (1.0 - a - size, 1.0 - b - size);
            // From the corner's own axes to u and v of the face.
            let turned = |pick: fn(usize, usize) -> At| {
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        let (p, q) = pick(i, j);
                        net[p][q]
                    })
                })
            };
            let (net, u0, v0) = match corner {
                0 => (net, a, b),
                1 => (turned(|i, j| (j, 3 - i)), b1, a),
                2 => (turned(|i, j| (3 - i, 3 - j)), a1, b1),
                _ => (turned(|i, j| (3 - j, i)), b, a1),
            };
            Patch {
                net,
                origin,
                u0,
                v0,
                size,
            }
        })
    }
}
