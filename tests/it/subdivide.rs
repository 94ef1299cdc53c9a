//! Hollow solids from control meshes: the command, and what a solid must be.

use std::path::Path;

use midsurf::io::{read_control, read_mesh};
use midsurf::mesh::{Part, PartOptions, self_intersections};
use midsurf::subdivide::{Boundary, Cage, HollowSolid, Level, Scheme, Settings, hollow_out};
use serde_json::Value;

use crate::common::{Desk, fixture, text};

/// Cages with the thickness of `fixtures/README.md` and whether that is free
/// of folds at level 1.
const CAGES: [(&str, f64, bool); 12] = [
    ("cube", 0.2, true),
    ("torus", 0.15, true),
    ("genus3", 0.12, true),
    ("valence_mix", 0.1, true),
    ("open_sheet", 0.15, true),
    ("open_curved", 0.25, true),
    ("open_hole", 0.15, true),
    ("flat_sheet", 0.3, true),
    ("flat_l", 0.3, true),
    ("degenerate", 0.15, false),
    ("spike", 0.25, false),
    ("head", 0.05, false),
];

fn cage_file(name: &str) -> String {
    let file = fixture("cages").join(format!("{name}.obj"));
    file.to_str().unwrap().to_owned()
}

fn cage(name: &str) -> Cage {
    let control = read_control(cage_file(name)).unwrap();
    Cage::new(control.positions, &control.faces).unwrap()
}

fn solid(name: &str, thickness: f64, level: u32, boundary: Boundary) -> HollowSolid {
    let settings = Settings {
        thickness,
        samples: 4,
        level: Level::Fixed(level),
        scheme: Scheme::Crust,
        boundary,
    };
    hollow_out(&cage(name), &settings, &|_| ()).unwrap()
}

#[test]
fn every_solid_is_closed_manifold_and_outward() {
    for (name, thickness, sound) in CAGES {
        for boundary in [Boundary::EdgeAndCorner, Boundary::EdgeOnly] {
            let solid = solid(name, thickness, 1, boundary);
            let mesh = &solid.hollow.mesh;
            let uses = mesh.edges();
            let census = uses.census();
            assert!(census.is_closed(), "{name}: {census:?}");
            assert_eq!(census.balanced + census.unbalanced, 0, "{name}: {census:?}");
            assert!(mesh.volume() > 0.0, "{name}");
            let euler = mesh.positions.len() as i64 - uses.by_edge().count() as i64
                + mesh.triangles.len() as i64;
            assert_eq!(euler, 2 * cage(name).euler(), "{name}");
            let clean = solid.folded.is_empty() && solid.intersections.is_empty();
            assert_eq!(clean, sound, "{name}: {}", solid.intersections.len());
            assert!(solid.crust_length[1] < 1.0 + 1e-13, "{name}: (4.1)");
        }
    }
}

