//! Quadrilaterals: pairs of triangles without the edge between them.
//!
//! Which triangles pair is a matching among the pairs that make a good
//! quadrilateral (Remacle and others, "Blossom-Quad", 2012), grown by
//! augmenting paths of bounded length: unlike the maximum matching there, it
//! takes time in proportion to the mesh. Then vertices move so that corners
//! come nearer to right angles. The halves stay in the mesh: whoever takes no
//! quadrilaterals takes them.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::Remesher;
use super::relax::Move;
use crate::reshape::complex::Rank;

/// Scaled Jacobian that a pair must have; half is what solvers ask for.
const LEAST: f64 = 0.52;

/// A quadrilateral bends by less over either diagonal, degrees; ten is what
/// solvers ask for.
const WARP: f64 = 9.8;

/// Rounds of moving vertices.
const ROUNDS: usize = 8;

/// A move may lower the worst scaled Jacobian down to this.
const FREE: f64 = 0.8;

/// Pairs that may change partners to let one more pair in. A maximum matching
/// would search farther for next to nothing.
const LONGEST: usize = 9;

/// Corners of a quadrilateral in order, from the two triangles of an edge.
fn corners([a, b]: [u32; 2], c: u32, d: u32) -> [u32; 4] {
    [a, d, b, c]
}

/// The least scaled Jacobian of a quadrilateral's corners, with the sense of
/// its mean normal: 1 for a rectangle, 0 or less where it folds.
fn jacobian(p: [DVec3; 4]) -> f64 {
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    (0..4)
        .map(|k| {
            let (on, back) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            let length = (on.length_squared() * back.length_squared()).sqrt();
            on.cross(back).dot(normal) / length
        })
        .fold(1.0, |least, j| if j < least { j } else { least })
}

/// How far a quadrilateral bends over its diagonals, degrees, at most.
fn warp(p: [DVec3; 4]) -> f64 {
    let bend = |i: usize| {
        let q: [DVec3; 4] = std::array::from_fn(|k| p[(i + k) % 4]);
        let one = (q[1] - q[0]).cross(q[2] - q[0]);
        let two = (q[2] - q[0]).cross(q[3] - q[0]);
        one.angle_between(two).to_degrees()
    };
    let worst = bend(0).max(bend(1));
    if worst.is_finite() { worst } else { 180.0 }
}

/// What makes a triangle half of a quadrilateral: its other half, and the
/// corners of both.
type Half = (u32, [u32; 4]);

/// The other half of each triangle that has one.
type Halves = Vec<Option<Half>>;

/// A matching that grows.
struct Matching {
    /// Good other halves of each triangle, best first.
    options: Vec<SmallVec<[Half; 3]>>,
    halves: Halves,
}

impl Matching {
    fn is_lone(&self, t: u32) -> bool {
        self.halves[t as usize].is_none()
    }

    fn join(&mut self, s: u32, t: u32, quad: [u32; 4]) {
        self.halves[s as usize] = Some((t, quad));
        self.halves[t as usize] = Some((s, quad));
    }

    /// Gives a triangle another half over at most `depth` pairs that change
    /// partners; `path` holds the triangles on the way. Whether it did.
    fn augment(&mut self, t: u32, depth: usize, path: &mut SmallVec<[u32; 32]>) -> bool {
        path.push(t);
        for n in 0..self.options[t as usize].len() {
            let (s, quad) = self.options[t as usize][n];
            if path.contains(&s) {
                continue;
            }
            let partner = self.halves[s as usize].map(|half| half.0);
            let free = match partner {
                None => true,
                Some(p) if depth > 0 && !path.contains(&p) => {
                    path.push(s);
                    let moved = self.augment(p, depth - 1, path);
                    moved || {
                        path.pop();
                        false
                    }
                }
                Some(_) => false,
            };
            if free {
                self.join(t, s, quad);
                return true;
            }
        }
        path.pop();
        false
    }
}

