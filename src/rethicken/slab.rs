//! Distance to the slab of a triangle: the hull of three balls.

use glam::DVec3;

/// A triangle swept by balls whose radius is linear over it.
///
/// With a ball of radius `r(q)` at every point `q` of the triangle, the slab's
/// function at `p` is the least `|p - q| - r(q)`: the distance to the hull of
/// the three balls outside of it, negative inside. It is convex in `q`, so the
/// least value is in the middle of the triangle or, if that has no stationary
/// point, on one of the three edges; and there the same, between the ends or
/// at one of them. Balls that swallow others and triangles without area need
/// no case of their own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    corners: [DVec3; 3],
    radii: [f64; 3],
    /// Middle of the triangle, if a stationary point can be there.
    face: Option<Face>,
}

/// What the stationary point in the middle of a slab is found with.
#[derive(Clone, Copy, Debug)]
struct Face {
    normal: DVec3,
    /// Gradient of the radius, in the triangle's plane; shorter than 1.
    gradient: DVec3,
    /// Rows that give the barycentric coordinates of corners 1 and 2.
    barycentric: [DVec3; 2],
}

/// The ball of a slab that is nearest to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearBall {
    /// Distance to the ball, negative inside.
    pub value: f64,
    /// Its centre, on the triangle.
    pub centre: DVec3,
}

impl Slab {
    /// Corners in part units with the radii of their balls, none negative.
    pub fn new(corners: [DVec3; 3], radii: [f64; 3]) -> Slab {
        Slab {
            corners,
            radii,
            face: Face::new(corners, radii),
        }
    }

    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    pub fn greatest_radius(&self) -> f64 {
        self.radii.into_iter().fold(0.0, f64::max)
    }

    pub fn nearest(&self, p: DVec3) -> NearBall {
        if let Some(ball) = self.face.and_then(|face| self.in_face(&face, p)) {
            return ball;
        }
        let [a, b, c] = [[0, 1], [1, 2], [2, 0]].map(|edge| self.on_edge(edge, p));
        [b, c].into_iter().fold(
            a,
            |best, ball| if ball.value < best.value { ball } else { best },
        )
    }

    /// Unit direction away from the triangle, for a nearest ball.
    pub fn direction(&self, p: DVec3, ball: &NearBall) -> DVec3 {
        let fallback = || self.face.map_or(DVec3::Z, |face| face.normal);
        (p - ball.centre).try_normalize().unwrap_or_else(fallback)
    }

    /// The stationary point in the middle, where the ray to `p` leans against
    /// the gradient of the radius so that both balance.
    fn in_face(&self, face: &Face, p: DVec3) -> Option<NearBall> {
        let from = p - self.corners[0];
        let height = from.dot(face.normal);
        let lean = height.abs() / (1.0 - face.gradient.length_squared()).sqrt();
        let at = from - height * face.normal + lean * face.gradient;
        let [u, v] = face.barycentric.map(|row| row.dot(at));
        if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
            return None;
        }
        Some(NearBall {
            value: lean - (self.radii[0] + face.gradient.dot(at)),
            centre: self.corners[0] + at,
        })
    }

    fn on_edge(&self, [i, j]: [usize; 2], p: DVec3) -> NearBall {
        let (a, b) = (self.corners[i], self.corners[j]);
        let (from, to) = (self.radii[i], self.radii[j]);
        let length = (b - a).length();
        let t = if length > 0.0 {
            let axis = (b - a) / length;
            let slope = (to - from) / length;
            let along = (p - a).dot(axis);
            let off = (p - a - along * axis).length();
            let stationary = if slope.abs() < 1.0 {
                along + slope * off / (1.0 - slope * slope).sqrt()
            } else {
                slope * f64::INFINITY
            };
            (stationary / length).clamp(0.0, 1.0)
        } else {
            // One place: the greater ball counts.
            f64::from(u8::from(to > from))
        };
        let centre = a.lerp(b, t);
        NearBall {
            value: p.distance(centre) - (from + t * (to - from)),
            centre,
        }
    }
}

impl Face {
    fn new([a, b, c]: [DVec3; 3], [ra, rb, rc]: [f64; 3]) -> Option<Face> {
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let area = normal.length();
        let longest = u.length().max(v.length()).max(b.distance(c));
        // Thinner triangles are measured by their edges alone.
        if area.is_nan() || area <= 1e-9 * longest * longest {
            return None;
        }
        let normal = normal / area;
        let barycentric = [v.cross(normal) / area, normal.cross(u) / area];
        let gradient = (rb - ra) * barycentric[0] + (rc - ra) * barycentric[1];
        (gradient.length_squared() < 1.0).then_some(Face {
            normal,
            gradient,
            barycentric,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The least value over a grid of the triangle.
    fn sampled(corners: [DVec3; 3], radii: [f64; 3], p: DVec3) -> f64 {
        const N: usize = 60;
        let [a, b, c] = corners;
        let mut least = f64::INFINITY;
        for i in 0..=N {
            for j in 0..=N - i {
                let (u, v) = (i as f64 / N as f64, j as f64 / N as f64);
                let q = a + u * (b - a) + v * (c - a);
                let r = radii[0] + u * (radii[1] - radii[0]) + v * (radii[2] - radii[0]);
                least = least.min(p.distance(q) - r);
            }
        }
        least
    }

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-2.0..2.0).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn no_ball_of_the_slab_is_nearer(
            corners in prop::array::uniform3(point()),
            // Up to 3: one ball often swallows others.
            radii in prop::array::uniform3(0.0..3.0),
            p in point(),
        ) {
            let ball = Slab::new(corners, radii).nearest(p);
            let least = sampled(corners, radii, p);
            prop_assert!(ball.value <= least + 1e-9, "{} {least}", ball.value);
            prop_assert!(ball.value >= least - 0.2, "{} {least}", ball.value);
        }

        #[test]
        fn values_change_by_at_most_the_way(
            corners in prop::array::uniform3(point()),
            radii in prop::array::uniform3(0.0..1.0),
            p in point(),
            q in point(),
        ) {
            let slab = Slab::new(corners, radii);
            let change = (slab.nearest(p).value - slab.nearest(q).value).abs();
            prop_assert!(change <= p.distance(q) + 1e-9);
        }
    }

    #[test]
    fn the_tangent_plane_of_a_taper() {
        // Radius grows by 0.6 a unit: the tangent plane leans by asin(0.6).
        let corners = [
            DVec3::ZERO,
            DVec3::new(4.0, 0.0, 0.0),
            DVec3::new(0.0, 4.0, 0.0),
        ];
        let slab = Slab::new(corners, [1.0, 3.4, 1.0]);
        let p = DVec3::new(1.0, 1.0, 2.0);
        assert!((slab.nearest(p).value - (0.8 * 2.0 - 1.6)).abs() < 1e-12);
    }

    #[test]
    fn degenerate_triangles_are_edges_and_points() {
        let (a, b) = (DVec3::ZERO, DVec3::X);
        let p = DVec3::new(0.5, 2.0, 0.0);
        assert!((Slab::new([a, b, b], [0.5; 3]).nearest(p).value - 1.5).abs() < 1e-12);
        assert!((Slab::new([a; 3], [0.1, 0.5, 0.2]).nearest(DVec3::Y).value - 0.5).abs() < 1e-12);
    }
}
