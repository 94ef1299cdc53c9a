//! Measures of single triangles and segments.

use glam::DVec3;

/// Shape of a triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// Unit normal; zero if there is none.
    pub(super) normal: DVec3,
    /// Sine of the smallest angle: between 0 and 0.87.
    pub(super) sine: f64,
    /// Least height over longest edge.
    pub(super) flatness: f64,
}

impl Shape {
    pub(super) fn of([a, b, c]: [DVec3; 3]) -> Shape {
        let (u, v, w) = (b - a, c - a, c - b);
        let cross = u.cross(v);
        let double_area = cross.length();
        let mut edges = [u.length_squared(), v.length_squared(), w.length_squared()];
        edges.sort_unstable_by(f64::total_cmp);
        let [_, middle, longest] = edges;
        if double_area.is_nan() || double_area <= 0.0 {
            return Shape {
                normal: DVec3::ZERO,
                sine: 0.0,
                flatness: 0.0,
            };
        }
        // The smallest angle lies between the two longer edges.
        Shape {
            normal: cross / double_area,
            sine: double_area / (middle * longest).sqrt(),
            flatness: double_area / longest,
        }
    }
}

/// Distance of a point from a segment.
pub(super) fn to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let square = along.length_squared();
    if square <= 0.0 {
        return (p - a).length();
    }
    let s = ((p - a).dot(along) / square).clamp(0.0, 1.0);
    (p - (a + s * along)).length()
}

/// Distance of a point from a triangle.
pub(super) fn to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let within = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    let length = normal.length();
    if length > 0.0 && within(a, b) && within(b, c) && within(c, a) {
        return ((p - a).dot(normal) / length).abs();
    }
    to_segment(p, a, b)
        .min(to_segment(p, b, c))
        .min(to_segment(p, c, a))
}

/// Distance between two lines that cross or nearly so, each given by two
/// points; `None` unless both pass each other within their segments.
pub(super) fn crossing_gap([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> Option<f64> {
    let (u, v, r) = (b - a, d - c, c - a);
    let cross = u.cross(v);
    let square = cross.length_squared();
    if square <= 1e-12 * u.length_squared() * v.length_squared() {
        return None;
    }
    let s = r.cross(v).dot(cross) / square;
    let t = r.cross(u).dot(cross) / square;
    let inside = |x: f64| x > 1e-6 && x < 1.0 - 1e-6;
    (inside(s) && inside(t)).then(|| (r.dot(cross) / square.sqrt()).abs())
}
