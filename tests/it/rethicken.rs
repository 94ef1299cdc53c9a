//! Mid-surfaces back to solids, through the library and the command.

use glam::DVec3;
use midsurf::CellSize;
use midsurf::extract::{Settings as ExtractSettings, extract};
use midsurf::io::write::{SurfaceFormat, SurfaceOptions, write_surface};
use midsurf::io::{RadiusSource, read_mesh, read_surface};
use midsurf::mesh::{EdgeUses, Part, PartOptions, TriMesh, self_intersections};
use midsurf::rethicken::{BallSurface, Settings, rethicken};
use midsurf::roundtrip::{self, Comparison};
use midsurf::surface::{
    Ball, Border, BorderKind, MidSurface, MidTriangle, MidVertex, SurfaceParts, VertexKind,
};
use serde_json::Value;
use smallvec::SmallVec;

use crate::common::{Desk, fixture, fixture_part, obj_text, small_box, text};

fn part(name: &str) -> Part {
    let (mesh, flags) = fixture_part(name);
    Part::new(mesh, flags, PartOptions::default()).unwrap().0
}

/// Round trip of a fixture; cells over the thickness.
fn roundtrip(name: &str, cell: f64, solid_cell: f64) -> Comparison {
    let settings = roundtrip::Settings {
        extract: ExtractSettings {
            cell: CellSize::Thicknesses(cell),
            ..ExtractSettings::default()
        },
        solid_cell: CellSize::Length(solid_cell),
        memory_limit: 1 << 30,
    };
    let result = roundtrip::roundtrip(&part(name), &settings, &|_, _, _| ()).unwrap();
    let c = result.comparison;
    assert_eq!(c.self_intersections, 0, "{name}");
    assert!(c.closed, "{name}");
    c
}

/// Bounds on a round trip, distances over the thickness.
struct Bars {
    volume: f64,
    mean: f64,
    hausdorff: f64,
}

/// What a round trip of any part has to reach.
const BARS: Bars = Bars {
    volume: 0.01,
    mean: 0.01,
    hausdorff: 0.1,
};

fn check(name: &str, c: &Comparison, bars: &Bars) {
    let t = c.thickness;
    assert!((c.volume_ratio - 1.0).abs() <= bars.volume, "{name}: {c:?}");
    assert!(c.away.mean <= bars.mean * t, "{name}: {c:?}");
    assert!(c.away.hausdorff <= bars.hausdorff * t, "{name}: {c:?}");
}

#[test]
fn plates_come_back() {
    for name in ["plate", "plate_tapered"] {
        let c = roundtrip(name, 2.0, 1.7);
        check(
            name,
            &c,
            &Bars {
                volume: 1e-5,
                mean: 1e-5,
                hausdorff: 1e-3,
            },
        );
        assert_eq!(c.pruned_area, 0.0);
        assert!(c.iou > 0.9999, "{name}: {c:?}");
    }
}

#[test]
fn junctions_and_bends_come_back() {
    for name in ["tee", "tee_thin_web", "ell_bend", "plate_round_edge"] {
        let c = roundtrip(name, 0.5, 0.9);
        check(name, &c, &BARS);
    }
}

#[test]
fn ribs_and_a_printed_case_come_back() {
    // Below the end of a rib a weak fin is left out, beside a coping face.
    for name in ["boss_gussets", "wavy_rib", "sensor_case"] {
        let c = roundtrip(name, 1.0 / 3.0, 0.6);
        check(name, &c, &BARS);
    }
}

#[test]
fn a_pruned_corner_is_told_apart() {
    let c = roundtrip("ell", 0.5, 0.9);
    check("ell", &c, &BARS);
    // The ball at the end of the fin: (sqrt 2 - 1) r, r = 0.586 t.
    assert!(
        (c.all.hausdorff / c.thickness - 0.2426).abs() < 0.01,
        "{c:?}"
    );
    assert!(c.pruned_area > 0.01 && c.pruned_area < 0.03, "{c:?}");
}

