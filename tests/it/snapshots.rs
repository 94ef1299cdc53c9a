//! The non-manifold result as text: sheets, seams with their ends, borders,
//! junctions. A change here is a change of topology or of where things lie.

use midsurf::CellSize;
use midsurf::extract::{Settings, extract};
use midsurf::io::{MeshFormat, read_mesh_bytes};
use midsurf::mesh::{Part, PartOptions};
use midsurf::surface::listing::listing;

use crate::common::fixture_part;

fn listed(part: &Part, cell: f64) -> String {
    let settings = Settings {
        cell: CellSize::Length(cell),
        ..Settings::default()
    };
    let result = extract(part, &settings, &|_, _, _| ()).unwrap();
    assert!(result.graph.cracks().is_empty());
    listing(&result.surface, &result.graph)
}

fn fixture_listed(name: &str, cell: f64) -> String {
    let (mesh, coping) = fixture_part(name);
    listed(
        &Part::new(mesh, coping, PartOptions::default()).unwrap().0,
        cell,
    )
}

#[test]
fn tee() {
    insta::assert_snapshot!(fixture_listed("tee", 2.0));
}

#[test]
fn cross() {
    insta::assert_snapshot!(fixture_listed("cross", 2.0));
}

#[test]
fn corners_of_three_walls() {
    insta::assert_snapshot!(fixture_listed("open_box", 3.0));
}

#[test]
fn rib_grid() {
    insta::assert_snapshot!(fixture_listed("rib_grid", 2.0));
}

#[test]
fn filleted_tee() {
    insta::assert_snapshot!(fixture_listed("tee_filleted", 2.0));
}

#[test]
fn plate_with_a_full_round() {
    insta::assert_snapshot!(fixture_listed("plate_round_edge", 2.0));
}

#[test]
fn web_that_ends_inside_a_panel() {
    insta::assert_snapshot!(fixture_listed("wavy_rib", 1.6));
}

/// Half a cylinder shell, 2 thick, with a radial rib outside, 30 long: an
/// extrusion whose end caps are polygons of the file.
fn cylinder_with_rib() -> Part {
    const STEPS: usize = 36;
    let (inner, outer, top, half): (f64, f64, f64, f64) = (19.0, 21.0, 29.0, 1.0);
    let round = |r: f64, k: usize| {
        let a = std::f64::consts::PI * k as f64 / STEPS as f64;
        (r * a.cos(), r * a.sin())
    };
    // Counter-clockwise: outside from the right to the rib, round it, on to the left, back inside.
    let foot = (outer * outer - half * half).sqrt();
    let mut section: Vec<(f64, f64)> = (0..=STEPS)
        .map(|k| round(outer, k))
        .filter(|p| p.0 > half)
        .collect();
    section.extend([(half, foot), (half, top), (-half, top), (-half, foot)]);
    section.extend((0..=STEPS).map(|k| round(outer, k)).filter(|p| p.0 < -half));
    section.extend((0..=STEPS).rev().map(|k| round(inner, k)));
    let n = section.len();
    let mut obj = String::new();
    for z in [0.0, 30.0] {
        for (x, y) in &section {
            obj.push_str(&format!("v {x} {y} {z}\n"));
        }
    }
    let cap = |first: usize, turn: bool| {
        let mut corners: Vec<String> = (0..n).map(|k| (first + k + 1).to_string()).collect();
        if turn {
            corners.reverse();
        }
        format!("f {}\n", corners.join(" "))
    };
    obj.push_str(&cap(0, true));
    obj.push_str(&cap(n, false));
    for k in 0..n {
        let l = (k + 1) % n;
        obj.push_str(&format!(
            "f {} {} {} {}\n",
            k + 1,
            l + 1,
            n + l + 1,
            n + k + 1
        ));
    }
    let loaded = read_mesh_bytes(obj.as_bytes(), MeshFormat::Obj, "rib.obj".as_ref()).unwrap();
    // Coping: the caps, the two ends of the arc, the top of the rib.
    let is_coping = |facet: u32| {
        let Some(k) = (facet as usize).checked_sub(2) else {
            return true;
        };
        let (p, q) = (section[k], section[(k + 1) % n]);
        let end = p.1.abs() < 1e-9 && q.1.abs() < 1e-9;
        end || (p.1 == top && q.1 == top)
    };
    let coping = loaded.source.iter().map(|&f| is_coping(f)).collect();
    Part::new(loaded.mesh, coping, PartOptions::default())
        .unwrap()
        .0
}

#[test]
fn cylinder_shell_with_a_rib() {
    insta::assert_snapshot!(listed(&cylinder_with_rib(), 2.0));
}

#[test]
fn fins_are_kept_on_demand() {
    let (mesh, coping) = fixture_part("ell");
    let part = Part::new(mesh, coping, PartOptions::default()).unwrap().0;
    let settings = Settings {
        cell: CellSize::Length(2.0),
        keep_fins: true,
        ..Settings::default()
    };
    let result = extract(&part, &settings, &|_, _, _| ()).unwrap();
    assert_eq!(
        (result.surface.sheet_count(), result.surface.seams().len()),
        (3, 1)
    );
    // The branch point of an L lies at 2 - sqrt 2 of the thickness from both outer walls.
    let place = (2.0 - 2f64.sqrt()) * 2.0;
    let seam = &result.surface.seams()[0].path;
    for &v in seam {
        let p = result.surface.vertices()[v as usize].position - part.bounds().min;
        assert!(
            (p.x - place).abs() < 1e-9 && (p.y - place).abs() < 1e-9,
            "{p}"
        );
    }
}
