//! Offsets: closed forms, changes of topology, determinism, bad input, and the
//! commands.

use glam::DVec3;
use midsurf::mesh::{Part, PartOptions, TriMesh, self_intersections};
use midsurf::offset::GridError;
use midsurf::offset::{Offset, OffsetError, OffsetWarning, Settings, hollowed, offset};
use midsurf::settings::memory::TooFine;
use midsurf::settings::precision::Precision;
use serde_json::Value;

use crate::common::{Desk, cuboid, fixture, inverted, join, obj_text, text};

fn part(mesh: &TriMesh) -> Part {
    let flags = vec![false; mesh.triangles.len()];
    Part::new(mesh.clone(), flags, PartOptions::default())
        .unwrap()
        .0
}

fn settings(part: &Part, distance: f64, cell: f64) -> Settings {
    Settings {
        cell,
        ..Settings::new(part, distance)
    }
}

/// The offset of a mesh, checked for all that every offset promises.
fn run(mesh: &TriMesh, distance: f64, cell: f64) -> Offset {
    let part = part(mesh);
    let result = offset(&part, &settings(&part, distance, cell), &|_, _, _| ()).unwrap();
    check(&result.mesh);
    result
}

/// Closed, manifold, outward, without intersections.
fn check(mesh: &TriMesh) {
    let uses = mesh.edges();
    assert!(uses.by_edge().all(|uses| uses.len() == 2));
    assert!(uses.census().is_closed());
    assert!(mesh.volume() > 0.0);
    assert_eq!(self_intersections(mesh), []);
}

/// Number of pieces.
fn pieces(mesh: &TriMesh) -> usize {
    mesh.edges().components(mesh.triangles.len()).1
}

fn euler(mesh: &TriMesh) -> i64 {
    let edges = mesh.edges().by_edge().count();
    mesh.positions.len() as i64 - edges as i64 + mesh.triangles.len() as i64
}

/// Turned by two odd angles, so that nothing lies along the grid.
fn turned(mesh: &TriMesh) -> TriMesh {
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.37, 0.81, -0.55);
    TriMesh {
        positions: mesh.positions.iter().map(|&p| turn * p).collect(),
        triangles: mesh.triangles.clone(),
    }
}

/// Grid of quads that closes along both parameters.
fn torus(big: f64, small: f64, n: usize, m: usize) -> TriMesh {
    let mut mesh = TriMesh::default();
    for i in 0..n {
        for j in 0..m {
            let u = std::f64::consts::TAU * i as f64 / n as f64;
            let v = std::f64::consts::TAU * j as f64 / m as f64;
            let ring = big + small * v.cos();
            mesh.positions
                .push(DVec3::new(ring * u.cos(), ring * u.sin(), small * v.sin()));
            let at = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// A sphere as a subdivided octahedron.
fn sphere(radius: f64, levels: usize) -> TriMesh {
    let mut mesh = TriMesh {
        positions: vec![
            DVec3::X,
            DVec3::NEG_X,
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::NEG_Z,
        ],
        triangles: vec![
            [0, 2, 4],
            [2, 1, 4],
            [1, 3, 4],
            [3, 0, 4],
            [2, 0, 5],
            [1, 2, 5],
            [3, 1, 5],
            [0, 3, 5],
        ],
    };
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut triangles = Vec::new();
        for [a, b, c] in mesh.triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let p = mesh.positions[a as usize] + mesh.positions[b as usize];
                    mesh.positions.push(p.normalize());
                    mesh.positions.len() as u32 - 1
                })
            };
            let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
            triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        mesh.triangles = triangles;
    }
    mesh.positions.iter_mut().for_each(|p| *p *= radius);
    mesh
}

