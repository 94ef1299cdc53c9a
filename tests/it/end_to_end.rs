//! The command from part to files, on the fixtures and their facts.

use std::collections::BTreeSet;

use glam::DVec3;
use midsurf::io::read_mesh;
use serde_json::Value;

use crate::common::{Desk, cuboid, fixture, inverted, obj_text, text};

/// Facts of a fixture's ideal mid-surface, from `fixtures/README.md`.
#[derive(Debug)]
struct Facts {
    sheets: u64,
    seams: u64,
    junctions: u64,
    borders: u64,
    euler: i64,
    area: f64,
}

fn facts(name: &str) -> Facts {
    let readme = std::fs::read_to_string(fixture("README.md")).unwrap();
    let row = readme
        .lines()
        .find(|line| line.starts_with(&format!("| {name} |")))
        .unwrap();
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let number = |column: usize| cells[column].parse::<f64>().unwrap();
    Facts {
        sheets: number(7) as u64,
        seams: number(8) as u64,
        junctions: number(9) as u64,
        borders: number(10) as u64,
        euler: number(11) as i64,
        area: number(12),
    }
}

/// Extracts a fixture with cells of `cell`; the report and the exit code.
fn extract(desk: &Desk, name: &str, cell: &str, more: &[&str]) -> (Value, Option<i32>) {
    let part = fixture(&format!("{name}.obj"));
    let tags = fixture(&format!("{name}.coping.txt"));
    let mut args = vec![
        "extract",
        part.to_str().unwrap(),
        "--coping",
        tags.to_str().unwrap(),
    ];
    args.extend(["--cell", cell, "--json", "-", "--quiet"]);
    args.extend(more);
    let output = desk.run(&args);
    let stderr = text(&output.stderr);
    assert!(stderr.is_empty(), "{name}: {stderr}");
    (
        serde_json::from_slice(&output.stdout).unwrap(),
        output.status.code(),
    )
}

/// Cells of one wall thickness must give the fixture's facts.
fn check_facts(name: &str) {
    let desk = Desk::new();
    let (report, code) = extract(&desk, name, "1t", &[]);
    let facts = facts(name);
    let (result, counts) = (&report["result"], &report["result"]["counts"]);
    assert_eq!(report["cracks"], 0, "{name}: {report:#}");
    assert_eq!(code, Some(0), "{name}");
    let found = [
        &counts["sheets"],
        &counts["seams"],
        &counts["junctions"],
        &counts["boundary_components"],
        &counts["euler"],
        &counts["components"],
    ]
    .map(|value| value.as_i64().unwrap());
    let expected = [
        facts.sheets as i64,
        facts.seams as i64,
        facts.junctions as i64,
        facts.borders as i64,
        facts.euler,
        1,
    ];
    assert_eq!(
        found, expected,
        "{name}: sheets, seams, junctions, borders, Euler, components"
    );
    // The ideal surface runs straight into corners where the exact one bends.
    let area = result["area"].as_f64().unwrap() / facts.area;
    assert!(
        (0.95..1.02).contains(&area),
        "{name}: area {area} of the ideal"
    );
    for flaw in [
        "irregular_edges",
        "pinches",
        "non_orientable_sheets",
        "lone_feet",
    ] {
        assert_eq!(counts[flaw], 0, "{name}: {flaw}");
    }
    assert_eq!(report["closed_over"].as_array().unwrap().len(), 0, "{name}");
}

macro_rules! facts_of {
    ($($name:ident),*) => {
        mod facts_of {
            $(
                #[test]
                fn $name() {
                    super::check_facts(stringify!($name));
                }
            )*
        }
    };
}

facts_of!(
    plate,
    tee,
    tee_thin_web,
    tee_thick_web,
    tee_filleted,
    tee_rotated,
    cross,
    ell,
    ell_bend,
    box_tube,
    box_divider,
    open_box,
    slanted_45,
    ibeam,
    rib_grid,
    plate_holes,
    plate_round_edge,
    plate_tapered,
    cylinder_shell,
    hemisphere_shell,
    wavy_rib,
    bracket,
    boss_gussets,
    enclosure
);

#[test]
fn thickness_of_flat_walls_is_exact() {
    let desk = Desk::new();
    let (report, _) = extract(&desk, "plate", "1t", &[]);
    let thickness = &report["result"]["thickness"];
    for figure in ["min", "p50", "max", "mean"] {
        let value = thickness[figure].as_f64().unwrap();
        assert!((value - 2.0).abs() < 1e-6, "{figure}: {value}");
    }
    assert_eq!(report["settings"]["cell_length"], 2.0);
}

