//! Facts about limit surfaces and crusts.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;

use super::*;
use crate::io::read_control;
use crate::offset::OffsetError;

const CLOSED: [&str; 7] = [
    "cube",
    "torus",
    "genus3",
    "valence_mix",
    "spike",
    "head",
    "degenerate",
];
const OPEN: [&str; 5] = [
    "open_sheet",
    "open_curved",
    "open_hole",
    "flat_sheet",
    "flat_l",
];
const RULES: [Boundary; 2] = [Boundary::EdgeAndCorner, Boundary::EdgeOnly];

pub(super) fn cage(name: &str) -> Cage {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/cages");
    let control = read_control(folder.join(format!("{name}.obj"))).expect(name);
    Cage::new(control.positions, &control.faces).expect(name)
}

fn surface(name: &str, level: u32, boundary: Boundary) -> LimitSurface {
    let (mesh, done) = refined(&cage(name), level, boundary).expect(name);
    assert_eq!(done, level);
    LimitSurface::new(mesh, boundary).expect(name)
}

/// Every cage with every rule that makes a difference.
fn all() -> impl Iterator<Item = (&'static str, Boundary)> {
    let closed = CLOSED.map(|name| (name, Boundary::EdgeAndCorner));
    let open = OPEN.iter().flat_map(|&name| RULES.map(|rule| (name, rule)));
    closed.into_iter().chain(open)
}

/// A fan of `n` quadrilaterals around a point, closed to a dome or, if not
/// `closed`, of half a turn.
fn dome(n: u32, closed: bool) -> Cage {
    let spokes = if closed { n } else { n + 1 };
    let mut positions = vec![DVec3::new(0.0, 0.0, 1.0)];
    let mut faces = Vec::new();
    let turn = if closed { 2.0 * PI } else { PI };
    for k in 0..2 * n + u32::from(!closed) {
        let (sin, cos) = (turn * f64::from(k) / f64::from(2 * n)).sin_cos();
        let reach = if k % 2 == 0 { 1.0 } else { 1.5 };
        let height = 0.7 - 0.1 * f64::from(k % 3);
        positions.push(DVec3::new(reach * cos, reach * sin, height));
    }
    for k in 0..n {
        let at = |k: u32| 1 + if closed { k % (2 * n) } else { k };
        faces.push(Polygon::from_slice(&[
            0,
            at(2 * k),
            at(2 * k + 1),
            at(2 * k + 2),
        ]));
    }
    assert_eq!(positions.len() as u32, 1 + n + spokes);
    Cage::new(positions, &faces).expect("a dome")
}

#[test]
fn a_face_is_what_its_subdivisions_are() {
    for (name, rule) in all() {
        agrees_with_its_subdivisions(name, &cage(name), rule);
    }
}

/// Points and derivatives of a surface are those of its subdivisions, and the
/// corners of the finest are closed forms: (2.2), (2.3).
pub(super) fn agrees_with_its_subdivisions(name: &str, cage: &Cage, rule: Boundary) {
    // Child `4 f + k` covers the quarter of face f at corner k, axes kept.
    let corner = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
    let [coarse, finer, finest] = [0, 1, 2].map(|level| {
        let (mesh, _) = refined(cage, level, rule).expect(name);
        LimitSurface::new(mesh, rule).expect(name)
    });
    let size = coarse.mesh().cage().diagonal();
    for face in 0..coarse.face_count() {
        for (k, [u0, v0]) in corner.iter().enumerate() {
            for (u, v) in [
                (0.3, 0.9),
                (0.0, 0.2),
                (1.0, 0.55),
                (0.01, 0.004),
                (0.5, 1.0),
            ] {
                let child = 4 * face + k;
                let (pu, pv) = (u0 + 0.5 * u, v0 + 0.5 * v);
                let a = coarse.at(face, pu, pv);
                let b = finer.at(child, u, v);
                let off = |p: DVec3, q: DVec3| p.distance(q) / size;
                assert!(
                    off(a.point, b.point) < 1e-14,
                    "{name} {rule:?} {face} {k} {u} {v}"
                );
                // Derivatives grow by 2 and 4; so does their rounding.
                assert!(off(a.du, 2.0 * b.du) < 1e-12 && off(a.dv, 2.0 * b.dv) < 1e-12);
                for (p, q) in [(a.duu, b.duu), (a.duv, b.duv), (a.dvv, b.dvv)] {
                    let scale = size.max(p.length());
                    assert!(p.distance(4.0 * q) < 1e-11 * scale, "{name} {face} {u} {v}");
                }
            }
            for (j, [u1, v1]) in corner.iter().enumerate() {
                let grandchild = 4 * (4 * face + k) + j;
                let vertex = finest.mesh().corners(grandchild)[j] as usize;
                let at = [u0 + 0.5 * u1, v0 + 0.5 * v1];
                let side = |t: f64, low: f64| if low > 0.0 { t + 0.25 } else { t };
                let (u, v) = (side(at[0], *u1), side(at[1], *v1));
                let jet = coarse.at(face, u, v);
                let limit = finest.limits()[vertex];
                assert!(
                    jet.point.distance(limit) < 1e-14 * size,
                    "{name} {face} {u} {v}"
                );
                let cross = jet.cross();
                if cross.length() > 1e-6 * size * size {
                    let normal = finest.corner_normal(grandchild, j);
                    assert!(cross.normalize().distance(normal) < 1e-11, "{name} {face}");
                }
            }
        }
    }
}

