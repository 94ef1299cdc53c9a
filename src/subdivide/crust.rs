//! The bi-quintic Bezier crust: (3.2), (3.3), and (2.5).
//!
//! Its 36 control vectors are nine copies of each of four corner vectors, so
//! that the sum shrinks to a blend of the four with the weight
//! `w = b_3 + b_4 + b_5 = 10 t^3 - 15 t^4 + 6 t^5` of quintic Bernstein
//! polynomials. `w'` and `w''` vanish at 0 and 1: the crust adds nothing to the
//! derivatives across a border of faces.

use glam::DVec3;

use super::limit::LimitSurface;
use super::patch::Jet;

/// How the inner surface follows from the outer one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// The Bezier crust (3.3).
    #[default]
    Crust,
    /// Along the normal of every point, (2.4).
    Direct,
}

impl Scheme {
    /// For reports.
    pub fn name(self) -> &'static str {
        match self {
            Scheme::Crust => "crust",
            Scheme::Direct => "direct",
        }
    }
}

/// Weight of the far corner, and its first and second derivative.
#[inline]
pub(super) fn weight(t: f64) -> [f64; 3] {
    let s = 1.0 - t;
    [
        t * t * t * (10.0 + t * (-15.0 + 6.0 * t)),
        30.0 * t * t * s * s,
        60.0 * t * s * (1.0 - 2.0 * t),
    ]
}

/// One vector for every control vertex, spread over the faces.
#[derive(Clone, Debug)]
pub struct Crust {
    vectors: Vec<DVec3>,
    thickness: f64,
}

impl Crust {
    /// Vectors `thickness` long along the normals: (3.1), which the paper's
    /// text leaves out. They are subtracted from the surface. On creases, which
    /// the paper does not have, they are longer, see [`LimitSurface::mitres`];
    /// vertices with a thickness of their own have that.
    pub fn offset(surface: &LimitSurface, thickness: f64) -> Crust {
        let cage = surface.mesh().cage();
        let mitres = surface.mitres().iter().zip(0..);
        let vectors = mitres.map(|(&m, v)| thickness * cage.share(v) * m);
        let vectors = vectors.collect();
        Crust { vectors, thickness }
    }

    /// From the control vertices to their limit points. Subtracted from the
    /// surface they make it pass through the control vertices; (2.5) adds the
    /// opposite vectors.
    pub fn interpolating(surface: &LimitSurface) -> Crust {
        let controls = surface.mesh().cage().positions();
        let vectors = surface.limits().iter().zip(controls);
        Crust {
            vectors: vectors.map(|(&limit, &control)| limit - control).collect(),
            thickness: 0.0,
        }
    }

    /// Length of the vectors along normals; zero for other vectors.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// The vector of each control vertex.
    pub fn vectors(&self) -> &[DVec3] {
        &self.vectors
    }

    /// Vectors at the corners of a face.
    pub(super) fn corners(&self, surface: &LimitSurface, face: usize) -> [DVec3; 4] {
        let corners = surface.mesh().corners(face);
        corners.map(|vertex| self.vectors[vertex as usize])
    }

    /// The crust itself over a face, with its derivatives.
    pub fn at(&self, surface: &LimitSurface, face: usize, u: f64, v: f64) -> Jet {
        blend(self.corners(surface, face), u, v)
    }
}

/// The crust of four corner vectors.
pub(super) fn blend([a, b, c, d]: [DVec3; 4], u: f64, v: f64) -> Jet {
    let [wu, du, ddu] = weight(u);
    let [wv, dv, ddv] = weight(v);
    let (near, far) = (b - a, c - d);
    let (low, high) = (a + wu * near, d + wu * far);
    let along = near + wv * (far - near);
    Jet {
        point: low + wv * (high - low),
        du: du * along,
        dv: dv * (high - low),
        duu: ddu * along,
        duv: du * dv * (far - near),
        dvv: ddv * (high - low),
    }
}
