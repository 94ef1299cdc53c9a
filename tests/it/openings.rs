//! Cavities opened by drains and cuts, and contours with fewer triangles.

use std::f64::consts::PI;

use glam::DVec3;
use midsurf::mesh::{Part, PartOptions, Simplify, TriMesh, closed_shells, self_intersections};
use midsurf::offset::{Cut, Drain, OpeningError, Settings, hollowed, offset, opened};
use midsurf::settings::precision::Precision;

use crate::common::{Desk, cuboid, obj_text, text};

/// A cube of 40.
fn cube() -> Part {
    let mesh = cuboid(DVec3::ZERO, DVec3::splat(40.0));
    let flags = vec![false; mesh.triangles.len()];
    Part::new(mesh, flags, PartOptions::default()).unwrap().0
}

/// The cavity of a cube with walls of 3, of few triangles.
fn cavity(part: &Part) -> TriMesh {
    let settings = Settings {
        cell: 1.7,
        simplify: Some(Simplify {
            tolerance: 1e-6,
            triangles: None,
        }),
        ..Settings::new(part, -3.0)
    };
    offset(part, &settings, &|_, _, _| ()).unwrap().mesh
}

fn open(drains: &[&str], cuts: &[&str]) -> Result<TriMesh, OpeningError> {
    let part = cube();
    let cavity = cavity(&part);
    let drains: Vec<Drain> = drains.iter().map(|d| d.parse().unwrap()).collect();
    let cuts: Vec<Cut> = cuts.iter().map(|c| c.parse().unwrap()).collect();
    let pair = [part.mesh(), &cavity];
    opened(
        &hollowed(&part, &cavity),
        pair,
        &drains,
        &cuts,
        Precision::Double,
    )
}

fn check(mesh: &TriMesh) {
    assert!(mesh.edges().by_edge().all(|uses| uses.len() == 2));
    assert!(mesh.edges().census().is_closed());
    assert_eq!(self_intersections(mesh), []);
    // One body, and nothing is shut in.
    assert_eq!(closed_shells(mesh, &mesh.edges()).len(), 1);
    assert!(mesh.volume() > 0.0);
}

const HOLLOW: f64 = 64_000.0 - 39_304.0;

fn near(a: f64, b: f64) {
    assert!((a / b - 1.0).abs() < 1e-6, "{a} for {b}");
}

#[test]
fn a_simplified_box_is_a_box() {
    let part = cube();
    let cavity = cavity(&part);
    assert_eq!(cavity.triangles.len(), 12);
    near(cavity.volume(), 39_304.0);
}

#[test]
fn drains_open_the_cavity() {
    let drained = open(&["6@20,20,41"], &[]).unwrap();
    check(&drained);
    near(drained.volume(), HOLLOW - 9.0 * PI * 3.0);
    // Two make a tunnel.
    let drained = open(&["6@20,20,41", "4@-1,11,13"], &[]).unwrap();
    check(&drained);
    near(drained.volume(), HOLLOW - (9.0 + 4.0) * PI * 3.0);
}

#[test]
fn drains_that_open_nothing_are_refused() {
    // Over the wall beside the cavity.
    let refused = open(&["2@1,1,40"], &[]);
    assert!(
        matches!(refused, Err(OpeningError::NoCavity { .. })),
        "{refused:?}"
    );
}

#[test]
fn a_plane_makes_a_cup() {
    let cup = open(&[], &["+z=36"]).unwrap();
    check(&cup);
    near(cup.volume(), 40.0 * 40.0 * 36.0 - 34.0 * 34.0 * 33.0);
    let other = open(&[], &["-z=36"]).unwrap();
    check(&other);
    near(cup.volume() + other.volume(), HOLLOW);
    assert_eq!(open(&[], &["-x=50"]), Err(OpeningError::NothingLeft));
}

#[test]
fn the_command_opens_and_simplifies() {
    let desk = Desk::new();
    desk.put("cube.obj", obj_text(cube().mesh()));
    let args = [
        "hollow",
        "cube.obj",
        "--thickness",
        "3",
        "--cell",
        "1.7",
        "--simplify",
    ];
    let run = |more: &[&str]| desk.run(&[&args[..], more].concat());
    let out = run(&["--drain", "6@20,20,41", "-o", "drained.stl"]);
    assert!(out.status.success(), "{}", text(&out.stderr));
    assert!(
        text(&out.stderr).contains("1 piece, 0 cavities"),
        "{}",
        text(&out.stderr)
    );
    let out = run(&["--open", "-z=36", "-o", "lid.obj"]);
    assert!(out.status.success(), "{}", text(&out.stderr));
    let out = run(&["--drain", "2@1,1,40", "-o", "none.stl"]);
    assert_eq!(out.status.code(), Some(4), "{}", text(&out.stderr));
    assert!(!desk.path("none.stl").exists());
    let out = run(&["--drain", "2@1,1", "-o", "none.stl"]);
    assert_eq!(out.status.code(), Some(2));
    let out = desk.run(&[
        "offset",
        "cube.obj",
        "--distance",
        "4",
        "--cell",
        "1.7",
        "--triangles",
        "300",
        "--json",
        "report.json",
    ]);
    assert!(out.status.success(), "{}", text(&out.stderr));
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(desk.path("report.json")).unwrap()).unwrap();
    assert!(report["result"]["triangles"].as_u64().unwrap() <= 300);
    assert!(report["result"]["simplified_within"].as_f64().unwrap() > 0.0);
}