/// First and second derivatives along a side of a face, and into the face.
fn framed(jet: &Jet, side: usize) -> [DVec3; 5] {
    let Jet {
        du,
        dv,
        duu,
        duv,
        dvv,
        ..
    } = *jet;
    match side {
        0 => [du, dv, duu, duv, dvv],
        1 => [dv, -du, dvv, -duv, duu],
        2 => [-du, -dv, duu, duv, dvv],
        _ => [-dv, du, dvv, -duv, duu],
    }
}

/// Greatest relative jump of value, first and second derivatives of S and of
/// the crust offset, over all borders: between regular vertices, and beside
/// extraordinary ones.
pub(super) fn jumps(surface: &LimitSurface, places: &[f64]) -> [f64; 2] {
    let crust = Crust::offset(surface, 0.1);
    let cage = surface.mesh().cage();
    let size = cage.diagonal();
    let mut worst = [0.0_f64; 2];
    for h in 0..cage.corner_count() as u32 {
        let Some(twin) = cage.twin(h).filter(|&twin| twin > h) else {
            continue;
        };
        let odd = [cage.origin(h), cage.end(h)]
            .iter()
            .any(|&v| !surface.is_regular(v));
        let place = |side: u32, t: f64| match side % 4 {
            0 => (t, 0.0),
            1 => (1.0, t),
            2 => (1.0 - t, 1.0),
            _ => (0.0, 1.0 - t),
        };
        for &t in places {
            let both = [(h, t), (twin, 1.0 - t)].map(|(h, t)| {
                let (face, (u, v)) = (h as usize / 4, place(h, t));
                let outer = surface.at(face, u, v);
                (outer, outer.minus(&crust.at(surface, face, u, v)))
            });
            for (a, b) in [(both[0].0, both[1].0), (both[0].1, both[1].1)] {
                let mut jump = a.point.distance(b.point) / size;
                let a = framed(&a, h as usize % 4);
                let b = framed(&b, twin as usize % 4);
                // The neighbour sees both directions reversed.
                let scale = |k: std::ops::Range<usize>| {
                    a[k].iter().fold(0.0_f64, |most, d| most.max(d.length()))
                };
                let (first, second) = (scale(0..2), scale(0..5));
                for k in 0..2 {
                    jump = jump.max(a[k].distance(-b[k]) / (first + 1e-3 * size));
                }
                for k in 2..5 {
                    jump = jump.max(a[k].distance(b[k]) / (second + 1e-3 * size));
                }
                worst[usize::from(odd)] = worst[usize::from(odd)].max(jump);
            }
        }
    }
    worst
}

#[test]
fn faces_join_smoothly_to_the_second_derivative() {
    // Dyadic places, so that 1 - t is exact.
    let near: Vec<f64> = [1, 2, 3, 5, 8, 11, 13, 20, 30, 45]
        .map(|k| 0.5_f64.powi(k))
        .to_vec();
    let places = [
        near.as_slice(),
        &[0.375, 0.625, 0.75, 0.9375, 1.0 - near[8]],
    ]
    .concat();
    for (name, rule) in all() {
        for level in [0, 1] {
            let [regular, odd] = jumps(&surface(name, level, rule), &places);
            assert!(regular < 1e-12, "{name} {rule:?} {level}: {regular:e}");
            assert!(
                odd < 1e-10,
                "{name} {rule:?} {level}: {odd:e} beside an odd vertex"
            );
        }
    }
}

