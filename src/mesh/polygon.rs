//! Polygons to triangles: a fan when convex, ear clipping otherwise.

use glam::{DVec2, DVec3};

/// Ear clipping takes quadratic time; beyond this many corners a file is
/// asked for triangles instead.
pub(crate) const MOST_CORNERS: usize = 20_000;

/// Full searches for ears before a polygon is given up; spirals need a few.
const MOST_SEARCHES: usize = 64;

/// Corners held against ears in all full searches of a file, some seconds of
/// work: those of tangled polygons find nothing.
const MOST_TESTS: u64 = 400_000_000;

/// Appends `corners.len() - 2` triangles with the polygon's orientation, or
/// fewer where corners follow themselves; at least one.
///
/// Returns false when the polygon is no simple one in its plane, so that
/// triangles had to be forced.
pub(crate) fn triangulate(
    corners: &[u32],
    positions: &[DVec3],
    out: &mut Vec<[u32; 3]>,
    tests: &mut u64,
) -> bool {
    let mut ring: Vec<u32> = corners.to_vec();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    if ring.len() < 3 {
        // A facet without area; it keeps its place in the count.
        out.push([corners[0], corners[1], corners[2]]);
        return true;
    }
    let flat = project(&ring, positions);
    if is_strictly_convex(&flat) {
        for k in 1..ring.len() - 1 {
            out.push([ring[0], ring[k], ring[k + 1]]);
        }
        return true;
    }
    clip_ears(&ring, &flat, out, tests)
}

/// The polygon seen against its Newell normal, so that it runs
/// counter-clockwise; all zero if it has no normal.
fn project(ring: &[u32], positions: &[DVec3]) -> Vec<DVec2> {
    let points: Vec<DVec3> = ring.iter().map(|&v| positions[v as usize]).collect();
    let origin = points[0];
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points
        .iter()
        .zip(next)
        .map(|(&a, &b)| (a - origin).cross(b - origin))
        .sum();
    let Some(normal) = normal.try_normalize() else {
        return vec![DVec2::ZERO; points.len()];
    };
    let (x, y) = normal.any_orthonormal_pair();
    points
        .iter()
        .map(|&p| DVec2::new((p - origin).dot(x), (p - origin).dot(y)))
        .collect()
}

/// Twice the signed area of a triangle in the plane.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether every corner turns left and the polygon winds once.
fn is_strictly_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    let mut angle = 0.0;
    for k in 0..count {
        let (a, b, c) = (flat[k], flat[(k + 1) % count], flat[(k + 2) % count]);
        let sides = (b - a).length() * (c - b).length();
        let turns_left = turn(a, b, c) > 1e-12 * sides;
        if !turns_left {
            return false;
        }
        angle += (b - a).angle_to(c - b);
    }
    angle < 3.0 * std::f64::consts::PI
}

/// Ear clipping, the best-shaped ear first.
struct Clipper<'a> {
    flat: &'a [DVec2],
    /// Corners not clipped yet, as indices into `flat`.
    left: Vec<usize>,
    /// Shape of the ear at each corner of `left`, larger is better; `None`
    /// where there is no ear.
    ears: Vec<Option<f64>>,
}

impl Clipper<'_> {
    fn around(&self, k: usize) -> [usize; 3] {
        let count = self.left.len();
        [
            self.left[(k + count - 1) % count],
            self.left[k],
            self.left[(k + 1) % count],
        ]
    }

    /// Twice the area over the longest side squared, if the corner is an ear:
    /// it turns left and holds no other corner. Corners at the place of one of
    /// its own do not count, as they occur where a slit leads to a hole.
    fn ear(&self, k: usize) -> Option<f64> {
        let [a, b, c] = self.around(k).map(|corner| self.flat[corner]);
        let area = turn(a, b, c);
        let longest = (b - a)
            .length_squared()
            .max((c - b).length_squared())
            .max((a - c).length_squared());
        let turns_left = area > 1e-12 * longest;
        if !turns_left {
            return None;
        }
        let holds = |p: DVec2| {
            p != a
                && p != b
                && p != c
                && turn(a, b, p) >= 0.0
                && turn(b, c, p) >= 0.0
                && turn(c, a, p) >= 0.0
        };
        let clear = !self.left.iter().any(|&corner| holds(self.flat[corner]));
        clear.then_some(area / longest)
    }

    fn best(&self) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for (k, ear) in self.ears.iter().enumerate() {
            if let Some(shape) = *ear
                && best.is_none_or(|(_, other)| shape > other)
            {
                best = Some((k, shape));
            }
        }
        best.map(|(k, _)| k)
    }
}

