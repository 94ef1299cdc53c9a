//! Harmless changes of the input change neither counts nor surface: rotation,
//! translation, scale, order of triangles, number of threads.

use glam::{DMat3, DVec3};
use midsurf::CellSize;
use midsurf::extract::{ExtractError, Extraction, Settings, extract, extract_until};
use midsurf::mesh::{Part, PartOptions, TriMesh};
use midsurf::settings::progress::Stop;

use crate::common::fixture_part;

/// A change of a part: new position of each vertex, and of each triangle.
struct Change {
    name: &'static str,
    scale: f64,
    turn: DMat3,
    shift: DVec3,
    /// Triangle order: index times this, modulo the count (coprime to it by search).
    stride: usize,
}

fn changes() -> Vec<Change> {
    let odd = DMat3::from_axis_angle(DVec3::new(0.3, -0.8, 0.52).normalize(), 0.7351);
    let other = DMat3::from_axis_angle(DVec3::new(-0.61, 0.2, 0.77).normalize(), 2.1817);
    let same = |name| Change {
        name,
        scale: 1.0,
        turn: DMat3::IDENTITY,
        shift: DVec3::ZERO,
        stride: 1,
    };
    vec![
        Change {
            turn: odd,
            ..same("rotated")
        },
        Change {
            turn: other,
            ..same("rotated otherwise")
        },
        Change {
            shift: DVec3::new(1e4, -1e4, 1e4),
            ..same("translated by 1e4")
        },
        Change {
            scale: 1e-3,
            ..same("scaled by 1e-3")
        },
        Change {
            scale: 1e3,
            ..same("scaled by 1e3")
        },
        Change {
            stride: 7,
            ..same("shuffled")
        },
        Change {
            turn: odd,
            scale: 0.37,
            shift: DVec3::new(3.0, 100.0, -7.0),
            stride: 11,
            ..same("all at once")
        },
    ]
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn changed(mesh: &TriMesh, coping: &[bool], change: &Change) -> Part {
    let count = mesh.triangles.len();
    let stride = (change.stride..).find(|&s| gcd(s, count) == 1).unwrap();
    let order = (0..count).map(|i| i * stride % count);
    let place = |p: &DVec3| change.turn * *p * change.scale + change.shift;
    let new = TriMesh {
        positions: mesh.positions.iter().map(place).collect(),
        triangles: order.clone().map(|i| mesh.triangles[i]).collect(),
    };
    let flags = order.map(|i| coping[i]).collect();
    Part::new(new, flags, PartOptions::default()).unwrap().0
}

fn run(part: &Part, cell: f64) -> Extraction {
    let settings = Settings {
        cell: CellSize::Length(cell),
        ..Settings::default()
    };
    extract(part, &settings, &|_, _, _| ()).unwrap()
}

fn counts(e: &Extraction) -> (usize, u32, usize, i64) {
    let (v, t) = (
        e.surface.vertices().len() as i64,
        e.surface.triangles().len() as i64,
    );
    let mut edges: Vec<(u32, u32)> = e
        .surface
        .triangles()
        .iter()
        .flat_map(|t| (0..3).map(move |k| (t.corners[k], t.corners[(k + 1) % 3])))
        .map(|(a, b)| (a.min(b), a.max(b)))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    (
        e.graph.cracks().len(),
        e.surface.sheet_count(),
        e.surface.seams().len(),
        v - edges.len() as i64 + t,
    )
}

fn area(e: &Extraction) -> f64 {
    e.surface
        .triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = t.corners.map(|v| e.surface.vertices()[v as usize].position);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum()
}

fn check(name: &str, cell: f64) {
    let (mesh, coping) = fixture_part(name);
    let part = Part::new(mesh.clone(), coping.clone(), PartOptions::default())
        .unwrap()
        .0;
    let plain = run(&part, cell);
    assert_eq!(plain.graph.cracks().len(), 0, "{name}");
    for change in changes() {
        let part = changed(&mesh, &coping, &change);
        let result = run(&part, cell * change.scale);
        assert_eq!(
            counts(&result),
            counts(&plain),
            "{name} {}: cracks, sheets, seams, Euler",
            change.name
        );
        let ratio = area(&result) / change.scale.powi(2) / area(&plain);
        assert!(
            (ratio - 1.0).abs() < 3e-3,
            "{name} {}: area ratio {ratio}",
            change.name
        );
    }
}

#[test]
fn tee() {
    check("tee", 2.0);
}

#[test]
fn tee_with_coarse_cells() {
    check("tee", 6.0);
}

#[test]
fn tee_with_fine_cells() {
    check("tee", 0.9);
}

#[test]
fn cross() {
    check("cross", 2.0);
}

#[test]
fn ell() {
    check("ell", 2.0);
}

#[test]
fn box_divider() {
    check("box_divider", 2.0);
}

#[test]
fn rib_grid() {
    check("rib_grid", 2.0);
}

#[test]
fn rib_grid_with_coarse_cells() {
    check("rib_grid", 6.0);
}

#[test]
fn plate_round_edge() {
    check("plate_round_edge", 2.0);
}

#[test]
fn tee_filleted() {
    check("tee_filleted", 2.0);
}

#[test]
fn boss_gussets() {
    check("boss_gussets", 2.0);
}

#[test]
fn wavy_rib() {
    check("wavy_rib", 1.6);
}

#[test]
fn bracket() {
    check("bracket", 1.5);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let (mesh, coping) = fixture_part("boss_gussets");
    let part = Part::new(mesh, coping, PartOptions::default()).unwrap().0;
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run(&part, 1.0)).surface
    };
    let one = on(1);
    assert!(one == on(2) && one == on(5));
}

/// Work that is asked to stop ends without a result, wherever it is.
#[test]
fn an_extraction_can_be_stopped_at_any_stage() {
    let (mesh, flags) = fixture_part("tee");
    let (part, _) = Part::new(mesh, flags, PartOptions::default()).unwrap();
    let settings = Settings::default();
    for stage in ["field", "trace", "mesh"] {
        let stop = Stop::default();
        let seen = std::sync::atomic::AtomicBool::new(false);
        let progress = |at: &'static str, _, _| {
            if at == stage {
                seen.store(true, std::sync::atomic::Ordering::Relaxed);
                stop.ask();
            }
        };
        let result = extract_until(&part, &settings, &progress, &stop);
        assert!(matches!(result, Err(ExtractError::Stopped)), "{stage}");
        assert!(seen.into_inner(), "{stage}");
    }
}