#[test]
fn report_states_all_settings_and_work() {
    let desk = Desk::new();
    let (report, _) = extract(&desk, "tee", "1.5", &["-j", "2", "--memory-limit", "1G"]);
    let settings = &report["settings"];
    assert_eq!(settings["cell"], "1.5");
    assert_eq!(settings["cell_length"], 1.5);
    assert_eq!(settings["angle"], 15.0);
    assert_eq!(settings["keep_fins"], false);
    assert_eq!(settings["memory_limit"], 1 << 30);
    assert_eq!(settings["threads"], 2);
    assert_eq!(report["schema"], 1);
    assert_eq!(report["tool"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["input"]["sha256"].as_str().unwrap().len(), 64);
    assert_eq!(report["work"]["lost"], 0);
    for figure in [
        "cells",
        "tetrahedra",
        "faces",
        "edges",
        "queries",
        "queries_per_edge",
    ] {
        assert!(report["work"][figure].as_f64().unwrap() > 0.0, "{figure}");
    }
    for stage in ["read", "field", "trace", "mesh", "write", "total"] {
        assert!(report["seconds"][stage].as_f64().unwrap() >= 0.0, "{stage}");
    }
    if cfg!(target_os = "linux") {
        assert!(report["peak_memory"].as_u64().unwrap() > 1 << 20);
    }
}

#[test]
fn outputs_can_be_read_again() {
    let desk = Desk::new();
    let outputs = [
        "-o", "mid.obj", "-o", "mid.ply", "-o", "mid.stl", "-o", "mid.vtu",
    ];
    let (report, code) = extract(&desk, "rib_grid", "1t", &outputs);
    assert_eq!(code, Some(0));
    let result = &report["result"];
    let count = |figure: &str| result["counts"][figure].as_u64().unwrap() as usize;
    for name in ["mid.obj", "mid.ply", "mid.stl"] {
        let mid = read_mesh(desk.path(name)).unwrap();
        assert_eq!(mid.mesh.triangles.len(), count("triangles"), "{name}");
        let area = result["area"].as_f64().unwrap();
        assert!((mid.mesh.area() - area).abs() < 1e-5 * area, "{name}");
        if name != "mid.stl" {
            assert_eq!(mid.mesh.positions.len(), count("vertices"), "{name}");
        }
    }
    let mid = read_mesh(desk.path("mid.obj")).unwrap();
    let groups: BTreeSet<String> = mid
        .mesh
        .faces()
        .flat_map(|face| mid.names_of(face).groups.clone())
        .collect();
    assert_eq!(groups.len(), count("sheets"));
    let csv = std::fs::read_to_string(desk.path("mid.thickness.csv")).unwrap();
    assert_eq!(csv.lines().count(), count("vertices") + 1);
    let vtu = std::fs::read_to_string(desk.path("mid.vtu")).unwrap();
    assert!(vtu.contains(&format!("NumberOfPoints=\"{}\"", count("vertices"))));
    assert_eq!(desk.files().len(), 5);
}

#[test]
fn number_of_threads_changes_no_byte() {
    let desk = Desk::new();
    let mut reports = Vec::new();
    for threads in ["1", "2", "3"] {
        let files = ["obj", "ply", "vtu"].map(|suffix| format!("mid{threads}.{suffix}"));
        let [obj, ply, vtu] = files.each_ref().map(String::as_str);
        let more = [
            "-j",
            threads,
            "-o",
            obj,
            "-o",
            ply,
            "-o",
            vtu,
            "--obj-lines",
        ];
        let (report, _) = extract(&desk, "boss_gussets", "1t", &more);
        reports.push((report["result"].clone(), report["work"].clone()));
    }
    for suffix in ["obj", "ply", "vtu", "thickness.csv"] {
        let bytes = |threads: u8| std::fs::read(desk.path(&format!("mid{threads}.{suffix}")));
        let first = bytes(1).unwrap();
        assert!(first.len() > 1000);
        assert!(
            first == bytes(2).unwrap(),
            "{suffix} differs between 1 and 2 threads"
        );
        assert!(
            first == bytes(3).unwrap(),
            "{suffix} differs between 1 and 3 threads"
        );
    }
    assert_eq!(reports[0], reports[1]);
    assert_eq!(reports[0], reports[2]);
}

#[test]
fn summary_goes_to_stderr_and_quiet_to_nowhere() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let args = [
        "extract",
        part.to_str().unwrap(),
        "--coping",
        tags.to_str().unwrap(),
    ];
    let loud = desk.run(&args);
    assert_eq!(loud.status.code(), Some(0), "{}", text(&loud.stderr));
    assert!(loud.stdout.is_empty());
    let summary = text(&loud.stderr);
    for word in [
        "sheets       3, area ",
        "seams        1 of length 50",
        "borders      ",
        "cracks       0",
        "thickness    ",
        "cell         2, ",
        " an edge",
        "seconds      ",
    ] {
        assert!(summary.contains(word), "no {word:?} in\n{summary}");
    }
    assert!(!summary.contains("warning"), "{summary}");
    assert!(
        !summary.contains('\u{1b}'),
        "no bar where there is no terminal"
    );
    assert!(desk.files().is_empty());

    let quiet = desk.run(&[&args[..], &["-q", "-o", "mid.obj"]].concat());
    assert_eq!(quiet.status.code(), Some(0));
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty());
    assert_eq!(desk.files().len(), 2);
}

