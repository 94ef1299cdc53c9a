//! Facts known exactly: where branch lines run, how thick walls are, that
//! every vertex is equally far from its walls and borders lie on coping.

use glam::DVec3;
use midsurf::CellSize;
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::internals::field::Field;
use midsurf::internals::trace::edge::{bisect, crossings, sample_node};
use midsurf::internals::trace::probe::Probe;
use midsurf::internals::walls::{Separation, Walls};
use midsurf::mesh::{Part, PartOptions};
use midsurf::surface::VertexKind;

use crate::common::fixture_part;

fn part(name: &str) -> Part {
    let (mesh, coping) = fixture_part(name);
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

fn run(part: &Part, cell: f64) -> Extraction {
    let settings = Settings {
        cell: CellSize::Length(cell),
        ..Settings::default()
    };
    extract(part, &settings, &|_, _, _| ()).unwrap()
}

#[test]
fn branch_line_of_a_tee_runs_at_five_eighths() {
    let part = part("tee");
    for cell in [0.6, 2.0, 6.0] {
        let result = run(&part, cell);
        for &v in &result.surface.seams()[0].path {
            let p = result.surface.vertices()[v as usize].position;
            assert!(
                p.x.abs() < 1e-9 && (p.y + 0.25).abs() < 1e-9,
                "cell {cell}: {p}"
            );
        }
    }
}

#[test]
fn branch_line_of_a_thin_web_follows_the_formula() {
    // h = (w^2 / 4 + f^2) / (2 f) above the flange's outer face, at y = +f / 2.
    let part = part("tee_thin_web");
    let (f, w): (f64, f64) = (3.0, 1.5);
    let h = (0.25 * w * w + f * f) / (2.0 * f);
    let result = run(&part, 1.5);
    assert_eq!(result.surface.seams().len(), 1);
    for &v in &result.surface.seams()[0].path {
        let p = result.surface.vertices()[v as usize].position;
        assert!(
            (p.y - (0.5 * f - h)).abs() < 1e-9,
            "{p} against {}",
            0.5 * f - h
        );
    }
}

#[test]
fn every_vertex_is_equally_far_from_its_walls() {
    for (name, cell) in [
        ("tee", 2.0),
        ("boss_gussets", 2.0),
        ("wavy_rib", 1.6),
        ("hemisphere_shell", 2.0),
    ] {
        let part = part(name);
        let field = Field::new(&part);
        for v in run(&part, cell).surface.vertices() {
            let distances: Vec<f64> = v
                .ball
                .footpoints
                .iter()
                .map(|f| f.distance(v.position))
                .collect();
            let nearest = field.footpoint(v.position).distance;
            assert!(distances.len() >= 2, "{name}");
            let worst = distances
                .iter()
                .map(|d| (d - nearest).abs())
                .fold(0.0, f64::max);
            assert!(worst < 2e-5, "{name} at {}: off by {worst}", v.position);
        }
    }
}

#[test]
fn borders_lie_on_coping() {
    for (name, cell) in [
        ("plate_holes", 2.0),
        ("bracket", 1.5),
        ("boss_gussets", 6.0),
    ] {
        let part = part(name);
        let field = Field::new(&part);
        let result = run(&part, cell);
        let surface = &result.surface;
        for border in surface
            .borders()
            .iter()
            .filter(|b| b.kind == midsurf::surface::BorderKind::Coping)
        {
            for pair in border.path.windows(2) {
                let [p, q] = [pair[0], pair[1]].map(|v| surface.vertices()[v as usize].position);
                let middle = 0.5 * (p + q);
                let gap = field
                    .nearest_coping(middle, f64::INFINITY)
                    .unwrap()
                    .distance;
                assert!(gap < 1e-6, "{name}: {gap} at {middle}");
            }
        }
    }
}

#[test]
fn thickness_of_plane_walls_is_exact() {
    let result = run(&part("rib_grid"), 2.0);
    let plain = result
        .surface
        .vertices()
        .iter()
        .filter(|v| v.kind == VertexKind::Sheet && v.position.z > 3.0);
    let mut count = 0;
    for v in plain {
        // Away from where ribs cross.
        if (v.position.x - 20.0).abs() > 3.0 && (v.position.x - 40.0).abs() > 3.0
            || (v.position.y - 15.0).abs() > 3.0 && (v.position.y - 30.0).abs() > 3.0
        {
            assert!(
                (v.ball.thickness - 2.0).abs() < 1e-6,
                "{} at {}",
                v.ball.thickness,
                v.position
            );
            count += 1;
        }
    }
    assert!(count > 100);
}

/// Points and directions from a fixed sequence.
fn sequence() -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
fn crossings_agree_with_bisection() {
    let part = part("tee");
    let field = Field::new(&part);
    let walls = Walls::new(
        &part,
        &field,
        Separation {
            min_angle: 15.0,
            keep_fins_from: None,
        },
    );
    let mut probe = Probe::new(&walls);
    let mut random = sequence();
    let (low, high) = field.bounds();
    let mut compared = 0;
    for _ in 0..20_000 {
        let p = low + (high - low) * DVec3::new(random(), random(), random());
        let q = p + 0.7 * DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5);
        if !(field.inside(p) && field.inside(q)) {
            continue;
        }
        let samples = [sample_node(&mut probe, p), sample_node(&mut probe, q)];
        let found = crossings(&mut probe, [p, q], [&samples[0], &samples[1]]);
        // Bisection sees one crossing of a segment that has an odd number.
        if let (Some(b), [c]) = (bisect(&mut probe, p, q, 1e-12), &found[..]) {
            assert!(b.at.distance(c.at) < 1e-9, "{} against {}", b.at, c.at);
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn crossings_need_few_queries_at_any_cell_size() {
    for cell in [0.5, 2.0, 8.0] {
        let result = run(&part("tee"), cell);
        assert!(
            result.work.counts.queries_per_edge < 3.0,
            "cell {cell}: {}",
            result.work.counts.queries_per_edge
        );
    }
}

#[test]
fn a_plate_is_its_middle() {
    let result = run(&part("plate"), 2.0);
    for v in result.surface.vertices() {
        assert!(v.position.y.abs() < 1e-9 && (v.ball.thickness - 2.0).abs() < 1e-9);
    }
    let area: f64 = result
        .surface
        .triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = t
                .corners
                .map(|v| result.surface.vertices()[v as usize].position);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    assert!((area - 60.0 * 40.0).abs() < 1e-6, "{area}");
}
