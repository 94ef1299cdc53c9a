//! Mass, centre of gravity and inertia of the model, and of the part, both of
//! density 1.

use glam::{DMat3, DVec3};
use serde::Serialize;

use super::ShellModel;
use crate::mesh::TriMesh;

/// Mass properties at density 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MassProperties {
    /// Volume, cubic part units.
    pub volume: f64,
    /// Centre of gravity.
    pub centre: DVec3,
    /// Moments of inertia about the centre: xx, yy, zz, xy, yz, zx, the last
    /// three being the integrals of the products with their sign turned.
    pub inertia: [f64; 6],
}

/// Sums of 1, x and x x^T over a body, about an origin of the caller's.
struct Moments {
    zeroth: f64,
    first: DVec3,
    second: DMat3,
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl Moments {
    /// Of nothing. (The default of a matrix is the identity.)
    const ZERO: Moments = Moments {
        zeroth: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
    };

    fn about(self, origin: DVec3) -> MassProperties {
        if self.zeroth == 0.0 {
            return MassProperties::default();
        }
        let centre = self.first / self.zeroth;
        let s = self.second - outer(centre, centre) * self.zeroth;
        let trace = s.x_axis.x + s.y_axis.y + s.z_axis.z;
        MassProperties {
            volume: self.zeroth,
            centre: origin + centre,
            inertia: [
                trace - s.x_axis.x,
                trace - s.y_axis.y,
                trace - s.z_axis.z,
                -s.x_axis.y,
                -s.y_axis.z,
                -s.z_axis.x,
            ],
        }
    }
}

impl MassProperties {
    /// Of the space that a closed mesh encloses.
    pub fn of_solid(mesh: &TriMesh) -> MassProperties {
        let origin = mesh.bounds().center();
        let mut sum = Moments::ZERO;
        for face in mesh.faces() {
            let [a, b, c] = mesh.corners(face).map(|p| p - origin);
            let volume = a.dot(b.cross(c)) / 6.0;
            let total = a + b + c;
            sum.zeroth += volume;
            sum.first += volume / 4.0 * total;
            // Tetrahedron with one corner at the origin.
            let squares = outer(a, a) + outer(b, b) + outer(c, c) + outer(total, total);
            sum.second += squares * (volume / 20.0);
        }
        sum.about(origin)
    }

    /// Of a shell model: each element as thick as its nodes say, on both
    /// sides of its mid-plane.
    pub fn of_shell(model: &ShellModel) -> MassProperties {
        let origin = model.nodes.first().map_or(DVec3::ZERO, |n| n.position);
        let mut sum = Moments::ZERO;
        for element in &model.elements {
            let at = |k: usize| &model.nodes[element.nodes[k] as usize];
            for k in 1..element.sides() - 1 {
                let corners = [at(0), at(k), at(k + 1)];
                let t = corners.map(|n| n.thickness);
                let [a, b, c] = corners.map(|n| n.position - origin);
                let up = (b - a).cross(c - a);
                let area = 0.5 * up.length();
                // Sides' middles integrate products of linear functions with
                // thickness well enough: exactly where it is constant.
                for (p, t) in [
                    (a + b, t[0] + t[1]),
                    (b + c, t[1] + t[2]),
                    (c + a, t[2] + t[0]),
                ] {
                    let (p, t) = (0.5 * p, 0.5 * t);
                    let volume = area * t / 3.0;
                    let n = up.normalize_or_zero();
                    sum.zeroth += volume;
                    sum.first += volume * p;
                    sum.second += (outer(p, p) + outer(n, n) * (t * t / 12.0)) * volume;
                }
            }
        }
        sum.about(origin)
    }
}
