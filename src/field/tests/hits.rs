//! Segment hits against sampling and against triangles surely crossed.

use super::*;

#[test]
fn hits_miss_nothing() {
    for shape in [cuboid(1.0, 1.0, 1.0), tee(), bumpy(2)] {
        let field = shape.field();
        let corners = shape.corners();
        let mut dice = Dice(17);
        let mut found = Vec::new();
        for (i, target) in corners.iter().enumerate() {
            let inner = (target[0] + target[1] + target[2]) / 3.0;
            let edge = target[1].lerp(target[2], dice.unit());
            for aim in [inner, edge, target[0]] {
                let from = dice.point(field.bounds());
                for to in [aim, aim + (aim - from) * 0.5, aim + (aim - from)] {
                    field.hits(from, to, &mut found);
                    assert!(found.is_sorted_by_key(|h| (h.t, h.face)));
                    assert!(found.iter().all(|h| (0.0..=1.0).contains(&h.t)));
                    assert_eq!(field.first_hit(from, to), found.first().copied());
                    let sure: Vec<_> = (0..corners.len() as u32)
                        .filter(|&f| surely_crosses(corners[f as usize], from, to))
                        .collect();
                    for f in sure {
                        let hit = found.iter().find(|h| h.face == FaceId(f));
                        let hit = hit.unwrap_or_else(|| panic!("{from} {to} lost {f}"));
                        let place = from.lerp(to, hit.t);
                        assert!(field.footpoint_on(place, hit.face).distance < 1e-9);
                    }
                    // Whatever is reported is touched, up to rounding.
                    for h in &found {
                        let place = from.lerp(to, h.t);
                        assert!(field.footpoint_on(place, h.face).distance < 1e-9);
                    }
                    // Where the segment changes sides it goes through the surface,
                    // not past a silhouette, and someone must answer.
                    let way = (aim - from) * 1e-4;
                    if to != aim && field.inside(aim - way) != field.inside(aim + way) {
                        let near = |h: &&Hit| from.lerp(to, h.t).distance(aim) < 2.0 * way.length();
                        assert!(found.iter().any(|h| near(&h)), "triangle {i}: {from} {to}");
                    }
                }
            }
        }
    }
}

/// Crosses the triangle's interior by a clear margin.
fn surely_crosses([a, b, c]: [DVec3; 3], from: DVec3, to: DVec3) -> bool {
    let n = (b - a).cross(c - a).normalize();
    let (s, e) = (n.dot(from - a), n.dot(to - a));
    if s * e >= 0.0 || s.abs() < 1e-9 || e.abs() < 1e-9 {
        return false;
    }
    let x = from.lerp(to, s / (s - e));
    let clear = |u: DVec3, v: DVec3| (v - u).cross(x - u).dot(n) > 1e-9;
    clear(a, b) && clear(b, c) && clear(c, a)
}

#[test]
fn segments_along_grid_lines_meet_closed_walls_on_both_sides() {
    // Axis-aligned segments through vertices, along edges and in planes.
    let field = tee().field();
    let (low, high) = field.bounds();
    let mut found = Vec::new();
    for p in grid((low, high), 8) {
        for axis in 0..3 {
            let (mut from, mut to) = (p, p);
            from[axis] = low[axis] - 1.0;
            to[axis] = high[axis] + 1.0;
            field.hits(from, to, &mut found);
            let oracle: Vec<_> = (0..field.face_count() as u32)
                .filter(|&f| touches_by_sampling(&field, FaceId(f), from, to))
                .collect();
            for f in oracle {
                assert!(
                    found.iter().any(|h| h.face == FaceId(f)),
                    "{from} {to} lost {f}"
                );
            }
        }
    }
}

/// Whether some sample of the segment lies on the face; samples include all
/// multiples of 1/16 in part units.
fn touches_by_sampling(field: &Field, face: FaceId, from: DVec3, to: DVec3) -> bool {
    let n = (from.distance(to) * 16.0).round() as i32;
    (0..=n).any(|i| {
        let p = from.lerp(to, f64::from(i) / f64::from(n));
        field.footpoint_on(p, face).distance == 0.0
    })
}

#[test]
fn segment_in_the_plane_reports_where_it_enters() {
    let corners = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]];
    let field = Field::from_triangles(corners, vec![[0, 1, 2]], vec![false]);
    let mut found = Vec::new();
    field.hits(
        DVec3::new(-1.0, 0.25, 0.0),
        DVec3::new(1.0, 0.25, 0.0),
        &mut found,
    );
    assert_eq!(
        found,
        [Hit {
            t: 0.5,
            face: FaceId(0)
        }]
    );
    field.hits(
        DVec3::new(0.1, 0.25, 0.0),
        DVec3::new(1.0, 0.25, 0.0),
        &mut found,
    );
    assert_eq!(
        found,
        [Hit {
            t: 0.0,
            face: FaceId(0)
        }]
    );
    field.hits(
        DVec3::new(-1.0, 1.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        &mut found,
    );
    assert_eq!(
        found,
        [Hit {
            t: 0.5,
            face: FaceId(0)
        }]
    );
    field.hits(
        DVec3::new(-1.0, 1.01, 0.0),
        DVec3::new(1.0, 1.01, 0.0),
        &mut found,
    );
    assert_eq!(found, []);
    // A segment shrunk to a point.
    field.hits(DVec3::splat(0.0), DVec3::splat(0.0), &mut found);
    assert_eq!(
        found,
        [Hit {
            t: 0.0,
            face: FaceId(0)
        }]
    );
    field.hits(DVec3::Z, DVec3::Z, &mut found);
    assert_eq!(found, []);
}
