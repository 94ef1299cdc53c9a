//! Surfaces to solids: what is promised of them, on surfaces of every kind.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use midsurf::internals::field::Field;
use midsurf::io::read_mesh;
use midsurf::mesh::{TriMesh, self_intersections};
use midsurf::offset::GridError;
use midsurf::thicken::{Repair, Settings, Side, ThickenError, Thickened, thicken};

use crate::common::{Desk, fixture, text};

const SIDES: [Side; 2] = [Side::Inner, Side::Outer];

/// A grid of `nu` by `nv` squares, halved; `round` closes it along `u`.
fn sheet(nu: usize, nv: usize, round: bool, place: impl Fn(f64, f64) -> DVec3) -> TriMesh {
    let columns = if round { nu } else { nu + 1 };
    let id = |i: usize, j: usize| ((i % columns) * (nv + 1) + j) as u32;
    let mut mesh = TriMesh::default();
    for i in 0..columns {
        for j in 0..=nv {
            mesh.positions
                .push(place(i as f64 / nu as f64, j as f64 / nv as f64));
        }
    }
    for i in 0..nu {
        for j in 0..nv {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            mesh.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    mesh
}

fn run(patch: &TriMesh, settings: &Settings) -> Result<Thickened, ThickenError> {
    thicken(patch, settings, &|_, _, _| ())
}

/// Everything that holds of every thickened solid.
fn check(patch: &TriMesh, settings: &Settings) -> Thickened {
    let result = run(patch, settings).unwrap();
    let mesh = &result.mesh;
    assert!(result.is_sound(), "{result:?}");
    assert!(mesh.edges().census().is_closed());
    assert_eq!(
        mesh.edges().census().manifold * 2,
        mesh.triangles.len() * 3,
        "two triangles an edge"
    );
    assert!(self_intersections(mesh).is_empty());
    assert!(mesh.volume() > 0.0);

    // The patch, bit for bit.
    let turned = |t: [DVec3; 3]| match settings.side {
        Side::Inner => t,
        Side::Outer => [t[0], t[2], t[1]],
    };
    for face in patch.faces() {
        assert_eq!(mesh.corners(face), turned(patch.corners(face)), "{face:?}");
    }

    // Nothing much farther away than the thickness, nothing on the patch but
    // itself.
    let field = Field::of_mesh(patch);
    let r = settings.thickness;
    for t in &mesh.triangles[result.patch_triangles..] {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        for p in [a, b, c] {
            assert!(field.footpoint(p).distance < r * 1.05, "{p}");
        }
        let centre = field.footpoint((a + b + c) / 3.0).distance;
        // Where walls meet, a triangle may cut the corner.
        assert!(centre < r * 1.1 && centre > 0.0, "{centre}");
    }
    assert!(result.deviation.mean < 4e-3 * r, "{:?}", result.deviation);
    result
}

fn settings(thickness: f64, side: Side) -> Settings {
    Settings::new(thickness, side)
}

#[test]
fn a_flat_sheet_gives_a_box() {
    let turn = |p: DVec3| {
        DVec3::new(
            0.36 * p.x + 0.48 * p.y - 0.8 * p.z,
            -0.8 * p.x + 0.6 * p.y,
            0.48 * p.x + 0.64 * p.y + 0.6 * p.z,
        )
    };
    for straight in [true, false] {
        let patch = sheet(4, 3, false, |u, v| {
            let p = DVec3::new(8.0 * u, 6.0 * v, 0.0);
            if straight { p } else { turn(p) }
        });
        for side in SIDES {
            let result = check(&patch, &settings(1.5, side));
            let volume = result.mesh.volume();
            // In general position an edge of the box may just miss a cell.
            let slack = if straight { 1e-9 } else { 2e-3 };
            assert!((volume / 72.0 - 1.0).abs() < slack, "{volume}");
            assert!(!straight || result.deviation.max < 1e-9);
        }
    }
}

#[test]
fn one_triangle_gives_a_prism() {
    let patch = TriMesh {
        positions: vec![
            DVec3::ZERO,
            DVec3::new(10.0, 0.5, 1.0),
            DVec3::new(1.5, 7.5, -0.5),
        ],
        triangles: vec![[0, 1, 2]],
    };
    for side in SIDES {
        let result = check(&patch, &settings(1.0, side));
        let ratio = result.mesh.volume() / patch.area();
        assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
    }
}

#[test]
fn a_tube_has_two_boundaries() {
    let (radius, height, r, n) = (5.0, 6.0, 1.0, 24);
    let patch = sheet(n, 3, true, |u, v| {
        let a = TAU * u;
        DVec3::new(radius * a.cos(), radius * a.sin(), height * v)
    });
    for side in SIDES {
        let result = check(&patch, &settings(r, side));
        assert_eq!(result.boundaries, 2);
        // Walls, and for the outer side the wedges between them.
        let (half, wall) = (PI / n as f64, 2.0 * radius * (PI / n as f64).sin());
        let section = match side {
            Side::Inner => n as f64 * (wall * r - r * r * half.tan()),
            Side::Outer => n as f64 * wall * r + PI * r * r,
        };
        let ratio = result.mesh.volume() / (section * height);
        assert!((ratio - 1.0).abs() < 2e-3, "{side:?} {ratio}");
    }
}

#[test]
fn a_fold_is_mitred_inside_and_round_outside() {
    let patch = sheet(6, 3, false, |u, v| {
        let along = 12.0 * (u - 0.5);
        DVec3::new(along.max(0.0), 5.0 * v, (-along).max(0.0))
    });
    let volumes = SIDES.map(|side| check(&patch, &settings(1.0, side)).mesh.volume());
    let mut expected = [5.0 * (12.0 - 1.0), 5.0 * (12.0 + PI / 4.0)];
    if volumes[0] > volumes[1] {
        expected.reverse();
    }
    for (found, wanted) in volumes.iter().zip(expected) {
        assert!((found / wanted - 1.0).abs() < 3e-3, "{volumes:?}");
    }
}

#[test]
fn a_closed_surface_gives_a_shell() {
    let patch = crate::common::cuboid(DVec3::ZERO, DVec3::new(6.0, 5.0, 4.0));
    let inner = check(&patch, &settings(1.0, Side::Inner));
    assert_eq!(inner.boundaries, 0);
    assert!((inner.mesh.volume() - (120.0 - 24.0)).abs() < 1e-6);
    let outer = check(&patch, &settings(1.0, Side::Outer));
    let grown = 148.0 + PI * 15.0 + 4.0 / 3.0 * PI;
    assert!((outer.mesh.volume() / grown - 1.0).abs() < 5e-3);
}

#[test]
fn walls_that_meet_are_one() {
    // A gutter whose inner sides are nearer to each other than two thicknesses.
    let patch = sheet(16, 3, false, |u, v| {
        let a = PI * (1.0 + u);
        DVec3::new(1.5 * a.cos(), 4.0 * v, 3.0 * a.sin())
    });
    for side in SIDES {
        check(&patch, &settings(1.0, side));
    }
}

#[test]
fn holes_and_corners_of_real_surfaces() {
    for (name, thickness, volumes) in [
        ("patch_corners.obj", 2.0, [2152.0, 2064.0]),
        ("patch_holes.obj", 2.0, [4309.0, 4281.0]),
    ] {
        let patch = read_mesh(fixture(name)).unwrap().mesh;
        for (side, volume) in SIDES.into_iter().zip(volumes) {
            let result = check(&patch, &settings(thickness, side));
            assert!((result.mesh.volume() / volume - 1.0).abs() < 2e-3);
        }
    }
}

#[test]
fn the_same_on_any_number_of_threads() {
    let patch = read_mesh(fixture("patch_corners.obj")).unwrap().mesh;
    let how = settings(2.0, Side::Inner);
    let results = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| run(&patch, &how).unwrap().mesh)
    });
    assert_eq!(results[0], results[1]);
}

