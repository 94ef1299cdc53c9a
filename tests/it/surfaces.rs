//! Surfaces without thickness: offset to one side or both, thickened on both.

use std::f64::consts::PI;

use midsurf::io::read_mesh;
use midsurf::mesh::{TriMesh, self_intersections};
use serde_json::Value;

use crate::common::{Desk, text};

/// A square of side 10 in the plane z = 0.
const SQUARE: &str = "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nf 1 2 3 4\n";

/// Runs a command that must succeed; the volume of what it wrote.
fn volume(desk: &Desk, args: &[&str]) -> f64 {
    let output = desk.run(&[args, &["-o", "out.obj", "--json", "report.json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = std::fs::read_to_string(desk.path("report.json")).unwrap();
    let report: Value = serde_json::from_str(&report).unwrap();
    assert_eq!(report["tool"]["command"], args[0]);
    let mesh = read_mesh(desk.path("out.obj")).unwrap().mesh;
    assert!(mesh.edges().census().is_closed());
    assert!(self_intersections(&mesh).is_empty());
    mesh.volume()
}

#[test]
fn an_open_surface_has_an_offset_to_each_side_and_to_both() {
    let desk = Desk::new();
    desk.put("square.obj", SQUARE);
    let offset = |side: &str| {
        let args = ["offset", "square.obj", "--distance", "1", "--open", side];
        volume(&desk, &[&args[..], &["--cell", "0.25"]].concat())
    };
    // Steiner's formula for the ball-shaped neighbourhood of a flat convex set.
    let around = 2.0 * 100.0 + 0.5 * PI * 40.0 + 4.0 / 3.0 * PI;
    let both = offset("both");
    assert!((both / around - 1.0).abs() < 2e-3, "{both} {around}");
    for side in ["front", "back"] {
        let one = offset(side);
        assert!((one / 100.0 - 1.0).abs() < 1e-9, "{side}: {one}");
        let mesh = read_mesh(desk.path("out.obj")).unwrap().mesh;
        let middle = mesh.bounds().center().z;
        assert_eq!(middle > 0.0, side == "front", "{side}");
    }
    desk.refuses_command(
        &[
            "offset",
            "square.obj",
            "--distance=-1",
            "--open",
            "both",
            "-o",
            "a.stl",
        ],
        &["no inside to shrink"],
    );
    desk.refuses_command(
        &["offset", "square.obj", "--distance", "1", "-o", "a.stl"],
        &["square.obj"],
    );
}

#[test]
fn both_sides_take_half_of_the_thickness_each() {
    let desk = Desk::new();
    desk.put("square.obj", SQUARE);
    let args = [
        "thicken",
        "square.obj",
        "--thickness",
        "2",
        "--side",
        "both",
    ];
    let found = volume(&desk, &args);
    assert!((found / 200.0 - 1.0).abs() < 1e-9, "{found}");
    let mesh = read_mesh(desk.path("out.obj")).unwrap().mesh;
    assert!(mesh.bounds().center().z.abs() < 1e-9);
    let few = volume(&desk, &[&args[..], &["--simplify"]].concat());
    assert!((few / 200.0 - 1.0).abs() < 1e-9, "{few}");
    let few = read_mesh(desk.path("out.obj")).unwrap().mesh;
    assert_eq!(few.triangles.len(), 12);
    let none = ["thicken", "square.obj", "--side", "inner", "-o", "a.stl"];
    desk.refuses_command(&none, &["one thickness all over", "--side both"]);
    let bad = [
        "thicken",
        "square.obj",
        "--thickness=-2",
        "--side",
        "both",
        "-o",
        "a.stl",
    ];
    desk.refuses_command(&bad, &["not a positive length"]);
}

#[test]
fn a_thickened_surface_simplified_keeps_its_triangles() {
    let desk = Desk::new();
    desk.put("square.obj", SQUARE);
    let args = ["thicken", "square.obj", "--thickness", "2"];
    let solid = |more: &[&str]| {
        let volume = volume(&desk, &[&args[..], more].concat());
        assert!((volume / 200.0 - 1.0).abs() < 1e-6, "{volume}");
        read_mesh(desk.path("out.obj")).unwrap().mesh
    };
    let (all, few) = (solid(&[]), solid(&["--simplify"]));
    assert!(4 * few.triangles.len() < all.triangles.len());
    for t in [0, 1] {
        let corners = |mesh: &TriMesh| mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        assert_eq!(corners(&few), corners(&all));
    }
}

/// A thickness of 1 at one end and 3 at the other, from the file.
#[test]
fn a_thickness_at_every_vertex_is_taken_from_the_file() {
    let desk = Desk::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nproperty double thickness\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let rest = "0 0 0 1\n10 0 0 3\n10 10 0 3\n0 10 0 1\n3 0 1 2\n3 0 2 3\n";
    desk.put("wedge.ply", format!("{header}{rest}"));
    let found = volume(&desk, &["thicken", "wedge.ply", "--side", "both"]);
    // A wedge of balls: its faces touch them, so they lean, and are as far from
    // the plane as 1 / cos at the thin end.
    let slope: f64 = 0.1;
    let wedge = 200.0 / (1.0 - slope * slope).sqrt();
    assert!((found / wedge - 1.0).abs() < 5e-3, "{found} {wedge}");
}

/// The long side of one square has a vertex of two others in its middle.
#[test]
fn a_vertex_in_the_middle_of_an_edge_is_stitched() {
    let desk = Desk::new();
    desk.put(
        "sheet.obj",
        "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 10 5 0\nv 20 0 0\nv 20 10 0\nv 20 5 0\n\
         f 1 2 3\nf 1 3 4\nf 2 6 8\nf 2 8 5\nf 5 8 7\nf 5 7 3\n",
    );
    let found = volume(&desk, &["thicken", "sheet.obj", "--thickness", "2"]);
    assert!((found / 400.0 - 1.0).abs() < 1e-9, "{found}");
    let report = std::fs::read_to_string(desk.path("report.json")).unwrap();
    assert!(report.contains("\"stitched\""), "{report}");
}

#[test]
fn small_holes_are_closed_when_asked_for() {
    let desk = Desk::new();
    // A square with a square hole of side 1 in its middle.
    desk.put(
        "frame.obj",
        "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 4 4 0\nv 5 4 0\nv 5 5 0\nv 4 5 0\n\
         f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n",
    );
    let args = ["thicken", "frame.obj", "--thickness", "2"];
    let open = volume(&desk, &args);
    // Reflex corners of the hole are contoured: exact to a share of a cell.
    assert!((open / 160.0 - 1.0).abs() < 1e-4, "{open}");
    let closed = volume(&desk, &[&args[..], &["--fill", "4.5"]].concat());
    assert!((closed / 162.0 - 1.0).abs() < 1e-9, "{closed}");
    let report = std::fs::read_to_string(desk.path("report.json")).unwrap();
    assert!(report.contains("1 holes were closed"), "{report}");
    let both = [
        &args[..],
        &["--side", "both", "--fill", "4.5", "-o", "a.stl"],
    ]
    .concat();
    desk.refuses_command(&both, &["one side"]);
}