#[test]
fn the_command_writes_what_it_says() {
    let desk = Desk::new();
    let cube = cage_file("cube");
    let args = [
        "subdivide",
        &cube,
        "--thickness",
        "0.2",
        "--samples",
        "6",
        "--levels",
        "1",
        "-o",
        "hollow.stl",
        "-o",
        "hollow.obj",
        "-o",
        "hollow.ply",
        "--json",
        "report.json",
        "-v",
    ];
    let output = desk.run(&args);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(
        stderr.contains("levels       1 (0 forced), 24 faces"),
        "{stderr}"
    );
    assert!(stderr.contains("folded       0 triangles"), "{stderr}");
    let report = std::fs::read_to_string(desk.path("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    let result = &report["result"];
    assert_eq!(result["levels"], 1);
    assert_eq!(result["forced_steps"], 0);
    // 26 vertices, 48 edges with 5 samples, 24 faces with 25: twice.
    assert_eq!(result["vertices"], 2 * (26 + 48 * 5 + 24 * 25));
    assert_eq!(result["triangles"], 2 * 24 * 36 * 2);
    assert_eq!(result["intersections"], 0);
    let number = |value: &Value| value.as_f64().unwrap();
    assert!((number(&result["epsilon"]) / 0.2 - 0.126).abs() < 0.001);
    assert!((number(&result["fold_free"]["thickness"]) - 0.467).abs() < 0.001);
    assert!((number(&result["thickness"]["max"]) - 0.2).abs() < 1e-15);
    for suffix in ["stl", "obj", "ply"] {
        let loaded = read_mesh(desk.path(&format!("hollow.{suffix}"))).unwrap();
        let (part, _) = Part::new(loaded.mesh, vec![false; 3456], PartOptions::default()).unwrap();
        assert!(part.is_closed(), "{suffix}");
        let volume = number(&result["volume"]);
        assert!((part.volume() / volume - 1.0).abs() < 1e-6, "{suffix}");
        assert!(self_intersections(part.mesh()).is_empty());
    }
    let ply = std::fs::read(desk.path("hollow.ply")).unwrap();
    let header = String::from_utf8_lossy(&ply[..400]);
    assert!(header.contains("property double nz\nproperty double thickness\nproperty uchar red\n"));
}

#[test]
fn folds_are_told_and_change_the_exit_code() {
    let desk = Desk::new();
    let spike = cage_file("spike");
    let args = [
        "subdivide",
        &spike,
        "--thickness",
        "0.15",
        "--levels",
        "1",
        "--json",
        "-",
    ];
    let output = desk.run(&args);
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["result"]["folded_triangles"], 204);
    assert_eq!(report["result"]["folded"].as_array().unwrap().len(), 204);
    let codes: Vec<&str> = report["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| warning["code"].as_str().unwrap())
        .collect();
    assert_eq!(codes, ["folds", "folded_triangles", "intersections"]);
    let direct = [&args[..], &["--scheme", "direct"]].concat();
    let report: Value = serde_json::from_slice(&desk.run(&direct).stdout).unwrap();
    assert_eq!(report["result"]["folded_triangles"], 78);
}

#[test]
fn a_tolerance_takes_a_level_or_tells_both_figures() {
    let desk = Desk::new();
    let cube = cage_file("cube");
    let args = [
        "subdivide",
        &cube,
        "--thickness",
        "0.2",
        "--tolerance",
        "0.03",
        "--json",
        "-",
    ];
    let report: Value = serde_json::from_slice(&desk.run(&args).stdout).unwrap();
    assert_eq!(report["result"]["levels"], 1);
    assert_eq!(report["levels_tried"].as_array().unwrap().len(), 2);
    let hopeless = [
        "subdivide",
        &cube,
        "--thickness",
        "0.45",
        "--tolerance",
        "0.02",
        "-o",
        "a.stl",
    ];
    let output = desk.run(&hopeless);
    let stderr = text(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    for words in [
        "no level is both within 0.02",
        "level 1 is short by 0.05",
        "folds beyond 0.4670",
    ] {
        assert!(stderr.contains(words), "{stderr}");
    }
    assert!(desk.files().is_empty());
}

#[test]
fn interpolation_is_one_sheet_through_the_control_vertices() {
    let desk = Desk::new();
    let cube = cage_file("cube");
    let args = [
        "subdivide",
        &cube,
        "--interpolate",
        "--samples",
        "4",
        "-o",
        "through.obj",
    ];
    let output = desk.run(&args);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mesh = read_mesh(desk.path("through.obj")).unwrap().mesh;
    assert!(mesh.edges().census().is_closed());
    for p in cage("cube").positions() {
        assert!(mesh.positions.iter().any(|q| p.distance(*q) < 1e-14));
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let desk = Desk::new();
    let file = cage_file("valence_mix");
    let run = |threads: &str| {
        let names = ["obj", "ply", "stl"].map(|suffix| format!("{threads}.{suffix}"));
        let mut args = vec![
            "subdivide",
            &file,
            "--thickness",
            "0.3",
            "-j",
            threads,
            "-q",
        ];
        names.iter().for_each(|name| args.extend(["-o", name]));
        args.extend(["--json", "-"]);
        let output = desk.run(&args);
        assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let files = names.map(|name| std::fs::read(desk.path(&name)).unwrap());
        (
            files,
            report["result"].clone(),
            report["levels_tried"].clone(),
        )
    };
    let one = run("1");
    assert!(run("2") == one && run("5") == one);
}

/// The command must end with code 2, say all of `words`, and write nothing.
fn refused(cage: &str, words: &[&str]) {
    let desk = Desk::new();
    let file = desk.put("bad.obj", cage);
    for target in ["out.stl", "out.ply"] {
        let args = ["subdivide", "bad.obj", "--thickness", "0.1", "-o", target];
        let output = desk.run(&args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        for word in words {
            assert!(stderr.contains(word), "no {word:?} in\n{stderr}");
        }
    }
    assert_eq!(desk.files(), [file]);
}

#[test]
fn bad_cages_are_named_by_line() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let with = |more: &str| format!("{square}{more}");
    refused(&with(""), &["bad.obj", "no faces"]);
    refused(
        &with("f 1 2 3 4\nf 1 2 9\n"),
        &["line 6", "vertex 9 does not exist"],
    );
    refused(&with("f 1 2\n"), &["line 5", "three corners"]);
    refused(
        &with("f 1 2 3 2\n"),
        &["bad.obj, line 5: face 0 has vertex 1 at two of its corners"],
    );
    refused(
        &with("v 5 5 5\nf 1 2 3 4\n"),
        &["line 5", "vertex 4 belongs to no face", "loose"],
    );
    refused(
        &with("v nan 5 5\nf 1 2 3 4 5\n"),
        &["line 5", "not a finite number"],
    );
    let wing = "v 0 0 1\nv 1 0 1\nv 0 0 2\nv 1 0 2\n";
    refused(
        &with(&format!("{wing}f 1 2 3 4\nf 2 1 5 6\nf 1 2 8 7\n")),
        &["line 11", "more than two faces: 0, 1, 2"],
    );
    refused(
        &with("v 0 0 1\nv 1 0 1\nf 1 2 3 4\nf 1 2 6 5\n"),
        &[
            "line 8",
            "faces 0 and 1",
            "same direction",
            "turn one of the two",
        ],
    );
    refused(
        &with("v -1 0 0\nv -1 -1 0\nv 0 -1 0\nf 1 2 3 4\nf 1 5 6 7\n"),
        &["line 9", "do not hang together by edges"],
    );
}

#[test]
fn bad_usage_is_refused() {
    let desk = Desk::new();
    let cube = cage_file("cube");
    for (args, words) in [
        (vec!["--thickness", "0"], "positive length"),
        (vec!["--thickness", "-1"], "positive length"),
        (vec!["--thickness", "nan"], "positive length"),
        (vec![], "--thickness"),
        (vec!["--thickness", "1", "--samples", "0"], "--samples"),
        (vec!["--thickness", "1", "--levels", "13"], "--levels"),
        (
            vec!["--thickness", "1", "--levels", "1", "--tolerance", "1"],
            "cannot be used with",
        ),
        (
            vec!["--thickness", "1", "--interpolate"],
            "cannot be used with",
        ),
        (
            vec!["--thickness", "1", "-o", "a.vtu"],
            "known output format",
        ),
        (
            vec!["--thickness", "1", "-o", "a.stl", "--json", "a.stl"],
            "named twice",
        ),
    ] {
        let output = desk.run(&[&["subdivide", cube.as_str()], &args[..]].concat());
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        assert!(stderr.contains(words), "{args:?}: {stderr}");
    }
    let stl = fixture("tee.stl");
    let output = desk.run(&["subdivide", stl.to_str().unwrap(), "--thickness", "1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("OBJ alone"));
    assert!(desk.files().is_empty());
}

#[test]
fn an_inside_out_cage_is_turned() {
    let desk = Desk::new();
    let cube = std::fs::read_to_string(cage_file("cube")).unwrap();
    let turned: String = cube
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let back: Vec<&str> = corners.split(' ').rev().collect();
                format!("f {}\n", back.join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    desk.put("turned.obj", turned);
    let output = desk.run(&[
        "subdivide",
        "turned.obj",
        "--thickness",
        "0.2",
        "--json",
        "-",
    ]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("inside out"));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let thickness = report["result"]["thickness"]["min"].as_f64().unwrap();
    assert!((thickness - 0.1747872).abs() < 1e-6);
}

#[test]
fn readers_of_parts_still_take_what_control_meshes_are() {
    for (name, _, _) in CAGES {
        let file = cage_file(name);
        let control = read_control(&file).unwrap();
        let mesh = read_mesh(Path::new(&file)).unwrap();
        let triangles: usize = control.faces.iter().map(|face| face.len() - 2).sum();
        assert_eq!(mesh.mesh.triangles.len(), triangles, "{name}");
        assert_eq!(mesh.sha256, control.sha256);
    }
}

#[test]
fn a_contoured_wall_where_the_crust_folds() {
    let desk = Desk::new();
    let control = cage_file("spike");
    let solid = desk.path("solid.stl");
    let output = desk.run(&[
        "subdivide",
        &control,
        "--thickness",
        "0.25",
        "--scheme",
        "contour",
        "--cell",
        "0.1",
        "-o",
        solid.to_str().unwrap(),
        "--json",
        "-",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["result"]["intersections"], 0);
    let written = read_mesh(&solid).unwrap().mesh;
    assert!(written.volume() > 0.0);

    let open = cage_file("open_sheet");
    let args = [
        "subdivide",
        &open,
        "--thickness",
        "0.15",
        "--scheme",
        "contour",
        "-o",
        "open.obj",
    ];
    let output = desk.run(&args);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let written = read_mesh(desk.path("open.obj")).unwrap().mesh;
    assert!(written.edges().census().is_closed() && written.volume() > 0.0);
}

/// A cube of side 2 with tags after it.
fn tagged(tags: &str) -> String {
    std::fs::read_to_string(cage_file("cube")).unwrap() + tags
}

#[test]
fn tags_of_the_file_shape_the_solid() {
    let desk = Desk::new();
    let sides = [
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 7],
        [2, 6],
        [3, 5],
    ];
    let crease = |sharp: f64| -> String {
        let tag = |[a, b]: &[u32; 2]| format!("t crease 2/1/0 {a} {b} {sharp}\n");
        sides.iter().map(tag).collect()
    };
    let volume = |tags: &str, level: u32| {
        desk.put("cube.obj", tagged(tags));
        let args = ["subdivide", "cube.obj", "--thickness", "0.2", "--json", "-"];
        let output = desk.run(&args);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{tags}: {}",
            text(&output.stderr)
        );
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            report["warnings"].as_array().unwrap().len(),
            usize::from(level > 1)
        );
        assert_eq!(report["result"]["levels"], level);
        report["result"]["volume"].as_f64().unwrap()
    };
    let sharp = volume(&crease(10.0), 1);
    assert!((sharp - 8.0 + 1.6_f64.powi(3)).abs() < 1e-12, "{sharp}");
    // The sharper, the nearer to the cube: volumes between the two ends.
    let [smooth, one, two] = [
        volume("", 1),
        volume(&crease(0.5), 1),
        volume(&crease(1.5), 2),
    ];
    assert!(
        smooth < one && one < two && two < sharp,
        "{smooth} {one} {two} {sharp}"
    );
    // All vertices sharp for ever, without a crease, stay where they are.
    let corners: String = (0..8).map(|v| format!("t corner 1/1/0 {v} 10\n")).collect();
    let spiked = volume(&corners, 1);
    assert!(smooth < spiked && spiked < sharp, "{spiked}");
    let hole = volume("t hole 1/0/0 0\n", 1);
    assert!(hole < smooth);
}

#[test]
fn bad_tags_are_named_by_line() {
    for (tag, words) in [
        (
            "t crease 2/1/0 0 2 1",
            "the edge between vertices 0 and 2, which no face has",
        ),
        (
            "t crease 2/1/0 0 1",
            "the counts promise 3 arguments, and 2 follow",
        ),
        ("t crease 3/1/0 0 1 2 1", "two vertices of each edge"),
        ("t crease 2/1/0 0 -1 1", "\"-1\" is not a vertex index"),
        ("t crease 2/1/0 0 1 inf", "not a finite number"),
        ("t corner 1/1/0 8 1", "names vertex 8, which does not exist"),
        ("t corner 2/3/0 1 2 1 1 1", "one sharpness, or one for each"),
        ("t hole 1/0/0 6", "names face 6, which does not exist"),
        ("t interpolateboundary 1/0/0 3", "is 0, 1 or 2"),
        ("t crease", "a tag needs a name and counts"),
        ("t crease many 0 1", "no counts as in 2/1/0"),
    ] {
        let line = tagged("").lines().count() + 1;
        refused(
            &tagged(&format!("{tag}\n")),
            &[&format!("line {line}"), words],
        );
    }
    refused(
        &tagged("t hole 6/0/0 0 1 2 3 4 5\n"),
        &["all faces are holes"],
    );
}

#[test]
fn the_boundary_tag_counts_unless_a_flag_says_otherwise() {
    let desk = Desk::new();
    let sheet = std::fs::read_to_string(cage_file("open_sheet")).unwrap();
    let rule = |tag: &str, flags: &[&str]| {
        desk.put("sheet.obj", format!("{sheet}{tag}"));
        let args = [
            &[
                "subdivide",
                "sheet.obj",
                "--thickness",
                "0.1",
                "--json",
                "-",
            ],
            flags,
        ]
        .concat();
        let report: Value = serde_json::from_slice(&desk.run(&args).stdout).unwrap();
        (
            report["settings"]["boundary"].clone(),
            report["result"]["shell_triangles"].as_u64().unwrap(),
        )
    };
    let (name, all) = rule("", &[]);
    assert_eq!(name, "corner");
    assert_eq!(rule("t interpolateboundary 1/0/0 2\n", &[]).0, "edge");
    let (name, inner) = rule("t interpolateboundary 1/0/0 0\n", &[]);
    assert_eq!(name, "none");
    assert!(inner < all);
    let flag = ["--boundary", "corner"];
    assert_eq!(rule("t interpolateboundary 1/0/0 0\n", &flag).1, all);
}

#[test]
fn groups_have_their_own_thickness() {
    let desk = Desk::new();
    // Two squares of a plane, each a group.
    let plane = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\ng left\nf 1 2 5 4\ng right\nf 2 3 6 5\n";
    desk.put("plane.obj", plane);
    let thickness = |flags: &[&str]| {
        let args = [
            &[
                "subdivide",
                "plane.obj",
                "--thickness",
                "0.1",
                "--levels",
                "0",
                "--json",
                "-",
            ],
            flags,
        ]
        .concat();
        let output = desk.run(&args);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let of = |name: &str| report["result"]["thickness"][name].as_f64().unwrap();
        [of("min"), of("mean"), of("max")]
    };
    for scheme in ["crust", "direct"] {
        let [least, mean, most] = thickness(&["--group", "right=0.3", "--scheme", scheme]);
        assert!(
            (least - 0.1).abs() < 1e-12 && (most - 0.3).abs() < 1e-12,
            "{scheme}"
        );
        assert!((mean - 0.2).abs() < 1e-12, "{scheme}: {mean}");
    }
    let wrong = [
        "subdivide",
        "plane.obj",
        "--thickness",
        "0.1",
        "--group",
        "top=1",
        "-o",
        "a.stl",
    ];
    desk.refuses_command(&wrong, &["no group named top", "it names left, right"]);
    let contour = ["--group", "left=0.2", "--scheme", "contour", "-o", "a.stl"];
    let args = [
        &["subdivide", "plane.obj", "--thickness", "0.1"],
        &contour[..],
    ]
    .concat();
    desk.refuses_command(&args, &["one thickness all over"]);
}