#[test]
fn settings_without_sense_are_refused() {
    let patch = sheet(1, 1, false, |u, v| DVec3::new(9.0 * u, 9.0 * v, 0.0));
    let with = |change: fn(&mut Settings)| {
        let mut settings = settings(1.0, Side::Inner);
        change(&mut settings);
        run(&patch, &settings).unwrap_err()
    };
    use ThickenError as E;
    assert!(matches!(with(|s| s.thickness = 0.0), E::BadThickness(_)));
    assert!(matches!(with(|s| s.thickness = -1.0), E::BadThickness(_)));
    assert!(matches!(
        with(|s| s.thickness = f64::NAN),
        E::BadThickness(_)
    ));
    assert!(matches!(with(|s| s.cell = 0.5), E::CoarseCell { .. }));
    assert!(matches!(with(|s| s.cell = f64::NAN), E::BadCell(_)));
    assert!(matches!(with(|s| s.tolerance = 0.0), E::BadTolerance(_)));
    assert!(matches!(
        with(|s| s.memory_limit = 1000),
        E::Grid(GridError::TooFine(_))
    ));
    assert!(matches!(
        with(|s| s.cell = 1e-12),
        E::Grid(GridError::TooFine(_))
    ));
}

#[test]
fn surfaces_without_two_sides_are_refused() {
    let refuse = |patch: &TriMesh| run(patch, &settings(0.5, Side::Inner)).unwrap_err();
    use ThickenError as E;
    assert!(matches!(refuse(&TriMesh::default()), E::Empty));

    // A Moebius strip.
    let (n, m) = (16_u32, 2_u32);
    let mut strip = sheet(n as usize, m as usize, false, |u, v| {
        let (a, s) = (TAU * u, 2.0 * v - 1.0);
        let d = 5.0 + s * (a / 2.0).cos();
        DVec3::new(d * a.cos(), d * a.sin(), s * (a / 2.0).sin())
    });
    for v in strip.triangles.iter_mut().flatten() {
        if *v >= n * (m + 1) {
            *v = m - (*v - n * (m + 1));
        }
    }
    assert!(matches!(refuse(&strip), E::OneSided));

    let square = |triangles: &[[u32; 3]]| TriMesh {
        positions: [
            [0., 0., 0.],
            [4., 0., 0.],
            [4., 4., 0.],
            [0., 4., 0.],
            [2., 2., 3.],
        ]
        .map(DVec3::from)
        .to_vec(),
        triangles: triangles.to_vec(),
    };
    assert!(matches!(
        refuse(&square(&[[0, 1, 2], [0, 2, 3], [2, 0, 4]])),
        E::NotManifold { .. } | E::Sides(_)
    ));
    assert!(matches!(refuse(&square(&[[0, 1, 9]])), E::BadCorner(0)));
    assert!(matches!(refuse(&square(&[[0, 1, 1]])), E::Empty));
    let mut flat = square(&[[0, 1, 2], [0, 2, 3]]);
    flat.positions[3] = DVec3::new(2.0, 2.0, 0.0);
    assert!(matches!(refuse(&flat), E::NoArea { .. }));

    let mut crossing = sheet(2, 2, false, |u, v| DVec3::new(6.0 * u, 6.0 * v, 0.0));
    let first = crossing.positions.len() as u32;
    crossing
        .positions
        .extend([[1., 1., -2.], [2., 1., 2.], [1., 2., 2.]].map(DVec3::from));
    crossing.triangles.push([first, first + 1, first + 2]);
    assert!(matches!(refuse(&crossing), E::SelfIntersecting { .. }));
}

