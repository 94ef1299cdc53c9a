//! A mesh of triangles and quadrilaterals, held as triangles, and how good its
//! faces are.

use glam::DVec3;
use smallvec::SmallVec;

use super::Remesher;
use super::edits::GOOD;
use crate::reshape::shape::Shape;

/// Three or four corners in order.
pub(super) type Face = SmallVec<[u32; 4]>;

/// Faces, and which of them each triangle of the complex belongs to.
pub(super) struct Faces {
    pub(super) all: Vec<Face>,
    /// Face of each triangle.
    pub(super) of: Vec<u32>,
}

/// What a pair of triangles must be as a quadrilateral.
#[derive(Clone, Copy)]
pub(super) struct Pairing {
    /// Scaled Jacobian that it must have.
    pub(super) least: f64,
    /// Most that it may bend over either diagonal, degrees.
    pub(super) warp: f64,
}

/// What solvers ask for is a scaled Jacobian of a half and a bend of ten degrees.
pub(super) const SOLVABLE: Pairing = Pairing {
    least: 0.5,
    warp: 10.0,
};

/// A pair that may become such a one when its corners move.
pub(super) const HOPEFUL: Pairing = Pairing {
    least: 0.4,
    warp: 14.0,
};

/// The least scaled Jacobian of a quadrilateral's corners, with the sense of
/// its mean normal: 1 for a rectangle, 0 or less where it folds.
pub(super) fn jacobian(p: [DVec3; 4]) -> f64 {
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

/// One for a square or an equilateral triangle, a half where the scaled Jacobian
/// or the bend is as bad as solvers take, or the least angle 25 degrees.
pub(super) fn quality(corners: &[DVec3]) -> f64 {
    match *corners {
        [a, b, c, d] => {
            let p = [a, b, c, d];
            jacobian(p).min(1.0 - 0.5 * warp(p) / SOLVABLE.warp)
        }
        [a, b, c] => (0.5 * Shape::of([a, b, c]).sine / GOOD).min(1.0),
        _ => 0.0,
    }
}

impl Remesher<'_> {
    /// Whether four vertices make a quadrilateral that is wanted.
    pub(super) fn makes(&self, quad: [u32; 4], wanted: Pairing) -> bool {
        let p = quad.map(|v| self.complex.at(v));
        jacobian(p) >= wanted.least && warp(p) <= wanted.warp
    }

    /// Faces, the halves of those quadrilaterals that are not as wanted in their
    /// place.
    pub(super) fn broken_up(&self, faces: Vec<Face>, wanted: Pairing) -> Vec<Face> {
        let mut all = Vec::with_capacity(faces.len());
        for face in faces {
            match *face {
                [a, b, c, d] if !self.makes([a, b, c, d], wanted) => {
                    all.extend(self.halves([a, b, c, d]).map(|t| Face::from_slice(&t)));
                }
                _ => all.push(face),
            }
        }
        all
    }

    /// Replaces all triangles by faces, quadrilaterals cut along the diagonal that
    /// makes the better halves.
    pub(super) fn cut(&mut self, all: Vec<Face>) -> Faces {
        let mut triangles = Vec::with_capacity(2 * all.len());
        let mut of = Vec::with_capacity(2 * all.len());
        for (n, face) in (0..).zip(&all) {
            match **face {
                [a, b, c, d] => triangles.extend(self.halves([a, b, c, d])),
                [a, b, c] => triangles.push([a, b, c]),
                _ => {}
            }
            of.resize(triangles.len(), n);
        }
        self.complex.replace(triangles);
        Faces { all, of }
    }

    /// The two triangles of a quadrilateral, the better of two pairs; over the
    /// diagonal outside a dart one would lie on the other.
    pub(super) fn halves(&self, [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
        let worst = |pair: [[u32; 3]; 2]| {
            let [p, q] = pair.map(|c| self.complex.shape(c));
            let folded = p.normal.dot(q.normal) <= 0.0;
            if folded { -1.0 } else { p.sine.min(q.sine) }
        };
        let [one, two] = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
        if worst(one) >= worst(two) { one } else { two }
    }

    /// The worst quality of the faces at a vertex if it lay at `to`.
    pub(super) fn worst_face(&self, v: u32, to: DVec3, faces: &Faces) -> f64 {
        let at = |w: u32| if w == v { to } else { self.complex.at(w) };
        let qualities = faces.around(self.complex.around(v)).map(|face| {
            let corners: SmallVec<[DVec3; 4]> = face.iter().map(|&w| at(w)).collect();
            quality(&corners)
        });
        qualities.fold(1.0, f64::min)
    }
}

impl Faces {
    /// Faces of triangles; one of two of them comes twice.
    pub(super) fn around(&self, triangles: &[u32]) -> impl Iterator<Item = &Face> {
        triangles
            .iter()
            .map(|&t| &self.all[self.of[t as usize] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::{jacobian, quality, warp};
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

    #[test]
    fn the_best_faces_are_one_and_those_at_the_limit_a_half() {
        let h = 0.75f64.sqrt();
        let equilateral = [[0., 0.], [1., 0.], [0.5, h]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(quality(&equilateral), 1.0);
        let [y, z] = [25.0f64.to_radians().tan(), 0.0];
        let steep = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, y, z)];
        assert!((quality(&steep) - 0.5).abs() < 0.01, "{}", quality(&steep));
    }
}
