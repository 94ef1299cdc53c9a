//! A bicubic B-spline patch over a square of a face's parameters.

use std::ops::Range;

use glam::DVec3;

/// Position and derivatives of a surface by the parameters of its face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// The point.
    pub point: DVec3,
    /// First derivative by u.
    pub du: DVec3,
    /// First derivative by v.
    pub dv: DVec3,
    /// Second derivative by u.
    pub duu: DVec3,
    /// Mixed second derivative.
    pub duv: DVec3,
    /// Second derivative by v.
    pub dvv: DVec3,
}

impl Jet {
    /// Normal by (2.3) before it is made a unit.
    pub fn cross(&self) -> DVec3 {
        self.du.cross(self.dv)
    }

    /// The difference of two surfaces.
    pub fn minus(&self, other: &Jet) -> Jet {
        Jet {
            point: self.point - other.point,
            du: self.du - other.du,
            dv: self.dv - other.dv,
            duu: self.duu - other.duu,
            duv: self.duv - other.duv,
            dvv: self.dvv - other.dvv,
        }
    }
}

/// Sixteen control points, `net[i][j]` with i along u and j along v, over
/// `[u0, u0 + size] x [v0, v0 + size]`.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Relative to `origin`, so that small patches beside an extraordinary
    /// vertex keep all their digits.
    pub net: [[DVec3; 4]; 4],
    pub origin: DVec3,
    pub u0: f64,
    pub v0: f64,
    pub size: f64,
}

/// Cubic B-spline weights at `t` in [0, 1], first and second derivatives.
#[inline]
fn basis(t: f64) -> [[f64; 4]; 3] {
    let s = 1.0 - t;
    [
        [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0,
            t * t * t / 6.0,
        ],
        [
            -s * s / 2.0,
            (3.0 * t * t - 4.0 * t) / 2.0,
            (-3.0 * t * t + 2.0 * t + 1.0) / 2.0,
            t * t / 2.0,
        ],
        [s, 3.0 * t - 2.0, -3.0 * t + 1.0, t],
    ]
}

#[inline]
fn weigh(weights: &[f64; 4], points: &[DVec3; 4]) -> DVec3 {
    weights[0] * points[0]
        + weights[1] * points[1]
        + weights[2] * points[2]
        + weights[3] * points[3]
}

impl Patch {
    /// Everything at a place within the patch.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let inv = 1.0 / self.size;
        let [b, db, ddb] = basis((u - self.u0) * inv);
        let [c, dc, ddc] = basis((v - self.v0) * inv);
        let rows = |weights: &[f64; 4]| self.net.map(|row| weigh(weights, &row));
        let (along, slope, bend) = (rows(&c), rows(&dc), rows(&ddc));
        Jet {
            point: self.origin + weigh(&b, &along),
            du: inv * weigh(&db, &along),
            dv: inv * weigh(&b, &slope),
            duu: inv * inv * weigh(&ddb, &along),
            duv: inv * inv * weigh(&db, &slope),
            dvv: inv * inv * weigh(&b, &bend),
        }
    }

    /// Of `0..=n` samples along u, and along v, those that are this patch's:
    /// on its square without the upper sides, unless those end the face.
    pub fn samples(&self, n: usize) -> [Range<usize>; 2] {
        [self.u0, self.v0].map(|low| {
            // Dyadic numbers and small whole ones: exact.
            let ceil = |t: f64| (t * n as f64).ceil() as usize;
            let high = low + self.size;
            ceil(low)..if high == 1.0 { n + 1 } else { ceil(high) }
        })
    }

    /// Points, and normals before they are made units, at the samples
    /// `(i / n, j / n)` of the ranges, row by row in i.
    pub fn sweep(
        &self,
        n: usize,
        [us, vs]: [Range<usize>; 2],
        scratch: &mut Scratch,
        mut put: impl FnMut(usize, usize, &[[f64; 6]]),
    ) {
        if us.is_empty() || vs.is_empty() {
            return;
        }
        let step = 1.0 / n as f64;
        let inv = 1.0 / self.size;
        scratch.along.clear();
        scratch.along.extend(vs.clone().map(|j| {
            let [c, dc, _] = basis((j as f64 * step - self.v0) * inv);
            [c, dc]
        }));
        scratch.row.resize(vs.len(), [0.0; 6]);
        for i in us {
            let [b, db, _] = basis((i as f64 * step - self.u0) * inv);
            let mut place = [DVec3::ZERO; 4];
            let mut slope = [DVec3::ZERO; 4];
            for (k, row) in self.net.iter().enumerate() {
                for (j, &p) in row.iter().enumerate() {
                    place[j] += b[k] * p;
                    slope[j] += db[k] * p;
                }
            }
            for ([c, dc], out) in scratch.along.iter().zip(&mut scratch.row) {
                let p = self.origin + weigh(c, &place);
                let normal = weigh(c, &slope).cross(weigh(dc, &place));
                *out = [p.x, p.y, p.z, normal.x, normal.y, normal.z];
            }
            put(i, vs.start, &scratch.row);
        }
    }
}

/// Buffers of [`Patch::sweep`].
#[derive(Default)]
pub(super) struct Scratch {
    along: Vec<[[f64; 4]; 2]>,
    row: Vec<[f64; 6]>,
}