#[test]
fn the_solid_does_not_depend_on_threads_or_files() {
    let result = extract(&part("tee"), &ExtractSettings::default(), &|_, _, _| ()).unwrap();
    let surface = BallSurface::of(&result.surface).unwrap();
    let settings = Settings {
        cell: 1.1,
        ..Settings::new(&surface)
    };
    let solid = || rethicken(&surface, &settings, &|_, _, _| ()).unwrap().mesh;
    let first = solid();
    assert!(EdgeUses::new(&first).census().is_closed());
    assert!(self_intersections(&first).is_empty());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(solid), first);

    let desk = Desk::new();
    let mut bytes = Vec::new();
    write_surface(
        &result.surface,
        SurfaceFormat::Ply,
        SurfaceOptions::default(),
        &mut bytes,
    )
    .unwrap();
    let loaded = read_surface(&desk.put("mid.ply", bytes), None).unwrap();
    assert!(loaded.kinds && matches!(loaded.radius, RadiusSource::Radius(_)));
    let again = BallSurface::of(&loaded.surface).unwrap();
    let solid = rethicken(&again, &settings, &|_, _, _| ()).unwrap();
    assert_eq!(solid.mesh, first);

    // All that a PLY holds comes back.
    let (was, is) = (&result.surface, &loaded.surface);
    assert_eq!(is.triangles(), was.triangles());
    assert_eq!(is.seams(), was.seams());
    assert_eq!(is.borders(), was.borders());
    assert_eq!(is.junctions(), was.junctions());
    for (v, w) in is.vertices().iter().zip(was.vertices()) {
        assert_eq!((v.position, v.kind), (w.position, w.kind));
        assert_eq!(
            (v.ball.radius, v.ball.thickness),
            (w.ball.radius, w.ball.thickness)
        );
    }
}

#[test]
fn a_ply_tells_borders_by_edge() {
    // One edge fades between two corners that belong to coping borders.
    let vertex = |x: f64, y: f64| MidVertex {
        position: DVec3::new(x, y, 0.0),
        kind: VertexKind::CopingBorder,
        ball: Ball {
            radius: 1.0,
            thickness: 2.0,
            footpoints: SmallVec::new(),
        },
    };
    let border = |path: &[u32], kind| Border {
        path: path.to_vec(),
        sheet: 0,
        kind,
        closed: false,
    };
    let surface = MidSurface::new(SurfaceParts {
        vertices: vec![vertex(0.0, 0.0), vertex(9.0, 0.0), vertex(0.0, 9.0)],
        triangles: vec![MidTriangle {
            corners: [0, 1, 2],
            sheet: 0,
        }],
        borders: vec![
            border(&[0, 1], BorderKind::Fading),
            border(&[1, 2, 0], BorderKind::Coping),
        ],
        ..SurfaceParts::default()
    })
    .unwrap();
    let mut bytes = Vec::new();
    write_surface(
        &surface,
        SurfaceFormat::Ply,
        SurfaceOptions::default(),
        &mut bytes,
    )
    .unwrap();
    let desk = Desk::new();
    let file = desk.put("mid.ply", bytes);
    let flat = |round| {
        let loaded = read_surface(&file, None).unwrap();
        assert!(loaded.kinds);
        let surface = BallSurface::of(&loaded.surface).unwrap();
        if round { surface.rounded() } else { surface }.flat_edges()
    };
    assert_eq!(BallSurface::of(&surface).unwrap().flat_edges(), 2);
    assert_eq!([flat(false), flat(true)], [2, 0]);
}

/// Runs the command; its report and stderr.
fn report(desk: &Desk, args: &[&str]) -> (Value, String) {
    let output = desk.run(args);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {stderr}");
    (serde_json::from_slice(&output.stdout).unwrap(), stderr)
}

fn extracted(desk: &Desk, name: &str, output: &str) {
    let (obj, tags) = (
        fixture(&format!("{name}.obj")),
        fixture(&format!("{name}.coping.txt")),
    );
    let args = [obj.to_str().unwrap(), "--coping", tags.to_str().unwrap()];
    let run = desk.run(
        &[
            &["extract"],
            &args[..],
            &["--cell", "1t", "-q", "-o", output],
        ]
        .concat(),
    );
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
}