#[test]
fn a_shrunk_box_is_a_box() {
    let mesh = cuboid(DVec3::new(-3.0, 1.0, 2.0), DVec3::new(10.0, 7.0, 5.0));
    let shrunk = cuboid(DVec3::new(-2.0, 2.0, 3.0), DVec3::new(8.0, 5.0, 3.0));
    // Across the grid, an edge may pass through a cell without crossing its
    // edges; mending leaves next to nothing of that.
    for (mesh, shrunk, tolerance) in [
        (mesh.clone(), shrunk.clone(), 1e-9),
        (turned(&mesh), turned(&shrunk), 0.02),
    ] {
        let result = run(&mesh, -1.0, 0.61);
        let off = result.mesh.volume() - 8.0 * 5.0 * 3.0;
        assert!(off.abs() < 0.1 * f64::max(tolerance, 1e-6), "{off}");
        assert!(result.corner_deviation.max < 1e-9);
        assert!(result.centre_deviation.max < tolerance);
        // The eight corners are vertices.
        for corner in shrunk.positions {
            let near = result.mesh.positions.iter().map(|p| p.distance(corner));
            assert!(near.fold(f64::INFINITY, f64::min) < 1e-9, "{corner}");
        }
    }
}

#[test]
fn a_grown_box_has_rounds() {
    let size = DVec3::new(6.0, 4.0, 3.0);
    let r = 1.5;
    let result = run(&cuboid(DVec3::ZERO, size), r, 0.3);
    let pi = std::f64::consts::PI;
    let sides = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let edges = 4.0 * (size.x + size.y + size.z);
    let volume =
        size.element_product() + sides * r + edges * pi * r * r / 4.0 + 4.0 / 3.0 * pi * r.powi(3);
    let off = result.mesh.volume() / volume - 1.0;
    assert!(off.abs() < 2e-3, "{off}");
    assert!(
        result.corner_deviation.max < 1e-8,
        "{:?}",
        result.corner_deviation
    );
    assert!(
        result.centre_deviation.max < 3.0 * Settings::TOLERANCE * r,
        "{:?}",
        result.centre_deviation
    );
}

#[test]
fn a_sphere_and_a_torus_agree_with_the_closed_form() {
    let pi = std::f64::consts::PI;
    for r in [0.4, -0.4] {
        let ball = run(&sphere(2.0, 4), r, 0.2);
        let volume = 4.0 / 3.0 * pi * (2.0f64 + r).powi(3);
        // The facets of the input and of the result cut about 1 % off.
        let off = ball.mesh.volume() / volume - 1.0;
        assert!(off.abs() < 1.2e-2, "{r}: {off}");
        assert_eq!(euler(&ball.mesh), 2);

        let ring = run(&torus(3.0, 1.0, 72, 36), r, 0.2);
        let volume = 2.0 * pi * pi * 3.0 * (1.0f64 + r).powi(2);
        assert!((ring.mesh.volume() / volume - 1.0).abs() < 1.5e-2);
        assert_eq!(euler(&ring.mesh), 0);
    }
    // Grown over its hole, a torus is a ball to topology.
    assert_eq!(euler(&run(&torus(3.0, 1.0, 72, 36), 2.3, 0.3).mesh), 2);
}

#[test]
fn boxes_merge_and_necks_part() {
    let size = DVec3::splat(2.0);
    let two = join(
        &cuboid(DVec3::ZERO, size),
        &cuboid(DVec3::new(3.0, 0.3, 0.2), size),
    );
    assert_eq!(pieces(&run(&two, 0.4, 0.25).mesh), 2);
    let merged = run(&two, 0.7, 0.25).mesh;
    assert_eq!((pieces(&merged), euler(&merged)), (1, 2));

    // Two blocks of side 2 with a neck 0.4 wide between them.
    let bells = dumbbell();
    assert_eq!(pieces(&run(&bells, -0.1, 0.11).mesh), 1);
    let parted = run(&bells, -0.3, 0.11).mesh;
    assert_eq!((pieces(&parted), euler(&parted)), (2, 4));
    // Convex corners stay sharp as they shrink; where the neck was, the blocks
    // bulge between two arcs of radius 0.3 about its reflex edges.
    let (r, half): (f64, f64) = (0.3, 0.2);
    let arc = 0.5 * (half * (r * r - half * half).sqrt() + r * r * (half / r).asin());
    let bulge = 2.0 * (r * half - arc);
    let expected = 2.0 * 1.4 * (1.4 * 1.4 + bulge);
    assert!((parted.volume() - expected).abs() < 0.01);
}

