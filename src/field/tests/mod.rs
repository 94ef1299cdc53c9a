//! Every query against a brute-force oracle, on small exact shapes and on a
//! bumpy sphere; then under translation and scaling.

mod hits;
pub(super) mod shapes;

use proptest::prelude::*;

use super::*;
use shapes::{Dice, bumpy, cuboid, grid, icosphere, tee};

fn faces(field: &Field, coping: bool) -> impl Iterator<Item = FaceId> {
    (0..field.face_count() as u32)
        .map(FaceId)
        .filter(move |&f| field.is_coping(f) == coping && field.normal(f) != DVec3::ZERO)
}

/// Whether a wall point lies beyond coping. Which coping is asked is not in question here.
fn is_hidden(field: &Field, p: DVec3, foot: &Footpoint) -> bool {
    let slot = field.slots[foot.face.index()] as usize;
    !field.is_coping(foot.face) && field.screened().hides(slot, p, foot.point)
}

fn nearest(field: &Field, p: DVec3, coping: bool) -> Option<Footpoint> {
    faces(field, coping)
        .map(|f| field.footpoint_on(p, f))
        .filter(|f| !is_hidden(field, p, f))
        .min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.face.cmp(&b.face)))
}

/// Exact solid angles of all faces.
pub(super) fn winding(field: &Field, p: DVec3) -> f64 {
    let mut sum = 0.0;
    for f in 0..field.face_count() as u32 {
        let [a, b, c] = field.corners(FaceId(f)).map(|x| x - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let y = a.dot(b.cross(c));
        let x = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        sum += y.atan2(x);
    }
    sum / (2.0 * std::f64::consts::PI)
}

/// All nearest-point queries of one point against the oracle.
fn check_point(field: &Field, p: DVec3) {
    let expected = nearest(field, p, false).unwrap();
    assert_eq!(field.footpoint(p), expected, "cold at {p:?}");
    let faces_total = field.face_count() as u32;
    for hint in [
        0,
        1,
        faces_total / 2,
        faces_total - 1,
        faces_total,
        u32::MAX,
    ] {
        assert_eq!(
            field.footpoint_near(p, FaceId(hint)),
            expected,
            "warm at {p:?}"
        );
    }
    assert_eq!(field.footpoint_near(p, expected.face), expected);

    let cope = nearest(field, p, true);
    assert_eq!(field.nearest_coping(p, f64::INFINITY), cope);
    if let Some(cope) = cope {
        assert_eq!(field.nearest_coping(p, cope.distance), Some(cope));
        if cope.distance > 0.0 {
            assert_eq!(field.nearest_coping(p, cope.distance * (1.0 - 1e-12)), None);
        }
    }

    let mut found = Vec::new();
    for radius in [0.0, expected.distance, expected.distance * 1.5] {
        field.footpoints_within(p, radius, &mut found);
        let all: Vec<_> = faces(field, false)
            .map(|f| field.footpoint_on(p, f))
            .filter(|f| f.distance <= radius && !is_hidden(field, p, f))
            .collect();
        assert_eq!(found, all, "within {radius} of {p:?}");
    }
}

fn check_inside(field: &Field, p: DVec3) {
    let number = winding(field, p);
    let clearance = field.signed_clearance(p);
    let nearest = nearest(field, p, false)
        .into_iter()
        .chain(nearest(field, p, true));
    let distance = nearest.map(|f| f.distance).fold(f64::INFINITY, f64::min);
    assert_eq!(clearance.abs(), distance);
    // Closer than this the oracle itself is rounding noise.
    let size = (field.bounds().1 - field.bounds().0).length();
    if distance > 1e-12 * (size + p.length()) {
        assert_eq!(
            field.inside(p),
            number > 0.5,
            "{p:?}: winding {number}, clearance {clearance}"
        );
        assert_eq!(clearance > 0.0, number > 0.5);
    }
}

#[test]
fn exact_shapes_on_grids_with_ties() {
    let plate = cuboid(8.0, 8.0, 1.0);
    let mut untagged = tee();
    untagged.coping.clear();
    for shape in [cuboid(1.0, 1.0, 1.0), plate, tee(), untagged, icosphere(1)] {
        let field = shape.field();
        assert!(field.is_closed_manifold());
        for p in grid(field.bounds(), 8) {
            check_point(&field, p);
            check_inside(&field, p);
        }
    }
}

#[test]
fn tie_on_the_middle_plane_goes_to_the_lowest_face() {
    let field = tee().field();
    // Halfway between the flange's faces: bottom is faces 0 and 1.
    let foot = field.footpoint(DVec3::new(0.7, 0.5, 1.1));
    assert_eq!(foot.distance, 0.5);
    assert!(foot.face <= FaceId(1));
    assert_eq!(foot.point.y, 0.0);
}

#[test]
fn bumpy_surface_far_and_near() {
    let field = bumpy(3).field();
    assert!(field.is_closed_manifold());
    let mut dice = Dice(1);
    for _ in 0..400 {
        let p = dice.point(field.bounds());
        check_point(&field, p);
        check_inside(&field, p);
    }
    for f in (0..field.face_count() as u32).step_by(5).map(FaceId) {
        let [a, b, c] = field.corners(f);
        let n = field.normal(f);
        for height in [0.0, 1e-9, -1e-4, 0.03, -0.03] {
            let p = (a + b * 0.7 + c * 1.3) / 3.0 + n * height;
            check_point(&field, p);
            check_inside(&field, p);
        }
    }
}

#[test]
fn inside_beside_edges_and_corners() {
    for shape in [cuboid(1.0, 1.0, 1.0), tee(), bumpy(2)] {
        let field = shape.field();
        let mut dice = Dice(7);
        for t in &shape.triangles {
            let corners = t.map(|v| shape.points[v as usize]);
            for i in 0..3 {
                for offset in [1e-7, 1e-6, 1e-5, 1e-4, 1e-3] {
                    let way = dice
                        .point((DVec3::splat(-1.0), DVec3::splat(1.0)))
                        .normalize();
                    check_inside(&field, corners[i] + way * offset);
                    let on_edge = corners[i].lerp(corners[(i + 1) % 3], dice.unit());
                    check_inside(&field, on_edge + way * offset);
                }
            }
        }
    }
}

#[test]
fn translated_and_scaled() {
    let base = bumpy(2);
    for (shift, scale) in [
        (1e4, 1.0),
        (-1e4, 1e-3),
        (1e4, 1e3),
        (0.0, 1e-3),
        (0.0, 1e3),
        (0.0, 1e-40),
    ] {
        let moved = base.map(|p| p * scale + DVec3::new(shift, -shift, shift * 0.7));
        let field = moved.field();
        let mut dice = Dice(3);
        for _ in 0..100 {
            let p = dice.point(field.bounds());
            check_point(&field, p);
            check_inside(&field, p);
        }
    }
    // Far away, where f32 says little.
    let field = base.field();
    for p in [
        DVec3::splat(1e3),
        DVec3::new(-1e5, 3.0, 0.2),
        DVec3::Y * 1e9,
        DVec3::X * 1e40,
    ] {
        check_point(&field, p);
    }
}

#[test]
fn open_surface_gets_the_winding_number() {
    let mut shape = bumpy(3);
    shape.drop_last(180);
    let field = shape.field();
    assert!(!field.is_closed_manifold());
    let mut dice = Dice(5);
    let mut told = 0;
    for _ in 0..1000 {
        let p = dice.point(field.bounds());
        let number = winding(&field, p);
        if (number - 0.5).abs() > 0.01 {
            let (low, high) = field.bounds();
            let in_box = p.cmpge(low).all() && p.cmple(high).all();
            assert_eq!(field.inside(p), in_box && number > 0.5, "{p:?} {number}");
            told += 1;
        }
    }
    assert!(told > 900);
}

#[test]
fn winding_agrees_with_pseudonormals_on_a_closed_part() {
    // A sliver beside the part spoils the manifold, not the winding number.
    let mut shape = bumpy(3);
    let n = shape.points.len() as u32;
    shape
        .points
        .extend([DVec3::ZERO, DVec3::X * 1e-3, DVec3::Y * 1e-3]);
    shape.push([n, n + 1, n + 2], true);
    let closed = bumpy(3).field();
    let dirty = shape.field();
    assert!(!dirty.is_closed_manifold());
    let mut dice = Dice(11);
    for _ in 0..2000 {
        let p = dice.point(closed.bounds());
        if closed.signed_clearance(p).abs() > 1e-6 && p.length() > 0.01 {
            assert_eq!(closed.inside(p), dirty.inside(p), "{p:?}");
        }
    }
}

#[test]
fn slivers_do_not_spoil_the_side() {
    // A vertex amid an edge of one triangle; slivers of about no height, to
    // either side, close the gaps.
    let mut shape = bumpy(3);
    for i in (0..shape.triangles.len()).step_by(9) {
        let [a, b, c] = shape.triangles[i];
        let m = shape.points.len() as u32;
        let middle = shape.points[a as usize].midpoint(shape.points[b as usize]);
        let inward = shape.points[c as usize] - middle;
        let height = [0.0, 1e-17, -1e-17, 1e-13][(i / 9) % 4];
        shape.points.push(middle + height * inward);
        shape.triangles[i] = [a, m, c];
        shape.push([m, b, c], false);
        shape.push([m, a, b], i % 2 == 0);
    }
    let field = shape.field();
    assert!(field.is_closed_manifold());
    let mut dice = Dice(17);
    for _ in 0..2000 {
        let p = dice.point(field.bounds());
        assert_eq!(field.inside(p), winding(&field, p) > 0.5, "{p:?}");
    }
    // And where a sliver is nearest.
    for i in (0..bumpy(3).triangles.len()).step_by(9) {
        let [a, m, c] = shape.triangles[i].map(|v| shape.points[v as usize]);
        let out = (m - a).cross(c - a).normalize();
        assert!(field.inside(m - 1e-3 * out), "{i}");
        assert!(!field.inside(m + 1e-3 * out), "{i}");
    }
}

#[test]
fn two_cones_tip_to_tip_are_no_manifold() {
    let mut shape = cuboid(1.0, 1.0, 1.0);
    let other = cuboid(-1.0, -1.0, 1.0).map(|p| p - DVec3::Z);
    let n = shape.points.len() as u32;
    shape.points.extend(other.points);
    for [a, b, c] in other.triangles {
        shape.push([a + n, b + n, c + n], false);
    }
    assert!(shape.field().is_closed_manifold(), "apart by number");
    let merged = Field::from_triangles(shape.corners(), Vec::new(), Vec::new());
    assert!(!merged.is_closed_manifold(), "joined by position");
    for p in grid(merged.bounds(), 8) {
        let distance = nearest(&merged, p, false).unwrap().distance;
        if distance > 1e-9 {
            assert_eq!(merged.inside(p), winding(&merged, p) > 0.5);
        }
    }
}

#[test]
fn degenerate_triangles_are_counted_and_left_out() {
    let clean = cuboid(2.0, 1.0, 1.0);
    let mut dirty = clean.clone();
    // A copy of corner 0 with two needles that close the gap between them.
    let copy = dirty.points.len() as u32;
    dirty.points.push(dirty.points[0]);
    dirty.triangles[0] = dirty.triangles[0].map(|v| if v == 0 { copy } else { v });
    dirty.push([0, copy, 1], false);
    dirty.push([copy, 0, 5], false);
    dirty.push([3, 3, 3], true);
    let (clean, dirty) = (clean.field(), dirty.field());
    assert_eq!(dirty.degenerate_faces(), 3);
    assert!(dirty.is_closed_manifold());
    for p in grid(clean.bounds(), 6) {
        assert_eq!(clean.footpoint(p), dirty.footpoint(p));
        assert_eq!(clean.signed_clearance(p), dirty.signed_clearance(p));
    }
    let needle = FaceId(clean.face_count() as u32);
    assert_eq!(dirty.normal(needle), DVec3::ZERO);
    assert_eq!(
        dirty
            .footpoint_on(DVec3::new(1.0, -1.0, 0.0), needle)
            .distance,
        1.0
    );
    assert_eq!(
        dirty.footpoint_near(DVec3::ONE, needle),
        clean.footpoint(DVec3::ONE)
    );
}

/// Found by `triangle_soup`: three points on a line whose cross product is not
/// zero but rounding noise.
#[test]
fn points_on_a_line_have_no_area() {
    for direction in [DVec3::new(1.0, -2.0, 3.0), DVec3::new(3.0, 1.0, 7.0)] {
        for step in [0.1, 0.3, 1.0 / 3.0] {
            for i in 1..20 {
                let along = |k: i32| direction * (f64::from(k) * step);
                let corners = [along(-2), along(i), along(31)];
                let field = Field::from_triangles(vec![corners], Vec::new(), Vec::new());
                assert_eq!(field.degenerate_faces(), 1);
                assert_eq!(field.normal(FaceId(0)), DVec3::ZERO);
            }
        }
    }
}

#[test]
fn slivers_agree_with_the_oracle() {
    let mut shape = bumpy(2);
    for (i, height) in [1e-5, 1e-7, 1e-9, 1e-12].into_iter().enumerate() {
        let n = shape.points.len() as u32;
        let base = DVec3::new(0.3 * i as f64 - 0.5, 0.2, 0.9);
        shape.points.extend([
            base,
            base + DVec3::ONE,
            base + DVec3::ONE * 0.4 + DVec3::X * height,
        ]);
        shape.push([n, n + 1, n + 2], false);
    }
    let field = shape.field();
    let mut dice = Dice(13);
    for _ in 0..300 {
        check_point(&field, dice.point(field.bounds()));
    }
}

#[test]
fn nonsense_does_not_panic() {
    let mut shape = bumpy(1);
    shape.points[3] = DVec3::new(f64::NAN, 0.0, 1.0);
    shape.points[4] = DVec3::splat(f64::INFINITY);
    let one = Field::from_triangles(vec![[DVec3::ZERO; 3]], vec![], vec![]);
    let none = Field::from_triangles(vec![], vec![], vec![]);
    let flat = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 3000];
    let stacked = Field::from_triangles(flat, vec![], vec![]);
    let all_coping = {
        let mut s = cuboid(1.0, 1.0, 1.0);
        s.coping.fill(true);
        s.field()
    };
    let mut feet = Vec::new();
    let mut found = Vec::new();
    for field in [shape.field(), one, none, stacked, all_coping] {
        for x in [
            0.1,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            1e308,
            -1e-320,
        ] {
            for p in [DVec3::splat(x), DVec3::new(x, 0.0, 0.2)] {
                let foot = field.footpoint(p);
                assert_eq!(field.footpoint_near(p, FaceId(0)).face, foot.face);
                if !p.is_finite() {
                    assert!(!foot.distance.is_finite());
                }
                field.footpoints_within(p, 0.3, &mut feet);
                field.footpoints_within(p, f64::NAN, &mut feet);
                assert!(feet.is_empty());
                field.nearest_coping(p, 0.5);
                field.nearest_coping(p, f64::NAN);
                field.nearest_coping(p, -1.0);
                field.inside(p);
                field.signed_clearance(p);
                field.hits(p, DVec3::splat(0.3), &mut found);
                field.hits(DVec3::splat(0.3), p, &mut found);
                field.footpoint_on(p, FaceId(77_777_777));
            }
        }
    }
}

