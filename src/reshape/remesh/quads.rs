//! Quadrilaterals: which triangles pair, and better shapes for what comes of it.
//!
//! Which triangles pair is a matching among the pairs that make a good
//! quadrilateral (Remacle and others, "Blossom-Quad", 2012), grown by
//! augmenting paths of bounded length: unlike the maximum matching there, it
//! takes time in proportion to the mesh. All is then cut up to quadrilaterals
//! ([`halve`](super::halve)), and vertices move so that corners come nearer to
//! right angles. The halves stay in the mesh: whoever takes no quadrilaterals
//! takes them.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::Remesher;
use super::relax::Move;
use crate::reshape::complex::Rank;

/// What a pair of triangles must be as a quadrilateral.
#[derive(Clone, Copy)]
pub(super) struct Pairing {
    /// Scaled Jacobian that it must have.
    pub(super) least: f64,
    /// Most that it may bend over either diagonal, degrees.
    pub(super) warp: f64,
}

/// What solvers ask for is a scaled Jacobian of a half and a bend of ten degrees.
const SOLVABLE: Pairing = Pairing {
    least: 0.5,
    warp: 10.0,
};

/// Rounds of moving vertices.
const ROUNDS: usize = 8;

/// Rounds of searching better places for the corners of poor ones after that.
const POLISH: usize = 4;

/// A move may lower the worst quality down to this.
const FREE: f64 = 0.8;

/// Quadrilaterals of a lower quality are poor.
const POOR: f64 = 0.6;

/// Steps of that search, against the size wanted.
const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// No half of a quadrilateral gets a sine of its least angle below this: that of
/// 17 degrees.
const FLATTEST: f64 = 0.3;

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

/// One for a square, a half where the scaled Jacobian or the bend is as bad as
/// solvers take.
fn quality(p: [DVec3; 4]) -> f64 {
    jacobian(p).min(1.0 - 0.5 * warp(p) / SOLVABLE.warp)
}

/// What makes a triangle half of a quadrilateral: its other half, and the
/// corners of both.
pub(super) type Half = (u32, [u32; 4]);

/// The other half of each triangle that has one.
pub(super) type Halves = Vec<Option<Half>>;

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
    /// Cuts all up to quadrilaterals, betters their shapes, and pairs the
    /// triangles of those that are good, lower triangle first, by the numbers of
    /// the finished mesh.
    pub(super) fn quadrilaterals(&mut self, straight: bool) -> Vec<[u32; 2]> {
        let quads = self.halve();
        if straight {
            self.straighten(&|this| this.relax_quads(&quads));
        }
        for _ in 0..ROUNDS {
            self.relax_quads(&quads);
        }
        for _ in 0..POLISH {
            self.approach(1.0);
            self.nudge_quads(&quads);
            self.relax_quads(&quads);
        }
        self.cut_to_quads(&quads);
        let good = |&(_, &quad): &(u32, &[u32; 4])| self.makes(quad, SOLVABLE);
        let pairs = (0..).zip(&quads).filter(good);
        pairs.map(|(n, _)| [2 * n, 2 * n + 1]).collect()
    }

    /// Whether four vertices make a quadrilateral that is wanted.
    fn makes(&self, quad: [u32; 4], wanted: Pairing) -> bool {
        let p = quad.map(|v| self.complex.at(v));
        jacobian(p) >= wanted.least && warp(p) <= wanted.warp
    }

    /// Pairs triangles, those of the best shape first, then along paths on
    /// which pairs and other good neighbours alternate: such a path between two
    /// lone triangles gives one pair more.
    pub(super) fn matched(&self, pairing: Pairing) -> Halves {
        let count = self.complex.triangle_count();
        let mut wanted: Vec<(f64, u32, u32, [u32; 4])> = Vec::new();
        for (a, b) in self.complex.edges() {
            let Some([(s, c), (t, d)]) = self.complex.wings(a, b) else {
                continue;
            };
            // Both triangles run the same way round the quadrilateral.
            let quad = corners([a, b], c, d);
            if self.makes(quad, pairing) {
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

    /// The worst quality of the quadrilaterals at a vertex if it lay at `to`.
    fn worst_quad(&self, v: u32, to: DVec3, quads: &[[u32; 4]]) -> f64 {
        let at = |w: u32| if w == v { to } else { self.complex.at(w) };
        let around = self.complex.around(v).iter();
        let qualities = around.map(|&t| quality(quads[t as usize / 2].map(at)));
        qualities.fold(1.0, f64::min)
    }

    /// Moves vertices towards the middle of the quadrilaterals round them, two
    /// triangles of the mesh each.
    fn relax_quads(&mut self, quads: &[[u32; 4]]) {
        let this = &*self;
        let moves: Vec<Option<Move>> = (0..self.vertices.len() as u32)
            .into_par_iter()
            .map(|v| match this.complex.rank(v) {
                Rank::Inner => this.on_sheet(v, this.quad_centre(v, quads)?),
                Rank::Line => this.relaxed_on_line(v),
                Rank::Corner => None,
            })
            .collect();
        for (v, found) in (0..).zip(moves) {
            let Some(found) = found else { continue };
            let old = self.worst_quad(v, self.complex.at(v), quads);
            if self.worst_quad(v, found.vertex.at, quads) >= old.min(FREE) {
                self.try_move(v, found, |new, old| new >= old.min(FLATTEST));
            }
        }
    }

    /// Middle of the neighbours across the sides of quadrilaterals, not across
    /// their diagonals.
    fn quad_centre(&self, v: u32, quads: &[[u32; 4]]) -> Option<DVec3> {
        let mut sides: SmallVec<[u32; 16]> = self.neighbours(v);
        for &t in self.complex.around(v) {
            let quad = quads[t as usize / 2];
            if let Some(k) = quad.iter().position(|&w| w == v) {
                sides.retain(|w| *w != quad[(k + 2) % 4]);
            }
        }
        let sum: DVec3 = sides.iter().map(|&w| self.complex.at(w)).sum();
        (!sides.is_empty()).then(|| sum / sides.len() as f64)
    }

    /// Searches better places for the corners of poor quadrilaterals.
    fn nudge_quads(&mut self, quads: &[[u32; 4]]) {
        for &quad in quads {
            if quality(quad.map(|v| self.complex.at(v))) < POOR {
                for v in quad {
                    self.nudge_corner(v, quads);
                }
            }
        }
    }

    fn nudge_corner(&mut self, v: u32, quads: &[[u32; 4]]) {
        for share in STEPS {
            let old = self.worst_quad(v, self.complex.at(v), quads);
            let options = self.options(v, share * self.size[v as usize], &|to| {
                self.worst_quad(v, to, quads) > old
            });
            let best = (options.into_iter())
                .map(|m| (self.worst_quad(v, m.vertex.at, quads), m))
                .filter(|(new, _)| *new > 1.001 * old)
                .max_by(|p, q| p.0.total_cmp(&q.0));
            if let Some((_, to)) = best {
                self.try_move(v, to, |new, old| new >= old.min(FLATTEST));
            }
        }
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