#[test]
fn surfaces_are_made_patches() {
    // One of two triangles turned over, and one that is none.
    let square = TriMesh {
        positions: [[0., 0., 0.], [4., 0., 0.], [4., 4., 0.], [0., 4., 0.]]
            .map(DVec3::from)
            .to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 2], [0, 1, 1]],
    };
    let result = run(&square, &settings(0.5, Side::Inner)).unwrap();
    let expected = [
        Repair::Dropped { triangles: 1 },
        Repair::Turned { triangles: 1 },
    ];
    assert_eq!(result.repairs, expected);
    assert!(result.is_sound() && result.missing.is_none(), "{result:?}");
    assert!((result.mesh.volume() / 8.0 - 1.0).abs() < 1e-6);

    // Two squares that touch in a corner.
    let mut bow = sheet(1, 1, false, |u, v| DVec3::new(3.0 * u, 3.0 * v, 0.0));
    let other = sheet(1, 1, false, |u, v| {
        DVec3::new(3.0 + 3.0 * u, 3.0 + 3.0 * v, 0.0)
    });
    let first = bow.positions.len() as u32;
    bow.positions.extend(&other.positions);
    let others = other.triangles.iter().map(|t| t.map(|v| v + first));
    bow.triangles.extend(others);
    let result = run(&bow, &settings(0.5, Side::Inner)).unwrap();
    assert_eq!(result.repairs, [Repair::Parted { vertices: 1 }]);
    assert!(result.is_sound() && result.missing.is_none(), "{result:?}");
    assert!(
        (result.mesh.volume() / 9.0 - 1.0).abs() < 0.02,
        "{}",
        result.mesh.volume()
    );
}