/// Two cubes of side 2, joined by a bar of 2 x 0.4 x 2.
fn dumbbell() -> TriMesh {
    // Outline, counter-clockwise; each convex piece is a fan from its first corner.
    let outline = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 0.8],
        [4.0, 0.8],
        [4.0, 0.0],
        [6.0, 0.0],
        [6.0, 2.0],
        [4.0, 2.0],
        [4.0, 1.2],
        [2.0, 1.2],
        [2.0, 2.0],
        [0.0, 2.0],
    ];
    let fans: [&[u32]; 3] = [&[0, 1, 2, 9, 10, 11], &[2, 3, 8, 9], &[5, 6, 7, 8, 3, 4]];
    let n = outline.len() as u32;
    let at = |z: f64| outline.map(|[x, y]| DVec3::new(x, y, z));
    let mut mesh = TriMesh {
        positions: at(0.0).into_iter().chain(at(2.0)).collect(),
        triangles: Vec::new(),
    };
    for fan in fans {
        for pair in fan[1..].windows(2) {
            let [a, b, c] = [fan[0], pair[0], pair[1]];
            mesh.triangles.extend([[c, b, a], [a + n, b + n, c + n]]);
        }
    }
    for a in 0..n {
        let b = (a + 1) % n;
        mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
    }
    mesh
}

#[test]
fn close_sheets_at_odd_places_stay_apart() {
    // A slit narrower than a cell, and a plate thinner than one.
    for gap in [0.02, 0.11, 0.3] {
        let slab = DVec3::new(4.0, 4.0, 1.0);
        let two = join(
            &cuboid(DVec3::ZERO, slab),
            &cuboid(DVec3::new(0.1, 0.2, 1.4 + gap), slab),
        );
        let grown = run(&turned(&two), 0.2, 0.25).mesh;
        // A slit as wide as a cell is seen, a narrower one may be closed.
        assert!(pieces(&grown) == 2 || gap < 0.25, "{gap}");
        run(
            &turned(&cuboid(DVec3::ZERO, DVec3::new(4.0, 4.0, 0.4 + gap))),
            -0.2,
            0.25,
        );
    }
}

#[test]
fn small_offsets_keep_to_their_side() {
    // The bands of both offsets overlap where the distance is below a cell.
    let mesh = cuboid(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.0));
    for r in [0.05, -0.05] {
        let result = run(&mesh, r, 0.21);
        assert!(result.warnings.contains(&OffsetWarning::CoarseCell));
        let grown = (3.0 + 2.0 * r) * (2.0 + 2.0 * r) * (2.0 + 2.0 * r);
        assert!((result.mesh.volume() / grown - 1.0).abs() < 0.01);
        assert!((result.mesh.volume() - mesh.volume()).signum() == r.signum());
    }
}

#[test]
fn single_precision_is_kept() {
    let part = part(&turned(&torus(3.0, 1.0, 24, 12)));
    let settings = Settings {
        precision: Precision::Single,
        ..settings(&part, 0.5, 0.31)
    };
    let result = offset(&part, &settings, &|_, _, _| ()).unwrap();
    check(&result.mesh);
    for p in &result.mesh.positions {
        assert_eq!(p.as_vec3().as_dvec3(), *p);
    }
}

#[test]
fn slivers_change_nothing() {
    let clean = sphere(5.0, 3);
    let mut dirty = clean.clone();
    for i in (0..clean.triangles.len()).step_by(7) {
        // A vertex amid an edge of one triangle; a sliver closes the gap.
        let [a, b, c] = dirty.triangles[i];
        let m = dirty.positions.len() as u32;
        let middle = dirty.positions[a as usize].midpoint(dirty.positions[b as usize]);
        dirty.positions.push(middle);
        dirty.triangles[i] = [a, m, c];
        dirty.triangles.extend([[m, b, c], [m, a, b]]);
    }
    for distance in [0.8, -0.8] {
        let [clean, dirty] = [&clean, &dirty].map(|mesh| run(mesh, distance, 0.3));
        check(&dirty.mesh);
        let (a, b) = (clean.mesh.volume(), dirty.mesh.volume());
        assert!((a / b - 1.0).abs() < 1e-5, "{distance}: {a} {b}");
    }
}

