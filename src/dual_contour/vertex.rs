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

/// A step to the surface from a value below this times the cell needs no query
/// to verify it: what it misses is of the square of that over the radius of
/// curvature.
const NEXT_TO: f64 = 1e-3;

/// Steps after which elements that did not meet are given up: three or four to
/// the meeting place, for each of a few changes of elements.
const MEETING_STEPS: usize = 40;

/// Pairs of elements tried for a crease after the likeliest.
const MOST_PAIRS: usize = 6;

/// A crease this far from a cell, in cells, is just missed, and the vertex is
/// looked for at these distances from the cell's faces, in cells.
const NEAR_MISS: f64 = 0.5;
const NEAR_MISS_INSETS: [f64; 4] = [0.01, 0.04, 0.1, 0.2];

/// Vertex of the result.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub position: DVec3,
    /// Outward normal of the surface, or of one of its sides on a crease.
    pub normal: Vec3,
    /// On a crease or corner.
    pub sharp: bool,
}

/// How far the chord between two vertices may stray, from their normals: a
/// quarter more than an arc between them would. From a sharp vertex, whose
/// normal is that of one side only, the chord to a smooth one strays if it
/// leaves that one's tangent plane; between two sharp ones it may do anything.
pub(super) fn stray(a: &Vertex, b: &Vertex) -> f64 {
    let chord = a.position - b.position;
    let off = |v: &Vertex| 0.3 * chord.dot(v.normal.as_dvec3()).abs();
    match (a.sharp, b.sharp) {
        (false, false) => 0.16 * f64::from((a.normal - b.normal).length()) * chord.length(),
        (true, false) => off(b),
        (false, true) => off(a),
        (true, true) => f64::INFINITY,
    }
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
    pub gradient: DVec3,
    pub sharp: bool,
}

impl Candidate {
    /// Whether the surface turns between two places as at a crease.
    pub fn turned(&self, other: &Candidate) -> bool {
        self.gradient.dot(other.gradient) < SPREAD
    }

    pub fn vertex(&self) -> Vertex {
        Vertex {
            position: self.position,
            normal: self.gradient.as_vec3(),
            sharp: self.sharp,
        }
    }
}