#[test]
fn files_in_files_out() {
    let desk = Desk::new();
    extracted(&desk, "plate", "mid.ply");
    extracted(&desk, "plate", "mid.obj");
    for (mid, solid, warned) in [("mid.ply", "a.obj", false), ("mid.obj", "b.stl", true)] {
        let args = [
            "rethicken",
            mid,
            "--cell",
            "1.3",
            "-o",
            solid,
            "--json",
            "-",
        ];
        let (report, stderr) = report(&desk, &args);
        let volume = report["result"]["volume"].as_f64().unwrap();
        assert!((volume - 4800.0).abs() < 0.01, "{volume}");
        assert_eq!(stderr.contains("coping from fading"), warned, "{stderr}");
        let mesh = read_mesh(desk.path(solid)).unwrap().mesh;
        assert!((mesh.volume() - 4800.0).abs() < 0.01);
    }
    // Round borders add a ring of radius 1.
    let args = [
        "rethicken",
        "mid.obj",
        "--cell",
        "1",
        "--round-borders",
        "--json",
        "-",
        "-q",
    ];
    let volume = report(&desk, &args).0["result"]["volume"].as_f64().unwrap();
    let round = 100.0 * std::f64::consts::PI + 4.0 / 3.0 * std::f64::consts::PI;
    assert!((volume - 4800.0 - round).abs() < 0.05 * round, "{volume}");
}

#[test]
fn a_round_trip_writes_what_it_saw() {
    let desk = Desk::new();
    let (obj, tags) = (fixture("ell.obj"), fixture("ell.coping.txt"));
    let args = [
        "roundtrip",
        obj.to_str().unwrap(),
        "--coping",
        tags.to_str().unwrap(),
        "--cell",
        "1t",
        "--solid-cell",
        "1",
        "-o",
        "deviation.ply",
        "--solid",
        "solid.stl",
        "--json",
        "-",
    ];
    let (report, stderr) = report(&desk, &args);
    let comparison = &report["comparison"];
    assert!((comparison["volume_ratio"].as_f64().unwrap() - 1.0).abs() < 0.01);
    assert_eq!(comparison["self_intersections"], 0);
    assert!(stderr.contains("away from pruned corners"), "{stderr}");
    let painted = read_mesh(desk.path("deviation.ply")).unwrap().mesh;
    let solid = read_mesh(desk.path("solid.stl")).unwrap().mesh;
    let whole = read_mesh(&obj).unwrap().mesh;
    assert!((painted.area() / whole.area() - 1.0).abs() < 1e-12);
    assert!((solid.volume() / whole.volume() - 1.0).abs() < 0.01);
}

/// The command must end with code 2 and say all of `words`.
fn refuses(desk: &Desk, args: &[&str], words: &[&str]) {
    let before = desk.files();
    let output = desk.run(&[&["rethicken"], args, &["-o", "solid.stl"]].concat());
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{args:?}: no {word:?} in\n{stderr}");
    }
    assert_eq!(desk.files(), before);
}

#[test]
fn bad_thickness_is_refused() {
    let desk = Desk::new();
    let mesh = TriMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
    };
    desk.put("mid.obj", obj_text(&mesh));
    refuses(&desk, &["mid.obj"], &["no thickness", "mid.thickness.csv"]);
    for (table, words) in [
        ("", ["empty", "line 1"]),
        ("a,b\n0,1\n", ["vertex_index", "line 1"]),
        ("vertex_index,width\n0,1\n", ["`thickness`", "line 1"]),
        (
            "vertex_index,thickness\n0,1\n1,1\n",
            ["vertex 2 is missing", "line 3"],
        ),
        (
            "vertex_index,thickness\n0,1\n1,1\n7,1\n",
            ["vertex 7 does not exist", "line 4"],
        ),
        (
            "vertex_index,thickness\n0,1\n0,1\n2,1\n",
            ["twice", "line 3"],
        ),
        (
            "vertex_index,thickness\n0,1\n1,x\n2,1\n",
            ["not a number", "line 3"],
        ),
        (
            "vertex_index,radius\n0,1\n1,-2\n2,1\n",
            ["radius -2 of vertex 1", "1 such"],
        ),
        (
            "vertex_index,radius\n0,1\n1,NaN\n2,inf\n",
            ["radius NaN of vertex 1", "2 such"],
        ),
        (
            "vertex_index,radius\n0,0\n1,0\n2,0\n",
            ["zero everywhere", "mid.thickness.csv"],
        ),
    ] {
        desk.put("mid.thickness.csv", table);
        refuses(&desk, &["mid.obj"], &words);
    }
    desk.put(
        "mid.thickness.csv",
        "vertex_index,thickness\n0,1\n1,1\n2,1\n",
    );
    refuses(&desk, &["mid.obj", "--cell", "1e-9"], &["smallest cell"]);
    refuses(
        &desk,
        &["mid.obj", "--cell", "0.001", "--memory-limit", "1M"],
        &["smallest cell"],
    );
    refuses(
        &desk,
        &["mid.obj", "--thickness", "none.csv"],
        &["none.csv", "cannot be read"],
    );
    // A solid is no mid-surface: it has no thickness.
    desk.put("box.obj", obj_text(&small_box()));
    refuses(&desk, &["box.obj"], &["no thickness"]);
    refuses(&desk, &["none.ply"], &["none.ply"]);
}