#[test]
fn arms_narrower_than_the_cell_are_not_lost() {
    // A flat plus of five squares of 3, far thicker than its arms are wide.
    let mut plus = TriMesh::default();
    for [x, y] in [[1, 0], [0, 1], [1, 1], [2, 1], [1, 2]] {
        let square = sheet(1, 1, false, |u, v| {
            DVec3::new(3.0 * (f64::from(x) + u), 3.0 * (f64::from(y) + v), 0.0)
        });
        let first = plus.positions.len() as u32;
        plus.positions.extend(&square.positions);
        plus.triangles
            .extend(square.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    let fitted = Settings::new(15.0, Side::Inner).fitted(&plus);
    let solid = run(&plus, &fitted).unwrap();
    assert!(
        solid.is_sound() && solid.missing.is_none(),
        "{:?}",
        solid.missing
    );
    assert!((solid.mesh.volume() / 675.0 - 1.0).abs() < 1e-3);
    assert!((solid.mesh.area() / 630.0 - 1.0).abs() < 1e-3);
    // What is lost where no finer cells fit is said.
    let coarse = Settings {
        cell: 7.0,
        memory_limit: 1600,
        ..Settings::new(15.0, Side::Inner)
    };
    match run(&plus, &coarse) {
        Ok(solid) => assert!(solid.is_sound() && !solid.missing.is_none(), "{solid:?}"),
        Err(error) => assert!(matches!(error, ThickenError::Unresolved { .. }), "{error}"),
    }
}

#[test]
fn lobed_patches_do_not_cut_themselves() {
    // Gently wavy, with a lobed outline: strips lean towards each other where it
    // is concave.
    let radius = |a: f64| 10.0 + 3.0 * (5.0 * a).cos() + 1.2 * (3.0 * a + 1.0).sin();
    let patch = sheet(30, 4, true, |u, v| {
        let a = TAU * u;
        let r = radius(a) * (0.2 + 0.8 * v);
        let (x, y) = (r * a.cos(), r * a.sin());
        DVec3::new(x, y, (0.5 * x).sin() + (0.4 * y).cos())
    });
    for side in SIDES {
        for thickness in [2.0, 3.0] {
            let result = run(&patch, &Settings::new(thickness, side)).unwrap();
            assert!(result.is_sound(), "{side:?} {thickness}");
            assert!(
                result.missing.is_none(),
                "{side:?} {thickness}: {:?}",
                result.missing
            );
            assert_eq!(self_intersections(&result.mesh), []);
            assert!(result.mesh.edges().census().is_closed());
        }
    }
}

#[test]
fn the_command_writes_a_solid_and_a_report() {
    let desk = Desk::new();
    let patch = fixture("patch_corners.obj");
    let out = desk.run(&[
        "thicken",
        patch.to_str().unwrap(),
        "--thickness",
        "2",
        "--side",
        "outer",
        "-o",
        "solid.stl",
        "--json",
        "-",
    ]);
    assert!(out.status.success(), "{}", text(&out.stderr));
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(report["result"]["self_intersections"], 0);
    assert_eq!(report["settings"]["side"], "outer");
    let solid = read_mesh(desk.path("solid.stl")).unwrap().mesh;
    assert_eq!(report["result"]["triangles"], solid.triangles.len());
    assert!(self_intersections(&solid).is_empty());

    let bad = desk.run(&["thicken", patch.to_str().unwrap(), "--thickness=-2"]);
    assert_eq!(bad.status.code(), Some(2));
    assert!(
        text(&bad.stderr).contains("--side"),
        "{}",
        text(&bad.stderr)
    );
}
