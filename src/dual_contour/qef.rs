//! The point nearest to a set of planes: the minimiser of the quadratic error
//! function (Ju, Losasso, Schaefer, Warren, "Dual contouring of Hermite data",
//! 2002), as near to the mass point as the planes allow.

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

use super::edges::Hermite;

/// Singular values below this fraction of the greatest count as zero: two
/// planes that meet at less than 11 degrees do not fix a line.
const TRUNCATION: f64 = 0.1;

/// Mean of the crossings.
pub(super) fn mass_point(crossings: &[Hermite]) -> DVec3 {
    let sum: DVec3 = crossings.iter().map(|h| h.point).sum();
    sum / crossings.len() as f64
}

/// Minimiser of the summed squares of the distances to the tangent planes.
pub(super) fn minimise(crossings: &[Hermite], mass: DVec3) -> DVec3 {
    // The normal equations A^T A x = A^T b; their singular values are the
    // squares of those of A.
    let mut matrix = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for h in crossings {
        let n = Vector3::from(h.normal.to_array());
        matrix += n * n.transpose();
        right += n * h.normal.dot(h.point - mass);
    }
    let svd = matrix.svd(true, true);
    let least = svd.singular_values.max() * TRUNCATION * TRUNCATION;
    // Both factors were asked for, so there is always a solution.
    match svd.solve(&right, least) {
        Ok(step) => mass + DVec3::new(step.x, step.y, step.z),
        Err(_) => mass,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(normal: DVec3, point: DVec3) -> Hermite {
        Hermite {
            point,
            normal: normal.normalize(),
            element: 0,
        }
    }

    #[test]
    fn planes_meet_in_the_minimiser() {
        let corner = DVec3::new(0.3, 0.4, 0.5);
        let planes = [
            plane(DVec3::X, corner + DVec3::new(0.0, 0.7, 0.2)),
            plane(DVec3::Y, corner + DVec3::new(0.7, 0.0, -0.2)),
            plane(DVec3::Z, corner + DVec3::new(0.1, 0.2, 0.0)),
        ];
        let found = minimise(&planes, mass_point(&planes));
        assert!((found - corner).length() < 1e-12);

        let found = minimise(&planes[..2], mass_point(&planes[..2]));
        assert!((found.truncate() - corner.truncate()).length() < 1e-12);

        let flat = [plane(DVec3::Z, corner), plane(DVec3::Z, corner + DVec3::X)];
        assert!((minimise(&flat, mass_point(&flat)) - corner - DVec3::X * 0.5).length() < 1e-12);
    }
}