fn clip_ears(ring: &[u32], flat: &[DVec2], out: &mut Vec<[u32; 3]>, tests: &mut u64) -> bool {
    let mut clipper = Clipper {
        flat,
        left: (0..ring.len()).collect(),
        ears: Vec::new(),
    };
    // Once a file's tangled polygons have spent all tests, no more are begun.
    let worth = |corners: usize, spent: u64| corners < 100 || spent < MOST_TESTS;
    if worth(ring.len(), *tests) {
        clipper.ears = (0..ring.len()).map(|k| clipper.ear(k)).collect();
    }
    let mut searches = 0;
    while clipper.left.len() > 3 {
        let mut best = clipper.best();
        if best.is_none() && searches < MOST_SEARCHES && worth(clipper.left.len(), *tests) {
            // Clipping may have freed corners that held others before.
            searches += 1;
            *tests += (clipper.left.len() as u64).pow(2);
            clipper.ears = (0..clipper.left.len()).map(|k| clipper.ear(k)).collect();
            best = clipper.best();
        }
        let Some(k) = best else {
            // No simple polygon: a fan over what is left keeps its boundary.
            let rest: Vec<u32> = clipper.left.iter().map(|&corner| ring[corner]).collect();
            out.extend((1..rest.len() - 1).map(|k| [rest[0], rest[k], rest[k + 1]]));
            return false;
        };
        out.push(clipper.around(k).map(|corner| ring[corner]));
        clipper.left.remove(k);
        clipper.ears.remove(k);
        let count = clipper.left.len();
        for neighbour in [(k + count - 1) % count, k % count] {
            clipper.ears[neighbour] = clipper.ear(neighbour);
        }
    }
    let last = [clipper.left[0], clipper.left[1], clipper.left[2]];
    out.push(last.map(|corner| ring[corner]));
    // What is left may be flat, when corners lie in the middle of a side.
    let [a, b, c] = last.map(|corner| flat[corner]);
    turn(a, b, c) >= -1e-12 * (b - a).length() * (c - b).length()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn check(outline: &[(f64, f64)], expected_simple: bool) -> Vec<[u32; 3]> {
        let positions: Vec<DVec3> = outline
            .iter()
            .map(|&(x, y)| DVec3::new(x, y, 0.25 * x))
            .collect();
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let mut triangles = Vec::new();
        let simple = triangulate(&corners, &positions, &mut triangles, &mut 0);
        assert_eq!(simple, expected_simple);
        assert_eq!(triangles.len(), corners.len() - 2);
        triangles
    }

    fn area(triangles: &[[u32; 3]], outline: &[(f64, f64)]) -> f64 {
        let at = |v: u32| DVec2::from(outline[v as usize]);
        triangles
            .iter()
            .map(|&[a, b, c]| {
                let area = 0.5 * turn(at(a), at(b), at(c));
                assert!(area > 0.0, "turned or flat triangle {a} {b} {c}");
                area
            })
            .sum()
    }

    #[test]
    fn convex_polygons_become_fans() {
        let square = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)];
        assert_eq!(check(&square, true), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let ell = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 1.0),
            (1.0, 1.0),
            (1.0, 4.0),
            (0.0, 4.0),
        ];
        // Every start corner, so that none is lucky.
        for shift in 0..ell.len() {
            let mut outline = ell.to_vec();
            outline.rotate_left(shift);
            assert_eq!(area(&check(&outline, true), &outline), 7.0);
        }
    }

    #[test]
    fn corners_in_the_middle_of_a_side_are_kept() {
        let outline = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)];
        for shift in 0..outline.len() {
            let mut outline = outline.to_vec();
            outline.rotate_left(shift);
            assert_eq!(area(&check(&outline, true), &outline), 4.0);
        }
    }

    #[test]
    fn a_slit_to_a_hole_is_no_obstacle() {
        // Square with a square hole, joined by a slit run both ways.
        let outline = [
            (0.0, 0.0),
            (4.0, 0.0),
            (4.0, 4.0),
            (0.0, 4.0),
            (0.0, 0.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (3.0, 3.0),
            (3.0, 1.0),
            (1.0, 1.0),
        ];
        assert_eq!(area(&check(&outline, true), &outline), 12.0);
    }

    #[test]
    fn a_bow_tie_is_forced_and_said() {
        check(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)], false);
    }

    #[test]
    fn repeated_corners_do_not_make_triangles() {
        let positions = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut out = Vec::new();
        assert!(triangulate(&[0, 1, 2, 2], &positions, &mut out, &mut 0));
        assert!(triangulate(&[0, 1, 1, 0], &positions, &mut out, &mut 0));
        assert_eq!(out, [[0, 1, 2], [0, 1, 1]]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Polygons that a point in their middle sees whole.
        #[test]
        fn star_shaped_polygons_are_covered_once(
            radii in proptest::collection::vec(0.1..10.0f64, 3..40),
            tilt in -3.0..3.0f64,
        ) {
            let count = radii.len() as f64;
            let outline: Vec<(f64, f64)> = radii
                .iter()
                .enumerate()
                .map(|(k, r)| {
                    let angle = std::f64::consts::TAU * k as f64 / count;
                    (r * angle.cos(), r * angle.sin())
                })
                .collect();
            let positions: Vec<DVec3> = outline
                .iter()
                .map(|&(x, y)| DVec3::new(x, y, tilt * x - y))
                .collect();
            let corners: Vec<u32> = (0..radii.len() as u32).collect();
            let mut triangles = Vec::new();
            prop_assert!(triangulate(&corners, &positions, &mut triangles, &mut 0));
            let next = outline.iter().cycle().skip(1);
            let expected: f64 = outline
                .iter()
                .zip(next)
                .map(|(&a, &b)| 0.5 * DVec2::from(a).perp_dot(DVec2::from(b)))
                .sum();
            let found = area(&triangles, &outline);
            prop_assert!((found / expected - 1.0).abs() < 1e-9);
        }

        #[test]
        fn no_polygon_panics(
            corners in proptest::collection::vec(0..12u32, 4..30),
            values in proptest::collection::vec(-2..3i32, 36),
        ) {
            let positions: Vec<DVec3> = values
                .chunks_exact(3)
                .map(|v| DVec3::new(v[0].into(), v[1].into(), v[2].into()))
                .collect();
            let mut triangles = Vec::new();
            triangulate(&corners, &positions, &mut triangles, &mut 0);
            prop_assert!(!triangles.is_empty());
        }
    }
}