impl<I: Implicit> Finder<'_, I> {
    /// The vertex of a loop; `allowed` tells whether a place strictly inside
    /// the cell will do. The mass point has to.
    pub fn in_cell(&mut self, allowed: impl Fn(DVec3) -> bool) -> Vertex {
        let cell = self.cell;
        let fits = |p: DVec3| cell.contains(p) && allowed(p);
        let mass = qef::mass_point(self.crossings);
        let bent = self.spread() < SPREAD;
        let crease = bent.then(|| self.crease(mass, &fits)).flatten();
        let found = crease
            .or_else(|| bent.then(|| self.near_miss(mass, &fits)).flatten())
            .unwrap_or_else(|| self.smooth(mass, &fits));
        Vertex {
            position: self.grid.settle(found.position, &cell),
            sharp: crease.is_some(),
            ..found.vertex()
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
        let mut found = crease.unwrap_or_else(|| self.smooth(start, &fits));
        found.sharp = crease.is_some();
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
            sharp: false,
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
        let corner = third.and_then(|c| self.meet(&mut [a, b, c], start));
        // If the corner is in another cell, one of its creases is here. The
        // sharpest first; the others may be hardly bent.
        corner.filter(|found| fits(found.position)).or_else(|| {
            let sharp = self.on_line([a, b], start, mass, fits);
            let third = third.into_iter().flat_map(|c| [[b, c], [a, c]]);
            sharp.or_else(|| {
                third
                    .chain(self.other_pairs([a, b]))
                    .find_map(|pair| self.on_line(pair, start, mass, fits))
            })
        })
    }

    /// Where a crease just misses the cell, the nearest place of the surface
    /// that fits: the cell's edges do not see how thin the solid gets there,
    /// and the mass point would leave a notch.
    fn near_miss(&mut self, mass: DVec3, fits: &impl Fn(DVec3) -> bool) -> Option<Candidate> {
        let start = qef::minimise(self.crossings, mass);
        let (mut pair, _) = self.sides();
        let missed = self.meet(&mut pair, start)?.position;
        if self.cell.clamp(missed, 0.0).distance(missed) > NEAR_MISS * self.grid.cell() {
            return None;
        }
        // The farther inside, the less the surface's sides cut each other off.
        let mut best: Option<Candidate> = None;
        for inset in NEAR_MISS_INSETS {
            let start = self.cell.clamp(missed, inset);
            if fits(start) {
                let found = self.descend(start, pair[0], fits);
                if best.is_none_or(|b| found.value.abs() < b.value.abs()) {
                    best = Some(found);
                }
                if found.value.abs() <= 1e3 * self.zero() {
                    break;
                }
            }
        }
        best.filter(|b| b.value.abs() <= 1e3 * self.zero())
    }

    /// Pairs of elements whose normals differ, but for one pair, the most
    /// different first. A crease between elements that are nearly one plane
    /// each (a strip's neighbour, a facet's) may pass where theirs does not.
    fn other_pairs(&self, but: [u32; 2]) -> SmallVec<[[u32; 2]; 4]> {
        let mut found: SmallVec<[(f64, [u32; 2]); 4]> = SmallVec::new();
        for [a, b] in self.pairs() {
            let cosine = a.normal.dot(b.normal);
            let pair = [a.element.min(b.element), a.element.max(b.element)];
            let known = |&(_, other): &(f64, [u32; 2])| other == pair;
            if cosine < SPREAD
                && pair != [but[0].min(but[1]), but[0].max(but[1])]
                && !found.iter().any(known)
            {
                found.push((cosine, pair));
            }
        }
        found.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        found.truncate(MOST_PAIRS);
        found.into_iter().map(|(_, pair)| pair).collect()
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
    pub fn meet(&mut self, elements: &mut [u32], start: DVec3) -> Option<Candidate> {
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
                    if elements.contains(&by) {
                        return None;
                    }
                    elements[i] = by;
                    continue;
                }
                if elements.contains(&nearest) {
                    return None;
                }
                let like = |i: &usize| normals[*i].dot(found.gradient);
                let i = (0..elements.len()).max_by(|a, b| like(a).total_cmp(&like(b)))?;
                elements[i] = nearest;
                continue;
            }
            if let Some(axis) = self.flat {
                values.push(0.0);
                normals.push(DVec3::AXES[axis]);
            }
            p += least_step(&values, &normals)?;
            let far = p.distance(self.cell.centre());
            if far.is_nan() || far > 4.0 * self.grid.cell() {
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

    /// A point of the surface that fits, or the nearest miss; at worst `mass`.
    fn smooth(&mut self, mass: DVec3, fits: &impl Fn(DVec3) -> bool) -> Candidate {
        let mut best = self.descend(mass, self.crossings[0].element, fits);
        // From the mass point the way led out of the cell or face: start beside
        // each crossing instead.
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
    pub fn descend(&mut self, start: DVec3, hint: u32, fits: &impl Fn(DVec3) -> bool) -> Candidate {
        let (mut best, mut hint) = self.sample(start, hint);
        let mut here = best;
        for _ in 0..5 {
            if best.value.abs() <= self.zero() {
                break;
            }
            let down = self.in_plane(here.gradient);
            let step = here.value / down.length_squared() * down;
            // Half-way is better than nothing.
            let reached = [1.0, 0.5, 0.25].map(|part| here.position - part * step);
            let Some(next) = reached.into_iter().find(|&p| fits(p)) else {
                break;
            };
            if here.value.abs() <= NEXT_TO * self.grid.cell() && next == reached[0] {
                best.position = next;
                best.value = 0.0;
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