#[test]
fn deep_trees_and_many_ties() {
    // Each triangle half as large as the last, all at one corner; then a
    // thousand copies of one triangle; then a fan with 200 equal distances.
    let nested: Vec<_> = (0..300)
        .map(|i| {
            let s = 0.9_f64.powi(i);
            [
                DVec3::ZERO,
                DVec3::new(s, 0.1 * s, 0.0),
                DVec3::new(0.0, s, s),
            ]
        })
        .collect();
    let copies = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; 1000];
    let around = |i: i32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 200.0;
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    let drum: Vec<_> = (0..200)
        .map(|i| [around(i), around(i + 1), around(i) + DVec3::Z])
        .collect();
    for corners in [nested, copies, drum] {
        let field = Field::from_triangles(corners, Vec::new(), Vec::new());
        for p in grid((DVec3::splat(-0.5), DVec3::ONE), 6) {
            check_point(&field, p);
        }
        check_point(&field, DVec3::new(0.0, 0.0, 0.25));
    }
}

#[test]
fn shuffled_triangles_give_the_same_points() {
    let shape = bumpy(2);
    let field = shape.field();
    let mut shuffled = shape.clone();
    shuffled.triangles.reverse();
    shuffled.coping.reverse();
    let other = shuffled.field();
    let last = shape.triangles.len() as u32 - 1;
    let mut dice = Dice(23);
    for _ in 0..500 {
        let p = dice.point(field.bounds());
        let (a, b) = (field.footpoint(p), other.footpoint(p));
        assert!((a.distance - b.distance).abs() <= 1e-15);
        if a.distance == field.footpoint_on(p, FaceId(last - b.face.0)).distance {
            assert!(a.face <= FaceId(last - b.face.0));
        }
        assert_eq!(field.inside(p), other.inside(p));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn triangle_soup(
        coordinates in prop::collection::vec(-4_i8..=4, 9..180),
        queries in prop::collection::vec(-10_i8..=10, 30),
        coping in prop::collection::vec(any::<bool>(), 20),
    ) {
        let points: Vec<_> = coordinates
            .chunks_exact(3)
            .map(|c| DVec3::new(f64::from(c[0]), f64::from(c[1]), f64::from(c[2])) * 0.1)
            .collect();
        let corners: Vec<_> = points.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let field = Field::from_triangles(corners, vec![], coping);
        for q in queries.chunks_exact(3) {
            let p = DVec3::new(f64::from(q[0]), f64::from(q[1]), f64::from(q[2])) * 0.05;
            if nearest(&field, p, false).is_some() {
                check_point(&field, p);
            }
        }
    }
}

/// A plate that ends 0.3 before another: behind its end, coping, the other is no footpoint;
/// in the gap, and from within itself, it is.
#[test]
fn walls_beyond_a_gap_are_hidden() {
    let plate = cuboid(2.0, 2.0, 10.0);
    let mut both = plate.clone();
    let beyond = cuboid(8.0, 8.0, 1.0).map(|p| p + DVec3::new(-3.0, -3.0, 10.3));
    let first = both.points.len() as u32;
    both.points.extend(&beyond.points);
    for t in &beyond.triangles {
        both.push(t.map(|v| v + first), false);
    }
    let field = both.field();
    let mut near = Vec::new();
    for z in [9.9, 9.99, 10.0] {
        let p = DVec3::new(1.0, 0.9, z);
        check_point(&field, p);
        assert_eq!(field.footpoint(p).distance, 0.9, "{z}");
        field.footpoints_within(p, 1.0, &mut near);
        assert!(near.iter().all(|f| f.point.z <= 10.0), "{z}");
        assert!(!field.inside(p) || z < 10.0);
    }
    for (z, distance) in [(10.1, 0.2), (10.5, 0.2), (10.9, 0.4)] {
        let foot = field.footpoint(DVec3::new(1.0, 0.9, z));
        assert!((foot.distance - distance).abs() < 1e-12, "{z}: {foot:?}");
    }
}