#[test]
fn cutting_parts_are_made_one_solid() {
    let size = DVec3::splat(2.0);
    let two = join(
        &cuboid(DVec3::ZERO, size),
        &cuboid(DVec3::new(1.0, 0.7, 0.6), size),
    );
    let result = run(&two, 0.3, 0.2);
    assert!(matches!(result.warnings[..], [OffsetWarning::United { pairs }] if pairs > 0));
    assert_eq!((pieces(&result.mesh), euler(&result.mesh)), (1, 2));
    // Nothing of either box sticks out.
    let alone = run(&cuboid(DVec3::ZERO, size), 0.3, 0.2);
    assert!(result.mesh.volume() > alone.mesh.volume());
}

#[test]
fn nothing_left_is_said() {
    let part = part(&cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 1.0)));
    for distance in [-0.6, -3.0, -1e6] {
        let result = offset(&part, &settings(&part, distance, 0.3), &|_, _, _| ());
        assert!(matches!(result, Err(OffsetError::Empty(_))), "{distance}");
    }
}

#[test]
fn nonsense_is_refused() {
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    let part = part(&mesh);
    let good = settings(&part, 0.1, 0.1);
    let fails = |settings: Settings| offset(&part, &settings, &|_, _, _| ()).unwrap_err();
    for distance in [0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            fails(Settings { distance, ..good }),
            OffsetError::BadDistance(_)
        ));
    }
    for cell in [0.0, -1.0, f64::NAN] {
        assert!(matches!(
            fails(Settings { cell, ..good }),
            OffsetError::BadCell(_)
        ));
    }
    assert!(matches!(
        fails(Settings {
            tolerance: 0.0,
            ..good
        }),
        OffsetError::BadTolerance(_)
    ));
    let OffsetError::Grid(GridError::TooFine(TooFine { smallest, .. })) =
        fails(Settings { cell: 1e-5, ..good })
    else {
        panic!("no bound on memory");
    };
    assert!(smallest > 1e-5 && smallest < 0.1);
    let boundless = Settings {
        cell: 1e-7,
        memory_limit: u64::MAX,
        ..good
    };
    let error = fails(boundless);
    assert!(
        matches!(error, OffsetError::Grid(GridError::NoGrid { .. })),
        "{error}"
    );

    let mut open = mesh.clone();
    open.triangles.pop();
    let options = PartOptions {
        allow_open: true,
        ..PartOptions::default()
    };
    let open = Part::new(open, vec![false; 11], options).unwrap().0;
    assert!(matches!(
        offset(&open, &good, &|_, _, _| ()),
        Err(OffsetError::Open)
    ));
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let part = part(&turned(&cuboid(DVec3::ZERO, DVec3::new(5.0, 4.0, 3.0))));
    let settings = settings(&part, 0.7, 0.23);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| offset(&part, &settings, &|_, _, _| ()).unwrap().mesh)
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn a_hollowed_part_keeps_its_triangles() {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(6.0, 5.0, 4.0));
    let inner = run(&mesh, -1.0, 0.5).mesh;
    let shell = hollowed(&part(&mesh), &inner);
    assert_eq!(shell.triangles[..12], mesh.triangles[..]);
    assert_eq!(shell.positions[..8], mesh.positions[..]);
    assert!((shell.volume() - (120.0 - 24.0)).abs() < 1e-6);
    assert_eq!(self_intersections(&shell), []);
}

#[test]
fn real_parts_offset_both_ways() {
    for name in ["bracket", "enclosure"] {
        let mesh = midsurf::io::read_mesh(fixture(&format!("{name}.obj")))
            .unwrap()
            .mesh;
        let size = part(&mesh).bounds().size().max_element();
        let whole = part(&mesh);
        // What a wall gains or loses is its area times the distance, but for
        // edges; of the enclosure's walls a coarse cell loses some when shrunk.
        let share = |r: f64, cell: f64| {
            let volume = run(&mesh, r, cell).mesh.volume();
            (volume - mesh.volume()) / (whole.area() * r)
        };
        let grown = share(0.01 * size, size / 40.0);
        assert!((grown - 1.0).abs() < 0.05, "{name}: {grown}");
        let shrunk = share(-0.004 * size, size / 60.0);
        let most = if name == "bracket" { 1.05 } else { 1.5 };
        assert!((0.95..most).contains(&shrunk), "{name}: {shrunk}");
    }
}

