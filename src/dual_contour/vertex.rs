//! The vertex of one loop of a cell.
//!
//! The paper puts it where the quadratic error function is least. Ours starts
//! there and goes on with the exact function: on a smooth piece of surface to
//! the surface itself, on a crease or corner to where two or three elements
//! have a value of zero at once, changed for those that turn out to be nearer.
//! Whatever comes out must lie strictly inside the cell, which the proof of
//! the contouring rests on (section VI); what does not is replaced by the next
//! best.

use glam::{DMat3, DVec3, Vec3};
use smallvec::SmallVec;

use super::edges::Hermite;
use super::grid::{CellBox, Grid};
use super::implicit::Implicit;
use super::qef;

/// Normals of a cell that differ by more than this (8 degrees) may belong to
/// the two sides of a crease; that of a round are sorted out later.
const SPREAD: f64 = 0.99;

/// Gradients of two elements at a crease differ at least by this (6 degrees).
const CREASE: f64 = 0.994;

/// Determinant of three normals that fix a corner.
const CORNER: f64 = 0.08;

/// A value below this times the cell is zero.
const ZERO: f64 = 1e-9;

/// Steps after which elements that did not meet are given up: three or four to
/// the meeting place, for each of a few changes of elements.
const MEETING_STEPS: usize = 40;

/// Vertex of the result within a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellVertex {
    pub position: DVec3,
    /// Outward normal of the surface, or of one of its sides on a crease.
    pub normal: Vec3,
    /// On a crease or corner.
    pub sharp: bool,
}

/// What a vertex is looked for with.
pub(super) struct Finder<'a, I> {
    pub solid: &'a I,
    pub grid: &'a Grid,
    pub cell: CellBox,
    /// Crossings of the loop, or the two of a trace.
    pub crossings: &'a [Hermite],
    /// The vertex has to stay in the cell's lower face across this axis.
    pub flat: Option<usize>,
    /// Queries made.
    pub queries: u64,
}

/// A place and the function there.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub position: DVec3,
    pub value: f64,
    gradient: DVec3,
}

