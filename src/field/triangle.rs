//! The closest point of one triangle.
//!
//! Everything that asks for a distance ends here, so that cold, warm and
//! brute-force searches compare the very same numbers.

use glam::DVec3;

use super::FaceId;

/// A triangle whose smallest height is below this fraction of its longest
/// side counts as thin: it is measured by its three edges alone.
///
/// The dual vectors of a triangle of height `h` and side `L` are off by about
/// `1e-16 L / h` in direction. At `1e-8` the in-plane error of a footpoint at
/// distance `d` is still below `1e-8 d`, and giving up the interior of a thinner
/// triangle moves its footpoints by less than `1e-8 L`.
const THIN: f64 = 1e-8;

/// A triangle whose smallest height is below this fraction of its longest side
/// has no area: its computed normal is rounding noise.
const NO_AREA: f64 = 1e-15;

/// Where on the triangle the closest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Off all edges.
    Face,
    /// Edge `i` runs between corners `i` and `(i + 1) % 3`.
    Edge(u8),
    /// Corner `i`.
    Corner(u8),
}

/// Closest point of a triangle to a query `p`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closest {
    /// `p - point`, computed from differences: more exact than the subtraction.
    pub offset: DVec3,
    pub point: DVec3,
    /// `offset` squared.
    pub square: f64,
    pub feature: Feature,
}

/// A triangle with what the closest-point test needs precomputed.
///
/// 128 bytes, two cache lines. Corners are kept as given, in part units, so
/// that a footpoint at a corner or along an edge has the same bits from every
/// triangle that shares it.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Triangle {
    pub corners: [DVec3; 3],
    /// Dual basis of `(b - a, c - a)` in the plane: `dual[i] . (p - a)` is the
    /// barycentric weight of corner `i + 1`.
    dual: [DVec3; 2],
    pub face: FaceId,
    flags: u32,
}

/// Bits 0 to 2: edge `i` runs from its lexicographically greater end.
const FLAG_THIN: u32 = 8;
const FLAG_DEGENERATE: u32 = 16;

const NEXT: [usize; 3] = [1, 2, 0];

impl Triangle {
    pub fn new(corners: [DVec3; 3], face: FaceId) -> Triangle {
        let mut flags = 0;
        for i in 0..3 {
            if comes_after(corners[i], corners[NEXT[i]]) {
                flags |= 1 << i;
            }
        }
        let Scaled { size, u, v, n } = Scaled::new(corners);
        let height2 = n.length_squared();
        let mut dual = [DVec3::ZERO; 2];
        // Written so that a height that is not a number is no height.
        if size.is_finite() && height2 > NO_AREA * NO_AREA {
            let square = height2 * size;
            dual = [v.cross(n) / square, n.cross(u) / square];
            if height2 < THIN * THIN || !dual[0].is_finite() || !dual[1].is_finite() {
                flags |= FLAG_THIN;
            }
        } else {
            flags |= FLAG_THIN | FLAG_DEGENERATE;
        }
        Triangle {
            corners,
            dual,
            face,
            flags,
        }
    }

    /// No area beyond rounding, or a corner that is not finite: left out of the
    /// trees.
    pub fn is_degenerate(&self) -> bool {
        self.flags & FLAG_DEGENERATE != 0
    }

    /// Without a normal to trust: without area, or so thin that it is measured
    /// by its edges alone.
    pub fn is_sliver(&self) -> bool {
        self.flags & FLAG_THIN != 0
    }

    /// Unit normal, counter-clockwise side; zero when degenerate.
    pub fn normal(&self) -> DVec3 {
        if self.is_degenerate() {
            return DVec3::ZERO;
        }
        Scaled::new(self.corners).n.normalize()
    }

    /// Closest point to `p`.
    ///
    /// The nearest point of a convex polygon seen from outside lies on an edge
    /// whose half-plane `p` violates, so at most two edges are measured.
    #[inline]
    pub fn closest(&self, p: DVec3) -> Closest {
        let [a, b, c] = self.corners;
        let q = p - a;
        let u = self.dual[0].dot(q);
        let v = self.dual[1].dot(q);
        let mut outside = 0;
        if v < 0.0 {
            outside |= 1;
        }
        if u + v > 1.0 {
            outside |= 2;
        }
        if u < 0.0 {
            outside |= 4;
        }
        if self.flags & FLAG_THIN != 0 {
            outside = 7;
        }
        if outside == 0 {
            let step = (b - a) * u + (c - a) * v;
            let offset = q - step;
            return Closest {
                offset,
                point: a + step,
                square: offset.length_squared(),
                feature: Feature::Face,
            };
        }
        self.closest_edge(p, outside)
    }

    /// Closest point on the edges whose bit is set; the lowest edge on a tie.
    #[inline]
    fn closest_edge(&self, p: DVec3, edges: u32) -> Closest {
        let first = edges.trailing_zeros() as usize % 3;
        let mut best = self.closest_on_edge(p, first);
        for i in first + 1..3 {
            if edges & (1 << i) != 0 {
                let other = self.closest_on_edge(p, i);
                if other.square < best.square {
                    best = other;
                }
            }
        }
        best
    }