#[test]
fn the_command_writes_and_reports() {
    let desk = Desk::new();
    let cube = desk.put(
        "cube.obj",
        obj_text(&cuboid(DVec3::ZERO, DVec3::splat(3.0))),
    );
    let out = desk.path("grown.stl");
    let output = desk.run(&[
        "offset",
        cube.to_str().unwrap(),
        "--distance",
        "0.5",
        "--cell",
        "0.3",
        "-o",
        out.to_str().unwrap(),
        "--json",
        "-",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let filters = &report["work"]["filters"];
    let left = |name: &str| filters[name].as_u64().unwrap();
    assert!(left("nodes") >= left("after_boxes"));
    assert!(left("after_boxes") >= left("after_signs"));
    assert!(left("after_signs") > left("valid"));
    assert!(report["work"]["crossings"]["by_splits"][0].as_u64() > Some(0));
    for stage in ["field", "band", "contour"] {
        assert!(report["seconds"][stage].as_f64().unwrap() >= 0.0);
    }
    // What was written is what was reported, and free of intersections as
    // written, in single precision.
    let written = midsurf::io::read_mesh(&out).unwrap().mesh;
    assert_eq!(
        written.triangles.len() as u64,
        report["result"]["triangles"].as_u64().unwrap()
    );
    assert_eq!(self_intersections(&written), []);

    let shell = desk.path("shell.ply");
    let output = desk.run(&[
        "hollow",
        cube.to_str().unwrap(),
        "--thickness",
        "0.5",
        "--cell",
        "0.3",
        "-o",
        shell.to_str().unwrap(),
        "-v",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("closest-point queries"));
    let volume = midsurf::io::read_mesh(&shell).unwrap().mesh.volume();
    assert!((volume - (27.0 - 8.0)).abs() < 1e-6);
}

#[test]
fn the_command_refuses_what_has_no_offset() {
    let desk = Desk::new();
    let cube = cuboid(DVec3::ZERO, DVec3::splat(3.0));
    let good = desk.put("cube.obj", obj_text(&cube));
    let mut open = cube.clone();
    open.triangles.pop();
    let open = desk.put("open.obj", obj_text(&open));
    let out = desk.path("out.stl");
    let cases: [(&std::path::Path, &[&str], i32, &str); 7] = [
        (&good, &["--distance", "0"], 2, "offset distance 0"),
        (&good, &["--distance=-2"], 4, "nothing is left"),
        (&good, &["--distance=1", "--cell=0"], 2, "positive"),
        (
            &good,
            &["--distance=1", "--cell=0.0001"],
            2,
            "the smallest cell that fits",
        ),
        (&good, &["--distance=1", "--cell=2t"], 2, "wall thicknesses"),
        (&good, &["--distance=x"], 2, "invalid"),
        (&open, &["--distance=1"], 2, "open"),
    ];
    for (part, args, code, says) in cases {
        let mut all = vec![
            "offset",
            part.to_str().unwrap(),
            "-o",
            out.to_str().unwrap(),
        ];
        all.extend(args);
        let output = desk.run(&all);
        let stderr = text(&output.stderr).replace("\n", " ").replace("│", "");
        let words: Vec<&str> = stderr.split_whitespace().collect();
        assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
        assert!(words.join(" ").contains(says), "{args:?}: {stderr}");
        assert!(!out.exists());
    }
}

#[test]
fn an_inverted_part_is_turned() {
    let mesh = inverted(&cuboid(DVec3::ZERO, DVec3::splat(2.0)));
    assert!(run(&mesh, 0.5, 0.3).mesh.volume() > 8.0);
}