impl<I: Implicit> Finder<'_, I> {
    /// The vertex of a loop; `allowed` tells whether a place strictly inside
    /// the cell will do. The mass point has to.
    pub fn in_cell(&mut self, allowed: impl Fn(DVec3) -> bool) -> CellVertex {
        let cell = self.cell;
        let fits = |p: DVec3| cell.contains(p) && allowed(p);
        let mass = qef::mass_point(self.crossings);
        let crease = if self.spread() < SPREAD {
            self.crease(mass, &fits)
        } else {
            None
        };
        let found = crease.unwrap_or_else(|| self.smooth(mass, &fits));
        CellVertex {
            position: self.grid.settle(found.position, &self.cell),
            normal: found.gradient.as_vec3(),
            sharp: crease.is_some(),
        }
    }

    /// The vertex of a trace: a point of the surface in the lower face across
    /// `axis`, near `start`. `allowed` tells whether a place inside the face
    /// will do. What is found may be a near miss, at worst `start` itself.
    pub fn on_face(
        &mut self,
        axis: usize,
        start: DVec3,
        allowed: impl Fn(DVec3) -> bool,
    ) -> Candidate {
        self.flat = Some(axis);
        let cell = self.cell;
        let fits = |p: DVec3| cell.face_contains(p, axis) && allowed(p);
        let crease = if self.spread() < SPREAD {
            let mut pair = [self.crossings[0].element, self.crossings[1].element];
            self.meet(&mut pair, start).filter(|c| fits(c.position))
        } else {
            None
        };
        let mut found = crease.unwrap_or_else(|| {
            let hint = self.crossings[0].element;
            self.descend(start, hint, &fits)
        });
        found.position = self.grid.settle_on_face(found.position, &cell, axis);
        found
    }

    fn zero(&self) -> f64 {
        ZERO * self.grid.cell()
    }

    pub fn sample(&mut self, p: DVec3, hint: u32) -> (Candidate, u32) {
        self.queries += 1;
        let s = self.solid.sample(p, hint);
        let found = Candidate {
            position: p,
            value: s.value,
            gradient: s.gradient,
        };
        (found, s.element)
    }

    /// A direction as far as the vertex may follow it.
    fn in_plane(&self, mut direction: DVec3) -> DVec3 {
        if let Some(axis) = self.flat {
            direction[axis] = 0.0;
        }
        direction
    }

    /// Least cosine between two normals.
    fn spread(&self) -> f64 {
        let of = |h: &Hermite| self.in_plane(h.normal).normalize_or_zero();
        self.pairs()
            .map(|[a, b]| of(a).dot(of(b)))
            .fold(1.0, f64::min)
    }

    fn pairs(&self) -> impl Iterator<Item = [&Hermite; 2]> {
        let all = self.crossings;
        (0..all.len()).flat_map(move |i| (0..i).map(move |j| [&all[i], &all[j]]))
    }

    /// The crossings whose normals differ most: two, and a third if it fixes
    /// a corner with them.
    fn sides(&self) -> ([u32; 2], Option<u32>) {
        let mut best = (f64::INFINITY, [0; 2], [DVec3::ZERO; 2]);
        for [a, b] in self.pairs() {
            let cosine = a.normal.dot(b.normal);
            if cosine < best.0 {
                best = (cosine, [a.element, b.element], [a.normal, b.normal]);
            }
        }
        let (_, pair, normals) = best;
        let cross = normals[0].cross(normals[1]);
        let mut third = (CORNER, None);
        for h in self.crossings {
            let volume = cross.dot(h.normal).abs();
            if volume > third.0 {
                third = (volume, Some(h.element));
            }
        }
        (pair, third.1)
    }

    fn crease(&mut self, mass: DVec3, fits: &impl Fn(DVec3) -> bool) -> Option<Candidate> {
        let start = qef::minimise(self.crossings, mass);
        let ([a, b], third) = self.sides();
        let Some(c) = third else {
            return self.on_line([a, b], start, mass, fits);
        };
        let corner = self.meet(&mut [a, b, c], start);
        corner.filter(|found| fits(found.position)).or_else(|| {
            // The corner is in another cell: one of its creases is here.
            [[a, b], [b, c], [a, c]]
                .into_iter()
                .filter_map(|pair| self.on_line(pair, start, mass, fits))
                .min_by(|x, y| x.value.abs().total_cmp(&y.value.abs()))
        })
    }

    /// A point of the crease between two elements that fits.
    fn on_line(
        &mut self,
        mut pair: [u32; 2],
        start: DVec3,
        mass: DVec3,
        fits: &impl Fn(DVec3) -> bool,
    ) -> Option<Candidate> {
        let first = self.meet(&mut pair, start)?;
        if fits(first.position) {
            return Some(first);
        }
        // The crease may still pass through the cell further along.
        let [n, m] = pair.map(|e| self.solid.element(first.position, e).1);
        let direction = n.cross(m).normalize_or_zero();
        let [from, to] = self
            .cell
            .clip(first.position, direction)
            .unwrap_or([0.0; 2]);
        let along = (mass - first.position).dot(direction);
        // A crease that bends may leave a cell that it only just enters; then
        // try the middle of its way, and beside the crossings of either side.
        let along = |inset: f64| {
            let inset = inset * (to - from);
            let way = along.max(from + inset).min(to - inset);
            first.position + way * direction
        };
        let starts = [
            along(0.02),
            along(0.45),
            self.beside(n, m),
            self.beside(m, n),
        ];
        starts.into_iter().find_map(|start| {
            self.meet(&mut pair.clone(), start)
                .filter(|second| fits(second.position))
        })
    }

    /// Mean of the crossings whose normals are more like `n` than `m`.
    fn beside(&self, n: DVec3, m: DVec3) -> DVec3 {
        let side = self.crossings.iter();
        let (sum, count) = side
            .filter(|h| h.normal.dot(n - m) > 0.0)
            .fold((DVec3::ZERO, 0.0), |(sum, count), h| {
                (sum + h.point, count + 1.0)
            });
        if count > 0.0 {
            sum / count
        } else {
            qef::mass_point(self.crossings)
        }
    }

    /// Where all elements have a value of zero, near `start`, and no other
    /// element says otherwise: Newton's method, and elements changed for
    /// nearer ones.
    fn meet(&mut self, elements: &mut [u32], start: DVec3) -> Option<Candidate> {
        let mut p = start;
        for _ in 0..MEETING_STEPS {
            let mut values: SmallVec<[f64; 3]> = SmallVec::new();
            let mut normals: SmallVec<[DVec3; 3]> = SmallVec::new();
            self.solid.stand_in(p, elements);
            for &element in elements.iter() {
                let (value, normal) = self.solid.element(p, element);
                values.push(value);
                normals.push(normal);
            }
            let worst = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            if worst <= self.zero() {
                if normals[0].dot(normals[1]) > CREASE {
                    return None;
                }
                let (found, nearest) = self.sample(p, elements[0]);
                let exact = 10.0 * self.zero();
                if found.value.abs() <= exact {
                    let Some((i, by)) = self.covered(elements, p, exact) else {
                        return Some(found);
                    };
                    elements[i] = by;
                    continue;
                }
                if elements.contains(&nearest) {
                    return None;
                }
                let like = |i: &usize| normals[*i].dot(found.gradient);
                let Some(i) = (0..elements.len()).max_by(|a, b| like(a).total_cmp(&like(b))) else {
                    return None;
                };
                elements[i] = nearest;
                continue;
            }
            if let Some(axis) = self.flat {
                values.push(0.0);
                normals.push(DVec3::AXES[axis]);
            }
            let Some(step) = least_step(&values, &normals) else {
                return None;
            };
            p += step;
            if !(p.distance(self.cell.centre()) < 4.0 * self.grid.cell()) {
                return None;
            }
        }
        None
    }

    /// An element that another covers at `p`: its place in the list, and the
    /// other.
    fn covered(&self, elements: &[u32], p: DVec3, tolerance: f64) -> Option<(usize, u32)> {
        let of = |(i, &element)| Some((i, self.solid.covered(p, element, tolerance)?));
        elements.iter().enumerate().find_map(of)
    }

    /// A point of the surface that fits, or the nearest miss.
    fn smooth(&mut self, mass: DVec3, fits: &impl Fn(DVec3) -> bool) -> Candidate {
        let mut best = self.descend(mass, self.crossings[0].element, fits);
        // From the mass point the way led out of the cell: start beside each
        // crossing instead.
        for i in 0..self.crossings.len() {
            if best.value.abs() <= 1e3 * self.zero() {
                break;
            }
            let start = self.crossings[i].point.lerp(mass, 0.1);
            if fits(start) {
                let other = self.descend(start, self.crossings[i].element, fits);
                if other.value.abs() < best.value.abs() {
                    best = other;
                }
            }
        }
        best
    }

    /// Walks to the surface as long as that stays where it fits.
    fn descend(&mut self, start: DVec3, hint: u32, fits: &impl Fn(DVec3) -> bool) -> Candidate {
        let (mut best, mut hint) = self.sample(start, hint);
        let mut here = best;
        for _ in 0..5 {
            if best.value.abs() <= self.zero() {
                break;
            }
            let down = self.in_plane(here.gradient);
            let next = here.position - here.value / down.length_squared() * down;
            if !fits(next) {
                break;
            }
            (here, hint) = self.sample(next, hint);
            if here.value.abs() < best.value.abs() {
                best = here;
            }
        }
        best
    }
}

/// Shortest step that takes the linearised values to zero; none where the
/// normals are nearly dependent.
fn least_step(values: &[f64], normals: &[DVec3]) -> Option<DVec3> {
    match (values, normals) {
        (&[a, b], &[n, m]) => {
            let c = n.dot(m);
            let det = 1.0 - c * c;
            if det < 1e-4 {
                return None;
            }
            let (u, v) = ((-a + c * b) / det, (-b + c * a) / det);
            Some(u * n + v * m)
        }
        (&[a, b, c], &[n, m, k]) => {
            let matrix = DMat3::from_cols(n, m, k).transpose();
            (matrix.determinant().abs() > 1e-2).then(|| matrix.inverse() * -DVec3::new(a, b, c))
        }
        _ => None,
    }
}