#[test]
fn a_ply_with_a_bad_radius_is_refused() {
    let desk = Desk::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
         property double z\nproperty double radius\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n";
    desk.put(
        "mid.ply",
        format!("{header}0 0 0 1\n1 0 0 -1\n0 1 0 1\n3 0 1 2\n"),
    );
    refuses(&desk, &["mid.ply"], &["radius -1 of vertex 1"]);
    desk.put(
        "mid.ply",
        format!("{header}0 0 0 1\n1 0 0 nan\n0 1 0 1\n3 0 1 2\n"),
    );
    refuses(&desk, &["mid.ply"], &["not a finite number"]);
    // A thickness of twice as much is none.
    desk.put(
        "mid.ply",
        format!("{header}0 0 0 1\n1 0 0 1e308\n0 1 0 1\n3 0 1 2\n"),
    );
    refuses(&desk, &["mid.ply"], &["of vertex 1"]);
}

/// A plate with a rib of another thickness: three triangles at an edge.
fn ribbed() -> TriMesh {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    TriMesh {
        positions: vec![
            at(-10.0, 0.0, 0.0),
            at(0.0, 0.0, 0.0),
            at(10.0, 0.0, 0.0),
            at(-10.0, 8.0, 0.0),
            at(0.0, 8.0, 0.0),
            at(10.0, 8.0, 0.0),
            at(0.0, 0.0, 9.0),
            at(0.0, 8.0, 9.0),
        ],
        triangles: vec![
            [0, 1, 4],
            [0, 4, 3],
            [1, 2, 5],
            [1, 5, 4],
            [1, 4, 7],
            [1, 7, 6],
        ],
    }
}

#[test]
fn any_shell_becomes_a_solid() {
    for (rib, plate) in [(2.0, 2.0), (3.0, 2.0), (1.0, 2.0)] {
        let thickness = [plate, plate, plate, plate, rib, rib];
        let surface = BallSurface::of_shell(&ribbed(), &thickness).unwrap();
        let settings = Settings {
            cell: 0.21,
            ..Settings::new(&surface)
        };
        let mesh = rethicken(&surface, &settings, &|_, _, _| ()).unwrap().mesh;
        assert_eq!(self_intersections(&mesh), []);
        assert!(mesh.edges().census().is_closed());
        let volume = 20.0 * 8.0 * plate + (9.0 - 0.5 * plate) * 8.0 * rib;
        let ratio = mesh.volume() / volume;
        assert!((ratio - 1.0).abs() < 2e-3, "{rib}, {plate}: {ratio}");
    }
}

#[test]
fn the_command_takes_a_thickness_by_group() {
    let desk = Desk::new();
    let mut words = obj_text(&ribbed());
    let rib = words.match_indices("f ").nth(4).unwrap().0;
    words.insert_str(rib, "g rib\n");
    words.insert_str(words.find("f ").unwrap(), "g plate\n");
    desk.put("shell.obj", &words);
    let args = [
        "rethicken",
        "shell.obj",
        "--thickness",
        "2",
        "--cell",
        "0.4",
    ];
    let out = desk.run(&[&args[..], &["--group", "rib=3", "-o", "solid.stl"]].concat());
    assert!(out.status.success(), "{}", text(&out.stderr));
    let solid = read_mesh(desk.path("solid.stl")).unwrap().mesh;
    assert!((solid.volume() / (320.0 + 8.0 * 8.0 * 3.0) - 1.0).abs() < 5e-3);
    let out = desk.run(&[&args[..], &["--group", "ribs=3"]].concat());
    assert_eq!(out.status.code(), Some(2));
    assert!(
        text(&out.stderr).contains("plate, rib"),
        "{}",
        text(&out.stderr)
    );
    let out = desk.run(&["rethicken", "shell.obj", "--group", "rib=3"]);
    assert_eq!(out.status.code(), Some(2));
}
