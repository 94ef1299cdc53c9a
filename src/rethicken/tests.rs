use glam::DVec3;

use super::*;
use crate::dual_contour::Implicit;
use crate::mesh::{EdgeUses, is_thin, self_intersections};

/// Positions, radii, triangles.
type Sheet = (Vec<DVec3>, Vec<f64>, Vec<[u32; 3]>);

/// A rectangle of 2 x n x m triangles in the plane z = 0, radius by place.
fn sheet(size: [f64; 2], n: [u32; 2], radius: impl Fn(DVec3) -> f64) -> Sheet {
    let (nx, ny) = (n[0], n[1]);
    let at = |i: u32, j: u32| {
        DVec3::new(
            size[0] * f64::from(i) / f64::from(nx),
            size[1] * f64::from(j) / f64::from(ny),
            0.0,
        )
    };
    let positions: Vec<DVec3> = (0..=ny)
        .flat_map(|j| (0..=nx).map(move |i| at(i, j)))
        .collect();
    let radii = positions.iter().map(|&p| radius(p)).collect();
    let v = |i: u32, j: u32| j * (nx + 1) + i;
    let triangles = (0..ny)
        .flat_map(|j| {
            (0..nx).flat_map(move |i| {
                let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
        })
        .collect();
    (positions, radii, triangles)
}

fn solid_of(surface: &BallSurface, cell: f64) -> TriMesh {
    let settings = Settings {
        cell,
        ..Settings::new(surface)
    };
    let mesh = rethicken(surface, &settings, &|_, _, _| ()).unwrap().mesh;
    assert!(self_intersections(&mesh).is_empty());
    assert!(mesh.faces().all(|f| !is_thin(mesh.corners(f), 1e-9)));
    mesh
}

#[test]
fn a_sheet_with_flat_borders_is_a_box() {
    let (p, r, t) = sheet([7.0, 5.0], [9, 6], |_| 1.0);
    let surface = BallSurface::new(p, r, t, |_| true).unwrap();
    let mesh = solid_of(&surface, 0.6);
    let bounds = mesh.bounds();
    let (low, high) = (DVec3::new(0.0, 0.0, -1.0), DVec3::new(7.0, 5.0, 1.0));
    assert!(
        (bounds.min - low).length() < 1e-9 && (bounds.max - high).length() < 1e-9,
        "{bounds:?}"
    );
    assert!((mesh.volume() - 70.0).abs() < 1e-6, "{}", mesh.volume());
}

#[test]
fn a_sheet_with_round_borders_is_a_pad() {
    let (p, r, t) = sheet([7.0, 5.0], [3, 2], |_| 1.0);
    let surface = BallSurface::new(p, r, t, |_| false).unwrap();
    let mesh = solid_of(&surface, 0.3);
    let pi = std::f64::consts::PI;
    let volume = 70.0 + 12.0 * pi + 4.0 / 3.0 * pi;
    assert!(
        (mesh.volume() / volume - 1.0).abs() < 5e-3,
        "{} {volume}",
        mesh.volume()
    );
}

/// Both surfaces beside each other, not joined.
fn both(a: Sheet, b: Sheet) -> Sheet {
    let (mut positions, mut radii, mut triangles) = a;
    let first = positions.len() as u32;
    positions.extend(b.0);
    radii.extend(b.1);
    triangles.extend(b.2.iter().map(|t| t.map(|v| v + first)));
    (positions, radii, triangles)
}

fn flat_all((p, r, t): Sheet) -> BallSurface {
    BallSurface::new(p, r, t, |_| true).unwrap()
}

#[test]
fn a_hole_keeps_its_sharp_corners() {
    let (p, r, t) = sheet([6.0, 6.0], [6, 6], |_| 0.5);
    let inner = |x: f64| (2.0..4.0).contains(&x);
    let solid = t.into_iter().filter(|t| {
        let centre = t.iter().map(|&v| p[v as usize]).sum::<DVec3>() / 3.0;
        !(inner(centre.x) && inner(centre.y))
    });
    let t: Vec<[u32; 3]> = solid.collect();
    let mesh = solid_of(&flat_all((p, r, t)), 0.43);
    assert!((mesh.volume() - 32.0).abs() < 1e-6, "{}", mesh.volume());
    let area = 2.0 * 32.0 + 24.0 + 8.0;
    assert!((mesh.area() - area).abs() < 1e-6, "{}", mesh.area());
}

/// Arms of a plus, three wide, of a shell five times as thick.
#[test]
fn cells_get_finer_where_they_miss_features() {
    let (p, r, t) = sheet([9.0, 9.0], [3, 3], |_| 7.5);
    let arm = |x: f64| (3.0..6.0).contains(&x);
    let plus = t.into_iter().filter(|t| {
        let centre = t.iter().map(|&v| p[v as usize]).sum::<DVec3>() / 3.0;
        arm(centre.x) || arm(centre.y)
    });
    let surface = flat_all((p.clone(), r, plus.collect()));
    // No more than one node each way is inside.
    let settings = Settings {
        cell: 9.0,
        ..Settings::new(&surface)
    };
    let solid = rethicken(&surface, &settings, &|_, _, _| ()).unwrap();
    assert!(solid.cell < settings.cell);
    assert!(solid.missing.is_none(), "{:?}", solid.missing);
    let volume = solid.mesh.volume();
    assert!((volume / 675.0 - 1.0).abs() < 0.01, "{volume}");
    // Without being told, cells are small against the surface.
    let usual = Settings::new(&surface);
    assert!(usual.cell < 45_f64.sqrt() / 30.0);
    let solid = rethicken(&surface, &usual, &|_, _, _| ()).unwrap();
    assert_eq!(solid.cell, usual.cell);
    assert!((solid.mesh.volume() - 675.0).abs() < 1e-6);
}

/// A tongue far thinner than any cell that is tried.
#[test]
fn what_is_missing_is_said() {
    let square = sheet([4.0, 4.0], [1, 1], |_| 1.0);
    let tongue = {
        let (p, r, t) = sheet([6.0, 1e-4], [1, 1], |_| 1.0);
        let beside = |p: DVec3| p + DVec3::new(4.0, 2.0371, 0.0);
        (p.into_iter().map(beside).collect(), r, t)
    };
    let surface = flat_all(both(square, tongue));
    let solid = rethicken(&surface, &Settings::new(&surface), &|_, _, _| ()).unwrap();
    assert!(!solid.missing.is_none());
    assert!(solid.missing.max > 1.0);
    let said = |w: &RethickenWarning| matches!(w, RethickenWarning::Missing { .. });
    assert!(solid.warnings.iter().any(said));
}

#[test]
fn an_end_cuts_its_own_sheet_alone() {
    // A web whose end stands on a plate: the planes of its borders pass
    // through the plate, within the reach of its balls.
    let web = {
        let (p, r, t) = sheet([3.0, 4.0], [3, 4], |_| 0.5);
        let up = |p: DVec3| DVec3::new(3.0 + p.x, 2.0, p.y);
        (p.into_iter().map(up).collect(), r, t)
    };
    let plate = sheet([9.0, 4.0], [4, 2], |_| 1.0);
    let mesh = solid_of(&flat_all(both(plate, web)), 0.37);
    assert!(
        (mesh.volume() - (72.0 + 9.0)).abs() < 0.02,
        "{}",
        mesh.volume()
    );
}

#[test]
fn a_tube_ends_in_planes() {
    let (n, radius) = (64, 5.0);
    let (p, r, t) = sheet([1.0, 6.0], [n, 4], |_| 0.5);
    let bent = |p: &DVec3| {
        let (sin, cos) = (std::f64::consts::TAU * p.x).sin_cos();
        DVec3::new(radius * cos, radius * sin, p.y)
    };
    // The last column is the first again.
    let join = |v: u32| if v % (n + 1) == n { v - n } else { v };
    let p: Vec<DVec3> = p.iter().map(bent).collect();
    let t: Vec<[u32; 3]> = t.iter().map(|t| t.map(join)).collect();
    let mesh = solid_of(&flat_all((p, r, t)), 0.4);
    let bounds = mesh.bounds();
    assert!(bounds.min.z.abs() < 1e-9 && (bounds.max.z - 6.0).abs() < 1e-9);
    let volume = std::f64::consts::TAU * radius * 6.0;
    assert!(
        (mesh.volume() / volume - 1.0).abs() < 5e-3,
        "{}",
        mesh.volume()
    );
}

#[test]
fn ends_of_a_crumpled_sheet_leave_no_hole() {
    // The planes of neighbouring border edges disagree: the function steps
    // where another edge becomes the nearest.
    for seed in 0..12 {
        let noise = |k: u64| {
            let x = (k + 1000 * seed).wrapping_mul(6_364_136_223_846_793_005) ^ (k << 7);
            (x.wrapping_mul(1_442_695_040_888_963_407) >> 40) as f64 / (1 << 24) as f64 - 0.5
        };
        let (mut p, r, t) = sheet([8.0, 5.0], [16, 10], |_| 1.0);
        for (k, at) in (0..).zip(&mut p) {
            *at += 0.6 * DVec3::new(noise(3 * k), noise(3 * k + 1), 1.5 * noise(3 * k + 2));
        }
        let surface = BallSurface::new(p, r, t, |_| true).unwrap();
        let mesh = solid_of(&surface, 0.17);
        assert!(EdgeUses::new(&mesh).census().is_closed(), "{seed}");
    }
}

#[test]
fn a_taper_is_the_hull_of_its_balls() {
    let surface = |n| {
        let (p, r, t) = sheet([6.0, 3.0], n, |p| 0.5 + 0.1 * p.x);
        BallSurface::new(p, r, t, |_| true).unwrap()
    };
    let (coarse, fine) = (
        solid_of(&surface([1, 1]), 0.4),
        solid_of(&surface([6, 3]), 0.4),
    );
    assert!((coarse.volume() / fine.volume() - 1.0).abs() < 1e-6);
    // Tangent planes 1 / sqrt(1 - 0.01) steeper than the radius; no ball
    // reaches the edges of the thick end.
    let wedge = 6.0 * 3.0 * 1.6 / 0.99f64.sqrt();
    assert!(
        fine.volume() < wedge && fine.volume() > 0.999 * wedge,
        "{}",
        fine.volume()
    );
}

#[test]
fn the_answer_does_not_depend_on_the_hint() {
    let (p, r, t) = sheet([6.0, 3.0], [6, 3], |p| 0.5 + 0.1 * p.y);
    let surface = flat_all((p, r, t));
    let solid = SlabSolid::new(&surface);
    for i in 0..200 {
        let step = DVec3::new(0.819, 0.671, 0.549) * f64::from(i);
        let p = step.fract() * DVec3::new(8.0, 5.0, 3.0) - 1.0;
        let plain = solid.sample(p, u32::MAX);
        for hint in [0, 7, 35, 36, 50, 1000] {
            assert_eq!(solid.sample(p, hint), plain);
        }
    }
}

#[test]
fn what_is_no_ball_surface_is_refused() {
    let (p, r, t) = sheet([1.0, 1.0], [1, 1], |_| 1.0);
    let new = |p: &[DVec3], r: &[f64], t: &[[u32; 3]]| {
        BallSurface::new(p.to_vec(), r.to_vec(), t.to_vec(), |_| true).unwrap_err()
    };
    assert!(matches!(new(&p, &r, &[]), RethickenError::NoTriangles));
    assert!(matches!(
        new(&p, &r[1..], &t),
        RethickenError::RadiusCount { .. }
    ));
    assert!(matches!(
        new(&p, &r, &[[0, 1, 4]]),
        RethickenError::BadIndex { .. }
    ));
    assert!(matches!(
        new(&p, &[0.0; 4], &t),
        RethickenError::NoThickness
    ));
    let bad = new(&p, &[1.0, f64::NAN, -1.0, 1.0], &t);
    assert!(matches!(
        bad,
        RethickenError::BadRadius {
            vertex: 1,
            count: 2,
            ..
        }
    ));
    let far = [DVec3::ZERO, DVec3::X, DVec3::INFINITY, DVec3::Y];
    assert!(matches!(
        new(&far, &r, &t),
        RethickenError::BadPosition { vertex: 2 }
    ));
}