#[test]
fn any_valence_inside_and_on_the_boundary() {
    for n in [3, 4, 5, 6, 7, 8, 12, 20, 50] {
        for closed in [true, false] {
            for rule in RULES {
                let mesh = Quads::new(dome(n, closed)).expect("quadrilaterals");
                let dome = LimitSurface::new(mesh, rule).expect("small");
                let places = [0.5, 0.25, 0.03125, 0.0009765625, 0.5_f64.powi(25)];
                let [_, odd] = jumps(&dome, &places);
                assert!(odd < 1e-10, "{n} {closed} {rule:?}: {odd:e}");
                for face in 0..dome.face_count() {
                    for k in 1..12 {
                        let r = 0.5_f64.powi(4 * k);
                        let jet = dome.at(face, r, 0.3 * r);
                        assert!(
                            jet.point.is_finite() && jet.cross().z > 0.0,
                            "{n} {face} {r}"
                        );
                    }
                    let corner = dome.at(face, 0.0, 0.0).point;
                    assert!(corner.distance(dome.limits()[0]) < 1e-15, "{n} {face}");
                    assert!(dome.at(face, 1e-300, 0.0).point.is_finite());
                }
            }
        }
    }
}

#[test]
fn beside_an_extraordinary_vertex_the_surface_shrinks_by_its_eigenvalue() {
    for n in [3, 5, 8, 20] {
        let mesh = Quads::new(dome(n, true)).expect("quadrilaterals");
        let dome = LimitSurface::new(mesh, Boundary::default()).expect("small");
        let (c, h) = ((2.0 * PI / f64::from(n)).cos(), (PI / f64::from(n)).cos());
        let eigenvalue = (5.0 + c + h * (2.0 * (9.0 + c)).sqrt()) / 16.0;
        let step = |k: i32| {
            let (near, far) = (0.5_f64.powi(k), 0.5_f64.powi(k + 1));
            dome.at(1, far, 0.6 * far).du.length() / dome.at(1, near, 0.6 * near).du.length()
        };
        // A derivative by u grows by twice the eigenvalue a step.
        assert!(
            (step(60) - 2.0 * eigenvalue).abs() < 1e-7,
            "{n} {}",
            step(60)
        );
        // The normal converges to (2.3), the slower the higher the valence.
        let normal = dome.at(1, 0.5_f64.powi(60), 0.3 * 0.5_f64.powi(60)).cross();
        let angle = normal.angle_between(dome.normals()[0]);
        assert!(angle < 1e-3, "{n} {angle:e}");
    }
}

#[test]
fn the_crust_is_d_at_corners_and_never_more() {
    for (name, rule) in all() {
        for level in [0, 1] {
            let surface = surface(name, level, rule);
            let d = 0.1;
            let crust = Crust::offset(&surface, d);
            let grid = Grid::new(&surface, 6).expect("few");
            let samples = grid.sample(&surface, &crust, Scheme::Crust);
            for (k, (p, q)) in samples.outer.iter().zip(&samples.inner).enumerate() {
                let length = p.distance(*q) / d;
                assert!(length < 1.0 + 1e-13, "{name} {level}: (4.1) {length}");
                if k < surface.limits().len() {
                    assert!(length > 1.0 - 1e-13, "{name} {level}: corner {length}");
                }
                if name.starts_with("flat") {
                    assert!((length - 1.0).abs() < 1e-13, "{name}: {length}");
                }
            }
            let unit = samples
                .normals
                .iter()
                .all(|n| (n.length() - 1.0).abs() < 1e-14);
            assert!(unit, "{name} {level}");
            let direct = grid.sample(&surface, &crust, Scheme::Direct);
            for (p, q) in direct.outer.iter().zip(&direct.inner) {
                assert!((p.distance(*q) / d - 1.0).abs() < 1e-13);
            }
        }
    }
}

#[test]
fn samples_are_points_of_their_faces() {
    for (name, rule) in [
        ("cube", Boundary::default()),
        ("valence_mix", Boundary::default()),
        ("open_hole", Boundary::EdgeOnly),
    ] {
        let surface = surface(name, 0, rule);
        let crust = Crust::offset(&surface, 0.1);
        for n in [1, 2, 3, 8, 11] {
            let grid = Grid::new(&surface, n).expect("few");
            let samples = grid.sample(&surface, &crust, Scheme::Crust);
            for face in 0..surface.face_count() {
                for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                    let at = grid.index(face, i, j) as usize;
                    let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                    let outer = surface.at(face, u, v).point;
                    let inner = outer - crust.at(&surface, face, u, v).point;
                    assert!(outer.distance(samples.outer[at]) < 1e-13, "{name} {n}");
                    assert!(inner.distance(samples.inner[at]) < 1e-13, "{name} {n}");
                }
            }
        }
    }
}