    /// Closest point on edge `i`, run from its lexicographically smaller end,
    /// so that both neighbours compute the same bits.
    #[inline]
    fn closest_on_edge(&self, p: DVec3, i: usize) -> Closest {
        let (mut from, mut to) = (i, NEXT[i]);
        if self.flags & (1 << i) != 0 {
            (from, to) = (to, from);
        }
        let (start, end) = (self.corners[from], self.corners[to]);
        let edge = end - start;
        let q = p - start;
        let along = q.dot(edge);
        let length2 = edge.length_squared();
        let (offset, point, feature) = if along >= length2 && length2 > 0.0 {
            (p - end, end, Feature::Corner(to as u8))
        } else if along > 0.0 {
            let step = edge * (along / length2);
            (q - step, start + step, Feature::Edge(i as u8))
        } else {
            (q, start, Feature::Corner(from as u8))
        };
        Closest {
            offset,
            point,
            square: offset.length_squared(),
            feature,
        }
    }
}

/// A triangle brought to unit size, because squares of squares underflow early.
struct Scaled {
    /// Length of the longest side.
    size: f64,
    /// Sides from corner 0 to corners 1 and 2, over `size`.
    u: DVec3,
    v: DVec3,
    /// Their cross product: its length is the smallest height over `size`.
    n: DVec3,
}

impl Scaled {
    fn new([a, b, c]: [DVec3; 3]) -> Scaled {
        let sides = [b - a, c - a, c - b];
        // Scaled twice: the greatest coordinate first, so that no square
        // overflows or vanishes on the way to the length.
        let great = sides.map(|e| e.abs().max_element());
        let great = great[0].max(great[1]).max(great[2]);
        let lengths = sides.map(|e| (e / great).length());
        let size = lengths[0].max(lengths[1]).max(lengths[2]) * great;
        let (u, v) = (sides[0] / size, sides[1] / size);
        Scaled {
            size,
            u,
            v,
            n: u.cross(v),
        }
    }
}

fn comes_after(a: DVec3, b: DVec3) -> bool {
    (a.x, a.y, a.z) > (b.x, b.y, b.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(corners: [DVec3; 3], p: DVec3) -> f64 {
        let n = 60;
        let mut best = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                let q = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                best = best.min(q.distance(p));
            }
        }
        best
    }

    #[test]
    fn never_farther_than_any_sample() {
        let shapes = [
            [DVec3::ZERO, DVec3::X, DVec3::Y],
            [DVec3::ZERO, DVec3::X, DVec3::new(3.0, 0.2, 0.1)],
            [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.0, 1e-6, 0.0)],
            [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.0, 1e-11, 0.0)],
            [DVec3::ZERO, DVec3::X * 2.0, DVec3::X],
            [DVec3::X, DVec3::X, DVec3::X],
            [DVec3::ZERO, DVec3::ZERO, DVec3::ONE],
        ];
        for corners in shapes {
            let triangle = Triangle::new(corners, FaceId(0));
            for i in 0..1000 {
                let r = |k: i32| f64::from((i * 7919 + k * 104_729) % 1009) / 252.0 - 1.5;
                let p = DVec3::new(r(1), r(i), r(i / 3 + 2));
                let got = triangle.closest(p);
                let distance = got.square.sqrt();
                assert!(distance <= sampled(corners, p) + 1e-9, "{corners:?} {p}");
                assert!((got.point.distance(p) - distance).abs() < 1e-12);
                assert!(distance >= sampled(corners, p) - 0.1);
            }
        }
    }

    #[test]
    fn shared_edge_gives_same_bits_from_both_sides() {
        let (a, b) = (DVec3::new(0.1, 0.7, 0.3), DVec3::new(1.3, -0.2, 0.9));
        let left = Triangle::new([a, b, DVec3::new(0.0, 2.0, 0.0)], FaceId(0));
        let right = Triangle::new([b, a, DVec3::new(0.0, -2.0, 0.1)], FaceId(1));
        for i in 0..200 {
            let t = f64::from(i) / 100.0 - 0.5;
            let p = a.lerp(b, t) + DVec3::new(0.01, 0.02, 3.0 + t);
            let (l, r) = (left.closest_edge(p, 1), right.closest_edge(p, 1));
            assert_eq!(l.point, r.point);
            assert_eq!(l.square, r.square);
        }
    }

    #[test]
    fn tiny_and_huge_triangles_keep_their_area() {
        for scale in [1e-100, 1e-30, 1e-3, 1.0, 1e3, 1e30, 1e100] {
            let t = Triangle::new([DVec3::ZERO, DVec3::X * scale, DVec3::Y * scale], FaceId(0));
            assert!(!t.is_sliver(), "{scale}");
            let got = t.closest(DVec3::new(0.25, 0.25, 1.0) * scale);
            assert_eq!(got.feature, Feature::Face);
            assert!((t.normal() - DVec3::Z).length() < 1e-15);
        }
    }
}