#[test]
fn list_goes_to_stdout() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let part = [part.to_str().unwrap(), "--coping", tags.to_str().unwrap()];
    let args = [&["extract", "--list", "-q"], &part[..]].concat();
    let output = desk.run(&args);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
    let list = text(&output.stdout);
    assert!(list.starts_with("3 sheets, 1 seam, 0 junctions;"), "{list}");
    assert_eq!(list.matches("\nsheet ").count(), 3);
    assert_eq!(list.matches("\nseam of 3 ").count(), 1);
    let both = desk.run(&[&args[..], &["--json", "-"]].concat());
    assert_eq!(both.status.code(), Some(2));
    assert!(both.stdout.is_empty());
    assert!(text(&both.stderr).contains("--list"));
}

#[test]
fn too_fine_a_cell_is_refused() {
    let desk = Desk::new();
    let part = fixture("plate.obj");
    let part = part.to_str().unwrap();
    let words = [
        "plate.obj",
        "active cells",
        "smallest cell that fits",
        "--memory-limit",
    ];
    desk.refuses(&[part, "--cell", "0.0001"], &words);
    desk.refuses(&[part, "--cell", "1", "--memory-limit", "64K"], &words);
    // The cell that the message names is not refused.
    let args = ["extract", part, "--cell", "1", "--memory-limit", "64K"];
    let stderr = text(&desk.run(&args).stderr);
    let words: Vec<&str> = stderr.split_whitespace().collect();
    let about = words
        .windows(2)
        .position(|pair| pair == ["is", "about"])
        .unwrap();
    let args = [
        "extract",
        part,
        "--cell",
        words[about + 2],
        "--memory-limit",
        "64K",
    ];
    let again = text(&desk.run(&args).stderr);
    assert!(!again.contains("smallest cell"), "{again}");
}

#[test]
fn walls_that_face_nothing_have_no_thickness() {
    let desk = Desk::new();
    let mesh = cuboid(DVec3::ZERO, DVec3::new(10.0, 10.0, 1.0));
    desk.put("block.obj", obj_text(&mesh));
    // All but the bottom.
    desk.put("most.txt", "2-11");
    let args = ["block.obj", "--coping", "most.txt"];
    desk.refuses(
        &args,
        &["block.obj", "no wall faces another", "midsurf tags"],
    );
    let output = desk.run(&[&["extract"], &args[..], &["--cell", "1", "-o", "mid.obj"]].concat());
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("no mid-surface was found"));
    assert!(!desk.path("mid.obj").exists());
}

#[test]
fn kept_fins_are_sheets_of_their_own() {
    let desk = Desk::new();
    let sheets = |more: &[&str]| {
        let (report, code) = extract(&desk, "ell", "1t", more);
        assert_eq!(code, Some(0), "{report:#}");
        report["result"]["counts"]["sheets"].as_u64().unwrap()
    };
    assert_eq!(sheets(&[]), 1);
    assert_eq!(sheets(&["--keep-fins"]), 3);
}

#[test]
fn an_inverted_part_is_turned_and_says_so() {
    let desk = Desk::new();
    let tee = read_mesh(fixture("tee.obj")).unwrap();
    desk.put("turned.obj", obj_text(&inverted(&tee.mesh)));
    let tags = fixture("tee.coping.txt");
    let args = ["extract", "turned.obj", "--coping", tags.to_str().unwrap()];
    let output = desk.run(&[&args[..], &["--json", "-"]].concat());
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("warning: turned.obj: the part was inside out"));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["warnings"][0]["code"], "turned");
    assert_eq!(report["result"]["counts"]["sheets"], 3);
}

#[test]
fn what_was_closed_over_is_told() {
    let desk = Desk::new();
    let borders = facts("plate_holes").borders as usize;
    for cell in ["1t", "3t", "6t"] {
        let (report, _) = extract(&desk, "plate_holes", cell, &[]);
        let missing = report["closed_over"].as_array().unwrap();
        let found = report["result"]["counts"]["boundary_components"]
            .as_u64()
            .unwrap() as usize;
        // Every hole either has its border or is named.
        assert_eq!(found + missing.len(), borders, "{cell}: {report:#}");
        let warned = report["warnings"].as_array().unwrap();
        let warned = warned
            .iter()
            .any(|warning| warning["code"] == "closed_over");
        assert_eq!(warned, !missing.is_empty());
    }
}

#[test]
fn an_open_part_is_extracted_on_demand() {
    let desk = Desk::new();
    let mut mesh = read_mesh(fixture("plate.obj")).unwrap().mesh;
    let tags = fixture("plate.coping.txt");
    let tags = tags.to_str().unwrap();
    desk.put("plate.obj", obj_text(&mesh));
    mesh.triangles.pop();
    desk.put("open.obj", obj_text(&mesh));
    desk.put(
        "tags.txt",
        std::fs::read_to_string(tags).unwrap().replace("-11", "-10"),
    );
    let args = ["open.obj", "--coping", "tags.txt"];
    desk.refuses(&args, &["open.obj", "--allow-open"]);
    let output = desk.run(&[&["extract"], &args[..], &["--allow-open", "--json", "-"]].concat());
    let stderr = text(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{stderr}");
    assert!(
        stderr.contains("warning: open.obj: the mesh is open"),
        "{stderr}"
    );
}