#[test]
fn interpolation_passes_through_the_control_vertices() {
    for name in ["cube", "genus3", "open_curved"] {
        let cage = cage(name);
        let (mesh, level) = interpolate(&cage, 0, 3, Boundary::default()).expect(name);
        assert_eq!(level, 0);
        for (p, q) in mesh.positions.iter().zip(cage.positions()) {
            assert!(p.distance(*q) < 1e-14 * cage.diagonal());
        }
    }
}

#[test]
fn a_collapsed_cap_gets_the_normal_of_its_neighbours() {
    let surface = surface("degenerate", 0, Boundary::default());
    assert_eq!(surface.averaged().len(), 1);
    assert!(surface.without_normal().is_empty());
    let apex = surface.averaged()[0] as usize;
    assert!(surface.normals()[apex].distance(DVec3::Z) < 1e-14);
    // Without any area there is no normal to average.
    let point = Cage::new(vec![DVec3::ONE; 4], &[Polygon::from_slice(&[0, 1, 2, 3])]);
    let settings = Settings {
        thickness: 0.1,
        samples: 2,
        level: Level::Fixed(0),
        scheme: Scheme::Crust,
        boundary: Boundary::default(),
    };
    let error = hollow_out(&point.expect("linked"), &settings, &|_| ()).err();
    let (vertex, level) = (0, 0);
    assert_eq!(error, Some(SubdivideError::NoNormal { vertex, level }));
}

/// Folded triangles at 8 samples a side, and the fold-free thickness: crust, direct.
fn folds(name: &str, level: u32, thickness: f64) -> ([usize; 2], [f64; 2]) {
    let surface = surface(name, level, Boundary::default());
    let crust = Crust::offset(&surface, thickness);
    let grid = Grid::new(&surface, 8).expect("few");
    let triangles = grid.triangles();
    let count = |scheme| folded(&triangles, &grid.sample(&surface, &crust, scheme)).len();
    let free = fold_free(&surface).map(|free| free.thickness);
    ([count(Scheme::Crust), count(Scheme::Direct)], free)
}

#[test]
fn folds_grow_with_the_level_as_measured_elsewhere() {
    for (name, level, d, counts, free) in [
        ("spike", 0, 0.15, [0, 12], [0.162, 0.115]),
        ("spike", 1, 0.15, [204, 78], [0.116, 0.115]),
        ("spike", 2, 0.15, [1204, 308], [0.080, 0.115]),
        ("cube", 0, 0.2, [0, 0], [0.575, 0.627]),
        ("cube", 1, 0.2, [0, 0], [0.467, 0.597]),
        ("head", 0, 0.02, [0, 40], [0.0253, 0.0142]),
    ] {
        let (found, thickness) = folds(name, level, d);
        assert_eq!(found, counts, "{name} {level}");
        for k in 0..2 {
            assert!(
                (thickness[k] / free[k] - 1.0).abs() < 0.01,
                "{name} {thickness:?}"
            );
        }
    }
}

fn settings(thickness: f64, level: Level) -> Settings {
    Settings {
        thickness,
        samples: 8,
        level,
        scheme: Scheme::Crust,
        boundary: Boundary::default(),
    }
}

#[test]
fn epsilon_shrinks_with_the_level_as_measured_elsewhere() {
    for (name, d, shares) in [
        ("cube", 0.2, [0.423, 0.126, 0.036].as_slice()),
        ("torus", 0.15, &[0.160, 0.042, 0.0113]),
        ("spike", 0.1, &[0.645, 0.272]),
        ("head", 0.02, &[0.624]),
    ] {
        for (level, &share) in shares.iter().enumerate() {
            let settings = settings(d, Level::Fixed(level as u32));
            let solid = hollow_out(&cage(name), &settings, &|_| ()).expect(name);
            let found = solid.trial.epsilon / d;
            assert!(
                (found / share - 1.0).abs() < 0.06,
                "{name} {level}: {found}"
            );
        }
    }
}

