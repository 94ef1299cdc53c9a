//! How thick a wall may be before its inner surface folds.
//!
//! The inner surface for thickness x has the tangents `S_u - x a`, `S_v - x b`,
//! with a and b the derivatives of the unit crust, or of the unit normal. It
//! folds where `((S_u - x a) x (S_v - x b)) . N` turns negative: a quadratic
//! in x at every sample, whose smallest positive root is the thickness that is
//! still free of folds there.
//!
//! This sees local folds alone, at samples alone. It counts neither triangles,
//! which hide folds where they are few, nor places where far parts collide.

use glam::DVec3;
use rayon::prelude::*;

use super::crust::{Crust, blend};
use super::limit::LimitSurface;

/// Samples along a side of a face, in the middles of as many intervals: the
/// same at every level, as the crust ripples anew in every face.
const FINE: usize = 24;

/// Samples beyond which they are taken more coarsely, and the least a side.
const MOST: usize = 4_000_000;
const COARSE: usize = 6;

/// A normal shorter than that, against the mean, is the rounding of a
/// degenerate place.
const NO_NORMAL: f64 = 1e-10;

/// Greatest thickness without a local fold, and where it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldFree {
    /// Infinite where no thickness folds.
    pub thickness: f64,
    /// Point of the outer surface behind the first fold.
    pub at: DVec3,
}

impl FoldFree {
    const NONE: FoldFree = FoldFree {
        thickness: f64::INFINITY,
        at: DVec3::ZERO,
    };

    /// The smaller; the first of equal ones.
    fn least(self, other: FoldFree) -> FoldFree {
        if other.thickness < self.thickness {
            other
        } else {
            self
        }
    }
}

/// Fold-free thickness of the crust (3.3) and of direct offsetting (2.4).
///
/// Beside an extraordinary vertex of valence five or more the curvature of S is
/// unbounded, and with it that of direct offsetting: there its figure falls
/// with finer sampling.
pub fn fold_free(surface: &LimitSurface) -> [FoldFree; 2] {
    let faces = surface.face_count();
    let n = ((MOST / faces.max(1)).isqrt()).clamp(COARSE, FINE);
    let unit = Crust::offset(surface, 1.0);
    let typical = surface.mesh().cage().diagonal().powi(2) / faces as f64;
    let of_face = |face: usize| {
        let view = surface.face(face);
        let vectors = unit.corners(surface, face);
        let mut least = [FoldFree::NONE; 2];
        for cell in 0..n * n {
            let at = |k: usize| (k as f64 + 0.5) / n as f64;
            let (u, v) = (at(cell / n), at(cell % n));
            let jet = view.at(u, v);
            let cross = jet.cross();
            let length = cross.length();
            if length <= NO_NORMAL * typical {
                continue;
            }
            let crust = blend(vectors, u, v);
            // Derivatives of the unit normal.
            let normal = cross / length;
            let flat = |slope: DVec3| (slope - normal * normal.dot(slope)) / length;
            let by_u = flat(jet.duu.cross(jet.dv) + jet.du.cross(jet.duv));
            let by_v = flat(jet.duv.cross(jet.dv) + jet.du.cross(jet.dvv));
            for (k, [a, b]) in [[crust.du, crust.dv], [by_u, by_v]].into_iter().enumerate() {
                let linear = -(a.cross(jet.dv) + jet.du.cross(b)).dot(cross);
                let thickness = first_root(length * length, linear, a.cross(b).dot(cross));
                let at = jet.point;
                least[k] = least[k].least(FoldFree { thickness, at });
            }
        }
        least
    };
    let each: Vec<[FoldFree; 2]> = (0..faces).into_par_iter().map(of_face).collect();
    each.into_iter()
        .fold([FoldFree::NONE; 2], |[a, b], [c, d]| {
            [a.least(c), b.least(d)]
        })
}

/// Smallest positive root of `c + b x + a x^2` with positive c; infinite when
/// there is none.
fn first_root(c: f64, b: f64, a: f64) -> f64 {
    let square = b * b - 4.0 * a * c;
    // Two equal roots may miss by rounding.
    if square < -1e-12 * b * b {
        return f64::INFINITY;
    }
    let root = square.max(0.0).sqrt();
    let q = -0.5 * (b + if b >= 0.0 { root } else { -root });
    [q / a, c / q]
        .into_iter()
        .filter(|x| x.is_finite() && *x > 0.0)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_every_kind() {
        for (c, b, a, expected) in [
            (2.0, -3.0, 1.0, 1.0),
            (2.0, 3.0, 1.0, f64::INFINITY),
            (1.0, 0.0, 1.0, f64::INFINITY),
            (1.0, -2.0, 1.0, 1.0),
            (1.0, -0.5, 0.0, 2.0),
            (1.0, 0.5, 0.0, f64::INFINITY),
            (1.0, 0.0, 0.0, f64::INFINITY),
            (3.0, 2.0, -1.0, 3.0),
        ] {
            assert_eq!(first_root(c, b, a), expected, "{c} {b} {a}");
        }
    }
}