impl Remesher<'_> {
    /// Pairs triangles and betters the pairs' shapes. Each pair is given once,
    /// lower triangle first, by the numbers of the finished mesh.
    pub(super) fn pair(&mut self) -> Vec<[u32; 2]> {
        let mut halves = self.matched();
        for _ in 0..ROUNDS {
            self.relax_quads(&halves);
        }
        // What has been bent or skewed beyond the bounds is parted again.
        for t in 0..halves.len() {
            if let Some((other, quad)) = halves[t]
                && !self.is_good(quad)
            {
                halves[t] = None;
                halves[other as usize] = None;
            }
        }
        let mut number = 0..;
        let numbers: Vec<Option<u32>> = (0..self.complex.triangle_count() as u32)
            .map(|t| self.complex.corners(t).and_then(|_| number.next()))
            .collect();
        let pairs = halves.iter().enumerate();
        pairs
            .filter_map(|(t, half)| {
                let (other, _) = (*half)?;
                let pair = [numbers[t]?, numbers[other as usize]?];
                (pair[0] < pair[1]).then_some(pair)
            })
            .collect()
    }

    fn is_good(&self, quad: [u32; 4]) -> bool {
        let p = quad.map(|v| self.complex.at(v));
        jacobian(p) >= LEAST && warp(p) <= WARP
    }

    /// Pairs triangles, those of the best shape first, then along paths on
    /// which pairs and other good neighbours alternate: such a path between two
    /// lone triangles gives one pair more.
    fn matched(&self) -> Halves {
        let count = self.complex.triangle_count();
        let mut wanted: Vec<(f64, u32, u32, [u32; 4])> = Vec::new();
        for (a, b) in self.complex.edges() {
            let Some([(s, c), (t, d)]) = self.complex.wings(a, b) else {
                continue;
            };
            // Both triangles run the same way round the quadrilateral.
            let quad = corners([a, b], c, d);
            if self.is_good(quad) {
                let quality = jacobian(quad.map(|v| self.complex.at(v)));
                wanted.push((quality, s, t, quad));
            }
        }
        wanted.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let mut matching = Matching {
            options: vec![SmallVec::new(); count],
            halves: vec![None; count],
        };
        for (_, s, t, quad) in wanted {
            matching.options[s as usize].push((t, quad));
            matching.options[t as usize].push((s, quad));
            if matching.is_lone(s) && matching.is_lone(t) {
                matching.join(s, t, quad);
            }
        }
        for depth in 1..=LONGEST {
            for t in 0..count as u32 {
                if matching.is_lone(t) {
                    matching.augment(t, depth, &mut SmallVec::new());
                }
            }
        }
        matching.halves
    }

    /// Moves vertices towards the middle of the elements round them.
    fn relax_quads(&mut self, halves: &Halves) {
        let this = &*self;
        let moves: Vec<Option<Move>> = (0..self.vertices.len() as u32)
            .into_par_iter()
            .map(|v| match this.complex.rank(v) {
                Rank::Inner => this.on_sheet(v, this.quad_centre(v, halves)?),
                Rank::Line => this.relaxed_on_line(v),
                Rank::Corner => None,
            })
            .collect();
        for (v, found) in moves.into_iter().enumerate() {
            let Some(found) = found else { continue };
            let v = v as u32;
            let to = found.vertex.at;
            let at = |w: u32| if w == v { to } else { self.complex.at(w) };
            let worst = |at: &dyn Fn(u32) -> DVec3| {
                let around = self.complex.around(v).iter();
                let quads = around.filter_map(|&t| halves[t as usize].map(|h| h.1));
                let good = |p: [DVec3; 4]| if warp(p) <= WARP { jacobian(p) } else { 0.0 };
                quads.map(|q| good(q.map(at))).fold(1.0, f64::min)
            };
            let (old, new) = (worst(&|w| self.complex.at(w)), worst(&at));
            if new >= old.min(FREE) {
                // Halves of a square have angles of 45 degrees.
                self.try_move(v, found, |new, old| new >= old.min(super::edits::POOR));
            }
        }
    }

    /// Middle of the neighbours across the sides of elements, not across the
    /// edges inside quadrilaterals.
    fn quad_centre(&self, v: u32, halves: &Halves) -> Option<DVec3> {
        let mut sides: SmallVec<[u32; 16]> = self.neighbours(v);
        for &t in self.complex.around(v) {
            if let Some((_, quad)) = halves[t as usize]
                && let Some(k) = quad.iter().position(|&w| w == v)
            {
                sides.retain(|w| *w != quad[(k + 2) % 4]);
            }
        }
        let sum: DVec3 = sides.iter().map(|&w| self.complex.at(w)).sum();
        (!sides.is_empty()).then(|| sum / sides.len() as f64)
    }

    /// Middles of all edges but those inside quadrilaterals, on their lines and
    /// sheets, where they are found; low vertex first, in order.
    pub(super) fn middles(&self) -> Vec<([u32; 2], DVec3)> {
        let mut number = 0..;
        let numbers: Vec<Option<u32>> = (0..self.vertices.len() as u32)
            .map(|v| {
                (!self.complex.around(v).is_empty())
                    .then(|| number.next())
                    .flatten()
            })
            .collect();
        let edges = self.complex.edges();
        (edges.into_par_iter())
            .filter_map(|(a, b)| {
                let (middle, chord) = self.halfway(a, b);
                let ends = [numbers[a as usize]?, numbers[b as usize]?];
                (!chord).then_some((ends, middle.at))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{jacobian, warp};
    use glam::DVec3;

    #[test]
    fn a_square_is_perfect_and_a_bent_one_warps() {
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert!((jacobian(square) - 1.0).abs() < 1e-12);
        assert!(warp(square) < 1e-6);
        let mut bent = square;
        bent[2].z = 0.2;
        assert!(warp(bent) > 10.0);
    }

    #[test]
    fn a_rhombus_has_the_sine_of_its_angle_and_a_dart_folds() {
        let h = 0.75f64.sqrt();
        let rhombus = [[0., 0.], [1., 0.], [1.5, h], [0.5, h]];
        let rhombus = rhombus.map(|[x, y]| DVec3::new(x, y, 0.0));
        assert!((jacobian(rhombus) - h).abs() < 1e-12);
        let dart = [[0., 0.], [1., 0.], [0.2, 0.2], [0., 1.]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert!(jacobian(dart) < 0.0);
    }
}
