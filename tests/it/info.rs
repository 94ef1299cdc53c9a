//! What `info` says of a part.

use glam::DVec3;
use serde_json::Value;

use crate::common::{Desk, cuboid, obj_text, text};

/// A plate 40 x 24 whose thickness grows from 1 to 3 along x.
fn tapered() -> String {
    let mut mesh = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 1.0));
    for corner in [5, 7] {
        mesh.positions[corner].z = 3.0;
    }
    obj_text(&mesh)
}

#[test]
fn the_thinnest_wall_is_told_with_its_place() {
    let desk = Desk::new();
    desk.put("tapered.obj", tapered());
    let info = |more: &[&str]| {
        let output = desk.run(&[&["info", "tapered.obj", "--json"], more].concat());
        let info: Value = serde_json::from_slice(&output.stdout).unwrap();
        (info, output.status.code())
    };
    let (all, code) = info(&[]);
    assert_eq!(code, Some(0));
    let thickness = &all["thickness"];
    let thinnest = thickness["thinnest"].as_f64().unwrap();
    // Measured at points of the wall, not at its very edge.
    assert!((1.0..1.03).contains(&thinnest), "{thickness:#}");
    assert!(thickness["thinnest_at"][0].as_f64().unwrap() < 2.0);
    assert!((thickness["p50"].as_f64().unwrap() - 2.0).abs() < 0.1);

    let (thin, code) = info(&["--min-wall", "1.5"]);
    assert_eq!(code, Some(1));
    let share = thin["thickness"]["check"]["share_below"].as_f64().unwrap();
    assert!((share - 0.25).abs() < 0.03, "{share}");
    let (_, code) = info(&["--min-wall", "0.9"]);
    assert_eq!(code, Some(0));
}

#[test]
fn the_thickness_is_mapped() {
    let desk = Desk::new();
    desk.put("tapered.obj", tapered());
    for file in ["map.ply", "map.vtu"] {
        let output = desk.run(&["info", "tapered.obj", "-o", file]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    let map = text(&std::fs::read(desk.path("map.vtu")).unwrap());
    let values = map
        .lines()
        .skip_while(|line| !line.contains("Name=\"thickness\""));
    let values = values.skip(1).take_while(|line| !line.starts_with('<'));
    let values: Vec<f64> = values.map(|line| line.parse().unwrap()).collect();
    let known: Vec<f64> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    assert!(values.len() > 100_000 && known.len() > values.len() / 2);
    let least = known.iter().copied().fold(f64::INFINITY, f64::min);
    let most = known.iter().copied().fold(0.0, f64::max);
    assert!(
        (1.0..1.05).contains(&least) && (2.9..3.01).contains(&most),
        "{least} {most}"
    );
    let output = desk.run(&["info", "tapered.obj", "-o", "map.obj"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(!desk.path("map.obj").exists());
}

#[test]
fn triangles_with_a_repeated_corner_are_no_shells() {
    let desk = Desk::new();
    let mut mesh = cuboid(DVec3::ZERO, DVec3::new(30.0, 20.0, 3.0));
    for corner in 0..5 {
        mesh.triangles.push([corner, corner + 1, corner]);
    }
    desk.put("flat.obj", obj_text(&mesh));
    let output = desk.run(&["info", "flat.obj"]);
    let info = text(&output.stdout);
    assert!(info.lines().any(|line| line == "components   1"), "{info}");
    assert!(info.lines().any(|line| line == "euler        2"), "{info}");
}
