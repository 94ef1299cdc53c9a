//! Coping found by the program, against the tags that people gave.

use std::f64::consts::FRAC_PI_3;

use glam::{DQuat, DVec3};
use midsurf::coping::detect;
use midsurf::coping::detect::{Options, Verdict};
use midsurf::mesh::TriMesh;

use crate::common::{Desk, cuboid, fixture, fixture_part, inverted, join, obj_text, ringed, text};

/// Parts made from a drawing: every face is known.
const GENERATED: [&str; 24] = [
    "boss_gussets",
    "box_divider",
    "box_tube",
    "bracket",
    "cross",
    "cylinder_shell",
    "ell",
    "ell_bend",
    "enclosure",
    "hemisphere_shell",
    "ibeam",
    "open_box",
    "plate",
    "plate_holes",
    "plate_round_edge",
    "plate_tapered",
    "rib_grid",
    "slanted_45",
    "tee",
    "tee_filleted",
    "tee_rotated",
    "tee_thick_web",
    "tee_thin_web",
    "wavy_rib",
];

fn found(mesh: &TriMesh) -> Vec<bool> {
    detect(mesh, &Options::default()).flags
}

/// Recall and precision by area.
fn quality(mesh: &TriMesh, found: &[bool], truth: &[bool]) -> (f64, f64) {
    let area = |wanted: &dyn Fn(usize) -> bool| -> f64 {
        mesh.faces()
            .filter(|face| wanted(face.index()))
            .map(|face| mesh.triangle_area(face))
            .sum()
    };
    let both = area(&|i| found[i] && truth[i]);
    (both / area(&|i| truth[i]), both / area(&|i| found[i]))
}

#[test]
fn generated_parts_are_tagged_as_drawn() {
    for name in GENERATED {
        let (mesh, truth) = fixture_part(name);
        assert_eq!(found(&mesh), truth, "{name}");
    }
}

#[test]
fn the_leaning_face_of_a_hook_closes_its_wall() {
    let (mesh, truth) = fixture_part("faces/hook");
    assert_eq!(found(&mesh), truth);
}

/// The end face of a tab in one plane with the wall of the plate beside it.
#[test]
fn the_end_of_a_flush_tab_is_cut_from_the_wall_in_its_plane() {
    let (mesh, truth) = fixture_part("faces/flush_tab");
    assert_eq!(found(&mesh), truth);
}

/// A wall that ends half a millimetre before another, at a thickness of two: what is beyond
/// the gap is not its end going on.
#[test]
fn the_end_of_a_wall_before_another_is_coping() {
    let (mesh, coping) = fixture_part("placed/clip");
    assert_eq!(found(&mesh), coping);
}

/// A disc with a hole of eight chords, whose rim has a ring of vertices half way, turned by half a
/// chord: its triangles lean to and fro.
#[test]
fn the_rim_of_a_hole_of_few_free_triangles_is_coping() {
    const CHORDS: usize = 8;
    let rings = [
        (12.0, 0.0, 0.0),
        (12.0, 1.5, 0.0),
        (3.0, 1.5, 0.0),
        (3.0, 0.75, 0.5),
        (3.0, 0.0, 0.0),
    ];
    let mesh = ringed(&rings, CHORDS as u32);
    let truth: Vec<bool> = (0..mesh.triangles.len())
        .map(|t| matches!(t / (2 * CHORDS), 0 | 2 | 3))
        .collect();
    assert!(mesh.volume() > 0.0);
    assert_eq!(found(&mesh), truth);
}

#[test]
fn small_parts_are_looked_at_from_fewer_points() {
    let points = |name| detect(&fixture_part(name).0, &Options::default()).samples;
    assert!(points("wavy_rib") < 4100);
    assert!(points("enclosure") > 4400);
}

#[test]
fn a_heap_of_triangles_is_no_part() {
    // Far more than could each be held against all others in the time of a test.
    let heap = TriMesh {
        positions: (0..120_000)
            .map(|i| DVec3::new(f64::from(i % 3 == 1), f64::from(i % 3 == 2), 0.0))
            .collect(),
        triangles: (0..40_000).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    let detection = detect(&heap, &Options::default());
    assert_eq!(detection.verdict(), Verdict::Open);
    assert!(detection.questions().is_empty());
    assert!(detection.flags.iter().all(|&flag| !flag));
}

#[test]
fn a_real_case_is_tagged_nearly_as_people_did() {
    let (mesh, truth) = fixture_part("sensor_case");
    let (recall, precision) = quality(&mesh, &found(&mesh), &truth);
    assert!(recall >= 0.98 && precision >= 0.98, "{recall} {precision}");
}

#[test]
fn turning_scale_and_order_change_no_tag() {
    for name in ["tee_filleted", "plate_holes", "sensor_case", "open_box"] {
        let (mesh, _) = fixture_part(name);
        let expected = found(&mesh);
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), FRAC_PI_3);
        for scale in [1.0, 1e-3, 1e4] {
            let mut moved = mesh.clone();
            for p in &mut moved.positions {
                *p = scale * (turn * *p + DVec3::new(3.0, -7.0, 11.0));
            }
            assert_eq!(found(&moved), expected, "{name} at {scale}");
        }
        assert_eq!(found(&inverted(&mesh)), expected, "{name} inside out");
        // Every seventh triangle in turn, each begun at another corner.
        let count = mesh.triangles.len();
        let order: Vec<usize> = (0..7).flat_map(|k| (k..count).step_by(7)).collect();
        let mut shuffled = mesh.clone();
        for (new, &old) in order.iter().enumerate() {
            shuffled.triangles[new] = mesh.triangles[old];
            shuffled.triangles[new].rotate_left(new % 3);
        }
        let reordered: Vec<bool> = order.iter().map(|&old| expected[old]).collect();
        assert_eq!(found(&shuffled), reordered, "{name} in another order");
    }
}