#[test]
fn a_tolerance_chooses_the_level_or_says_that_there_is_none() {
    let level = |tolerance| {
        let settings = settings(0.2, Level::Tolerance(tolerance));
        let solid = hollow_out(&cage("cube"), &settings, &|_| ()).expect("a level");
        assert!(solid.folded.is_empty() && solid.trial.epsilon <= tolerance);
        (solid.trial.level, solid.trials.len())
    };
    assert_eq!(level(0.1), (0, 1));
    assert_eq!(level(0.03), (1, 2));
    assert_eq!(level(0.01), (2, 3));
    // Free of folds at level 0 and 1, true enough from level 2 on.
    match hollow_out(
        &cage("cube"),
        &settings(0.45, Level::Tolerance(0.02)),
        &|_| (),
    ) {
        Err(SubdivideError::NoLevel { trials, .. }) => {
            let met = |trial: &Trial| {
                let free = trial.fold_free[0].thickness > 0.45;
                [trial.epsilon <= 0.02, free]
            };
            let met: Vec<[bool; 2]> = trials.iter().map(met).collect();
            assert_eq!(met, [[false, true], [false, true], [true, false]]);
        }
        other => panic!("{:?}", other.map(|solid| solid.trial)),
    }
}

#[test]
fn other_polygons_force_a_step() {
    let positions = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let positions = positions.map(|p: [i32; 3]| p.map(f64::from).into());
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let faces = faces.map(|face| Polygon::from_slice(&face));
    let cage = Cage::new(positions.to_vec(), &faces).expect("sound");
    for (asked, got) in [(0, 1), (1, 1), (2, 2)] {
        let solid = hollow_out(&cage, &settings(0.05, Level::Fixed(asked)), &|_| ());
        let solid = solid.expect("a solid");
        assert_eq!(solid.forced, 1);
        assert_eq!(solid.trial.level, got);
        assert_eq!(solid.faces, 12 << (2 * (got - 1)));
    }
}

#[test]
fn bad_settings_are_refused() {
    let cage = cage("cube");
    let refused = |settings: Settings| hollow_out(&cage, &settings, &|_| ()).err();
    for thickness in [0.0, -1.0, f64::INFINITY] {
        let error = refused(settings(thickness, Level::Fixed(0)));
        assert_eq!(error, Some(SubdivideError::Thickness(thickness)));
    }
    assert!(refused(settings(f64::NAN, Level::Fixed(0))).is_some());
    let error = refused(settings(0.1, Level::Fixed(13)));
    assert_eq!(error, Some(SubdivideError::Levels(13)));
    let mut many = settings(0.1, Level::Fixed(0));
    for samples in [0, MOST_SAMPLES + 1] {
        many.samples = samples;
        assert_eq!(
            refused(many),
            Some(SubdivideError::Samples { samples, faces: 6 })
        );
    }
    let zero = refused(settings(0.1, Level::Tolerance(0.0)));
    assert_eq!(zero, Some(SubdivideError::Tolerance(0.0)));
}

/// Where the crust folds, the contoured wall does not; where it does not, the
/// two agree.
#[test]
fn a_contoured_wall_never_folds() {
    let wall = |name: &str, thickness: f64| {
        let settings = ContourSettings {
            thickness,
            samples: 3,
            level: 1,
            boundary: Boundary::default(),
            cell: crate::settings::cell::CellSize::Length(0.4 * thickness),
            precision: crate::settings::precision::Precision::Double,
        };
        contour(&cage(name), &settings, &|_, _, _| ())
    };
    for (name, thickness) in [("cube", 0.2), ("spike", 0.25), ("torus", 0.3)] {
        let solid = wall(name, thickness).expect(name);
        assert!(solid.mesh.edges().census().is_closed());
        assert!(solid.intersections.is_empty(), "{name}");
        let outer = solid.mesh.triangles[..solid.outer].as_flattened();
        let first = *outer.iter().max().expect("triangles") as usize + 1;
        for t in &solid.thickness[first..] {
            assert!((t / thickness - 1.0).abs() < 0.01, "{name}: {t}");
        }
    }
    let open = wall("open_curved", 0.1).expect("a sheet");
    assert!(open.mesh.edges().census().is_closed() && open.intersections.is_empty());
    let most = open.thickness.iter().copied().fold(0.0, f64::max);
    assert!((most / 0.1 - 1.0).abs() < 0.02, "{most}");
    assert!(matches!(
        wall("cube", 50.0),
        Err(ContourError::Offset(OffsetError::Empty(_)))
    ));
}