/// Each triangle as four, by the middles of its edges, unwelded.
fn refined(mesh: &TriMesh) -> TriMesh {
    let mut fine = TriMesh::default();
    for face in mesh.faces() {
        let [a, b, c] = mesh.corners(face);
        let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let first = fine.positions.len() as u32;
            fine.positions.extend(corners);
            fine.triangles.push([first, first + 1, first + 2]);
        }
    }
    fine
}

#[test]
fn refinement_changes_no_tag() {
    for name in ["tee", "box_divider", "plate_holes", "rib_grid"] {
        let (mut mesh, mut expected) = fixture_part(name);
        for _ in 0..2 {
            mesh = refined(&mesh);
            expected = expected.iter().flat_map(|&flag| [flag; 4]).collect();
            assert_eq!(found(&mesh), expected, "{name}");
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let (mesh, _) = fixture_part("enclosure");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| detect(&mesh, &Options::default()))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
}

#[test]
fn what_has_no_thin_wall_is_said_in_words() {
    let size = |x, y, z| cuboid(DVec3::ZERO, DVec3::new(x, y, z));
    for (what, mesh) in [
        ("cube", size(10.0, 10.0, 10.0)),
        ("bar", size(4.0, 4.0, 60.0)),
    ] {
        let detection = detect(&mesh, &Options::default());
        assert!(detection.flags.iter().all(|&flag| !flag), "{what}");
        assert_eq!(detection.verdict(), Verdict::NoThinWall, "{what}");
    }
    // A closed box: no wall ends anywhere.
    let inner = cuboid(DVec3::splat(2.0), DVec3::new(36.0, 26.0, 16.0));
    let hollow = join(&size(40.0, 30.0, 20.0), &inverted(&inner));
    let detection = detect(&hollow, &Options::default());
    assert!(detection.flags.iter().all(|&flag| !flag));
    assert_eq!(detection.verdict(), Verdict::ClosedShell);

    let mut open = size(40.0, 30.0, 2.0);
    open.triangles.pop();
    assert_eq!(detect(&open, &Options::default()).verdict(), Verdict::Open);
}

#[test]
fn meshes_of_nothing_and_of_no_numbers_are_survived() {
    let empty = TriMesh::default();
    assert!(detect(&empty, &Options::default()).flags.is_empty());
    let point = TriMesh {
        positions: vec![DVec3::ONE; 3],
        triangles: vec![[0, 1, 2]],
    };
    assert_eq!(found(&point), [false]);
    let mut odd = cuboid(DVec3::ZERO, DVec3::ONE);
    odd.positions[3].x = f64::NAN;
    assert_eq!(found(&odd), [false; 12]);
}

#[test]
fn detected_tags_are_an_ordinary_file() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let part = part.to_str().unwrap();
    for file in ["tags.toml", "tags.txt"] {
        let output = desk.run(&["tags", "detect", part, "-o", file]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(text(&output.stdout).contains("10, 5 of them coping"));
        let shown = text(&desk.run(&["tags", part, file]).stdout);
        let total = shown.lines().find(|line| line.starts_with("all coping"));
        assert!(total.is_some_and(|line| line.contains(" 18 ")), "{shown}");
    }
    let quiet = desk.run(&["tags", "detect", part, "-q", "-j", "1", "-o", "quiet.txt"]);
    assert_eq!(
        (quiet.status.code(), quiet.stdout, quiet.stderr),
        (Some(0), vec![], vec![])
    );
    let read = |file: &str| std::fs::read(desk.path(file)).unwrap();
    assert_eq!(read("quiet.txt"), read("tags.txt"));
}

#[test]
fn a_part_without_tags_is_extracted_with_detected_ones() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let part = part.to_str().unwrap();
    let list = |more: &[&str]| {
        let output = desk.run(&[&["extract", part, "--list", "-q"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let expected = list(&["--coping", tags.to_str().unwrap()]);
    assert_eq!(list(&[]), expected);
    assert_eq!(list(&["--coping", "auto"]), expected);
    assert_ne!(list(&["--coping", "none"]), expected);
    let output = desk.run(&["extract", part, "--json", "-"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["coping"]["verdict"], "tagged");
    assert_eq!(report["coping"]["faces"].as_array().unwrap().len(), 10);
}

#[test]
fn rules_answer_and_the_program_does_the_rest() {
    let desk = Desk::new();
    let (mesh, truth) = fixture_part("tee");
    let part = desk.put("tee.obj", obj_text(&mesh));
    let first = truth.iter().position(|&flag| flag).unwrap();
    let tags = format!(
        "format = \"coping-tags\"\nversion = 1\nrest = \"auto\"\n[[wall]]\ntriangles = \"{first} # no rim\"\n"
    );
    desk.put("tags.toml", tags);
    let shown = text(
        &desk
            .run(&["tags", part.to_str().unwrap(), "tags.toml"])
            .stdout,
    );
    let total = shown.lines().find(|line| line.starts_with("all coping"));
    assert!(total.is_some_and(|line| line.contains(" 17 ")), "{shown}");
}

/// A plate 40 x 24 x 2 whose rim has a step of 0.004: the triangles of the
/// sides by number, two a side, then top and bottom.
fn stepped_plate() -> TriMesh {
    let outline = [
        (0.0, 0.0),
        (40.0, 0.0),
        (40.0, 12.0),
        (39.996, 12.0),
        (39.996, 24.0),
        (0.0, 24.0),
    ];
    let n = outline.len() as u32;
    let at = |z: f64| outline.map(|(x, y)| DVec3::new(x, y, z));
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
    }
    for i in 1..n - 1 {
        triangles.extend([[0, i + 1, i], [n, n + i, n + i + 1]]);
    }
    TriMesh {
        positions: [at(0.0), at(2.0)].concat(),
        triangles,
    }
}

#[test]
fn a_sliver_between_copings_is_adopted_and_named() {
    let desk = Desk::new();
    desk.put("plate.obj", obj_text(&stepped_plate()));
    // All sides but the step, triangles 4 and 5.
    desk.put("tags.txt", "0-3\n6-11\n");
    for tags in ["tags.txt", "auto"] {
        let args = ["extract", "plate.obj", "--coping", tags, "--json", "-"];
        let output = desk.run(&args);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["input"]["coping_triangles"], 12, "{stderr}");
        let area = report["result"]["area"].as_f64().unwrap();
        assert!((area - (960.0 - 0.048)).abs() < 0.01, "{area}");
        if tags == "tags.txt" {
            assert!(stderr.contains("triangles 4-5 "), "{stderr}");
        }
    }
    // A rule that says wall is obeyed.
    let tags = "format = \"coping-tags\"\nversion = 1\n[[coping]]\ntriangles = \"0-11\"\n[[wall]]\ntriangles = \"4-5\"\n";
    desk.put("kept.toml", tags);
    let shown = text(&desk.run(&["tags", "plate.obj", "kept.toml"]).stdout);
    let total = shown.lines().find(|line| line.starts_with("all coping"));
    assert!(total.is_some_and(|line| line.contains(" 10 ")), "{shown}");
}

#[test]
fn a_missed_tag_is_named_where_the_sheet_fades() {
    let desk = Desk::new();
    let mesh = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0));
    desk.put("plate.obj", obj_text(&mesh));
    // The sides but for the one at the right, triangles 10 and 11.
    desk.put("tags.txt", "4-9\n");
    let output = desk.run(&["extract", "plate.obj", "--coping", "tags.txt"]);
    let stderr = text(&output.stderr);
    assert!(
        stderr.contains("before triangles 10-11: they look like the end of a wall"),
        "{stderr}"
    );
    desk.put("all.txt", "4-11\n");
    let output = desk.run(&["extract", "plate.obj", "--coping", "all.txt"]);
    assert!(!text(&output.stderr).contains("look like the end"));
}

#[test]
fn every_face_is_explained() {
    let desk = Desk::new();
    let mesh = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0));
    desk.put("plate.obj", obj_text(&mesh));
    desk.put("tags.txt", "0-9\n");
    let output = desk.run(&["tags", "explain", "plate.obj", "tags.txt"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    let lines: Vec<&str> = words.lines().collect();
    assert_eq!(lines.len(), 6, "{words}");
    // The wrong ones come first: two walls tagged, one end missed.
    let wrong = |line: &&str| line.contains("; it looks like the ");
    assert!(
        lines[..3].iter().all(wrong) && !lines[3..].iter().any(wrong),
        "{words}"
    );
    assert!(words.contains("triangles 10-11"), "{words}");
}

#[test]
fn a_picture_shows_the_tags() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let part = part.to_str().unwrap();
    let output = desk.run(&["tags", "detect", part, "--picture", "tee.png"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let png = std::fs::read(desk.path("tee.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n"));
    let output = desk.run(&["tags", "detect", part, "--picture", "tee.jpg"]);
    assert_eq!(output.status.code(), Some(2));
}
