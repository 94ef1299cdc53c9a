//! Models of small surfaces with known answers.

use glam::DVec3;
use smallvec::SmallVec;

use super::mass::MassProperties;
use super::*;
use crate::mesh::TriMesh;
use crate::surface::Ball;
use crate::surface::build::build;
use crate::surface::marked::{Line, MarkedMesh};
use crate::surface::shapes::{book, grid, marked};

/// The surface of a marked mesh with a ball of this thickness everywhere, whose
/// feet stand along `up`.
fn surface(mesh: MarkedMesh, thickness: f64, up: &dyn Fn(DVec3) -> Option<DVec3>) -> MidSurface {
    let mesh = marked(mesh, Line::CopingBorder);
    let ball = |at: DVec3| {
        let mut feet = SmallVec::new();
        if let Some(up) = up(at) {
            feet.extend([at + 0.5 * thickness * up, at - 0.5 * thickness * up]);
        }
        Ball {
            radius: 0.5 * thickness,
            thickness,
            footpoints: feet,
        }
    };
    let balls = mesh.vertices.iter().map(|v| ball(v.at)).collect();
    build(&mesh, balls)
}

fn plate(thickness: f64) -> MidSurface {
    surface(
        grid(&[0.0, 1.0, 3.0, 4.0], &[0.0, 1.0, 2.0]),
        thickness,
        &|_| Some(DVec3::Z),
    )
}

fn model(surface: &MidSurface, order: Order, quads: Vec<[u32; 2]>) -> ShellModel {
    let faces = Faces {
        quads,
        ..Faces::default()
    };
    let settings = ShellSettings {
        order,
        ..ShellSettings::default()
    };
    ShellModel::of(surface, &faces, &settings)
}

/// What every model holds.
fn check(model: &ShellModel) {
    for element in &model.elements {
        assert_eq!(element.nodes.len(), element.normals.len());
        assert!(matches!(element.nodes.len(), 3 | 4 | 6 | 8));
        let mut nodes = element.nodes.to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        assert_eq!(nodes.len(), element.nodes.len(), "{element:?}");
        let count = element.sides();
        for k in count..element.nodes.len() {
            let at = |k: usize| model.nodes[element.nodes[k] as usize].position;
            let middle = at(k - count).midpoint(at((k - count + 1) % count));
            assert!(middle.distance(at(k)) < 1e-12);
        }
    }
    assert!(
        model
            .normals
            .iter()
            .all(|n| (n.length() - 1.0).abs() < 1e-12)
    );
    assert!(model.leaning.is_empty());
}

#[test]
fn both_orders_of_triangles_and_quads() {
    let surface = plate(0.1);
    // The diagonals of the grid, two triangles each.
    let quads: Vec<[u32; 2]> = (0..4).map(|q| [2 * q, 2 * q + 1]).collect();
    for (order, quads, elements, nodes) in [
        (Order::Linear, vec![], 12, 12),
        (Order::Quadratic, vec![], 12, 12 + 23),
        (Order::Linear, quads.clone(), 8, 12),
        (Order::Quadratic, quads, 8, 12 + 19),
    ] {
        let model = model(&surface, order, quads);
        check(&model);
        assert_eq!((model.elements.len(), model.nodes.len()), (elements, nodes));
        // The same orientation, and the same area, however it is cut.
        let area: DVec3 = (model.elements.iter())
            .map(|e| {
                let c = model.corners(e);
                (1..c.len() - 1)
                    .map(|k| 0.5 * (c[k] - c[0]).cross(c[k + 1] - c[0]))
                    .sum::<DVec3>()
            })
            .sum();
        assert!(area.distance(8.0 * DVec3::Z) < 1e-12, "{area}");
        let border = &model.lines[0];
        assert_eq!(border.sides.len(), 10);
        assert!(
            border
                .sides
                .iter()
                .all(|s| s.1.is_some() == (order == Order::Quadratic))
        );
    }
}

#[test]
fn given_middles_stand_where_they_are_told() {
    let surface = plate(0.1);
    let place = DVec3::new(0.5, 0.0, 0.01);
    let faces = Faces {
        quads: Vec::new(),
        middles: [([0, 1], place)].into_iter().collect(),
    };
    let settings = ShellSettings {
        order: Order::Quadratic,
        ..ShellSettings::default()
    };
    let model = ShellModel::of(&surface, &faces, &settings);
    assert_eq!(
        model.nodes.iter().filter(|n| n.position == place).count(),
        1
    );
}

#[test]
fn normals_come_from_the_feet_and_not_from_slivers() {
    // One vertex is off the plane by far more than the height of its sliver.
    let mut mesh = grid(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.001, 2.0]);
    mesh.vertices[4].at.z = 0.01;
    let surface = surface(mesh, 0.5, &|_| Some(DVec3::Z));
    let model = model(&surface, Order::Linear, Vec::new());
    assert!(model.normals.iter().all(|n| n.distance(DVec3::Z) < 1e-12));
    assert!(!model.leaning.is_empty());
}

#[test]
fn sheets_keep_their_own_normals_at_a_seam() {
    // No feet are known: normals are those of the triangles.
    let surface = surface(book(3, 3, 4), 0.5, &|_| None);
    let model = model(&surface, Order::Quadratic, Vec::new());
    check(&model);
    for element in &model.elements {
        let c = model.corners(element);
        let own = (c[1] - c[0]).cross(c[2] - c[0]).normalize();
        for &n in &element.normals {
            assert!(model.normals[n as usize].distance(own) < 1e-12);
        }
    }
    // The spine has one seam, each of its nodes once.
    let seams: Vec<&LineSet> = model
        .lines
        .iter()
        .filter(|l| l.kind == SetKind::Seam)
        .collect();
    assert_eq!(seams.len(), 1);
    assert_eq!(
        (seams[0].name.as_str(), seams[0].nodes().len()),
        ("SEAM_1", 5 + 4)
    );
}

#[test]
fn normals_turn_smoothly_along_an_arc() {
    let radius = 2.0;
    let xs: Vec<f64> = (0..=12).map(|k| k as f64 / 12.0).collect();
    let mut mesh = grid(&xs, &[0.0, 0.2, 0.4]);
    for v in &mut mesh.vertices {
        let a = v.at.x;
        v.at = DVec3::new(radius * a.sin(), v.at.y, radius * a.cos());
    }
    let out = |at: DVec3| DVec3::new(at.x, 0.0, at.z).normalize();
    let surface = surface(mesh, 0.2, &|at| Some(out(at)));
    let model = model(&surface, Order::Linear, Vec::new());
    for element in &model.elements {
        for (&node, &normal) in element.nodes.iter().zip(&element.normals) {
            let exact = out(model.nodes[node as usize].position);
            // At the ends the average is one-sided, by less than the reach.
            assert!(
                model.normals[normal as usize].angle_between(exact) < 0.5 * 0.75 * 0.2 / radius
            );
        }
    }
}

#[test]
fn mass_of_a_plate_is_that_of_the_block() {
    let [a, b, t] = [4.0, 2.0, 0.3];
    let model = model(&plate(t), Order::Quadratic, Vec::new());
    let shell = MassProperties::of_shell(&model);
    let mut block = TriMesh::default();
    for z in [-0.5 * t, 0.5 * t] {
        for (x, y) in [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)] {
            block.positions.push(DVec3::new(x, y, z));
        }
    }
    for [i, j, k, l] in [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ] {
        block.triangles.extend([[i, j, k], [i, k, l]]);
    }
    let solid = MassProperties::of_solid(&block);
    let volume = a * b * t;
    let exact = [b * b + t * t, a * a + t * t, a * a + b * b].map(|s| volume / 12.0 * s);
    for mass in [shell, solid] {
        assert!((mass.volume - volume).abs() < 1e-12);
        assert!(mass.centre.distance(DVec3::new(2.0, 1.0, 0.0)) < 1e-12);
        for (k, &figure) in mass.inertia.iter().enumerate() {
            let expected = exact.get(k).copied().unwrap_or(0.0);
            assert!(
                (figure - expected).abs() < 1e-12,
                "{k}: {figure}, not {expected}"
            );
        }
    }
}

#[test]
fn placed_nodes_stand_on_the_wall_and_meet_at_a_bend() {
    let t = 0.4;
    let mut flat = model(&plate(t), Order::Linear, Vec::new());
    flat.place(1.0);
    assert!(
        flat.nodes
            .iter()
            .all(|n| (n.position.z - 0.5 * t).abs() < 1e-12)
    );
    // Two pages at a right angle, both turned to the inside.
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let meeting = super::placement::meeting(&[DVec3::X, DVec3::Y]);
    assert!(meeting.distance(at(1.0, 1.0, 0.0)) < 1e-9);
    // Three walls of a corner, and two that are almost one.
    let corner = super::placement::meeting(&[DVec3::X, DVec3::Y, DVec3::Z]);
    assert!(corner.distance(DVec3::ONE) < 1e-9);
    let tilted = at(1e-6, 0.0, 1.0).normalize();
    let almost = super::placement::meeting(&[DVec3::Z, tilted]);
    assert!(almost.distance(DVec3::Z) < 1e-5);
}

#[test]
fn sheets_fall_into_classes_by_thickness() {
    let mesh = marked(book(4, 1, 1), Line::CopingBorder);
    // Pages 0 to 3 by direction: x, y, -x, -y.
    let thickness = |at: DVec3| match at.x - 2.0 * at.y {
        s if s > 1.5 => 2.0,
        s if s > 0.5 => 1.0,
        s if s > -1.5 => 1.04,
        _ => 2.2,
    };
    let balls = (mesh.vertices.iter())
        .map(|v| Ball {
            radius: 0.5 * thickness(v.at),
            ..Ball::default()
        })
        .collect();
    let model = model(&build(&mesh, balls), Order::Linear, Vec::new());
    let sheets: Vec<Vec<u32>> = model.classes.iter().map(|c| c.sheets.clone()).collect();
    assert_eq!(sheets, [vec![0, 2], vec![3], vec![1]]);
    assert!((model.classes[0].thickness - 1.02).abs() < 1e-12);
    assert_eq!(
        model.sheets.iter().map(|s| s.class).collect::<Vec<_>>(),
        [0, 2, 0, 1]
    );
}

#[test]
fn an_unknown_thickness_is_that_of_the_neighbours() {
    let mut parts = plate(0.3).into_parts();
    parts.vertices[4].ball = Ball::default();
    parts.vertices[5].ball = Ball::default();
    let model = model(&MidSurface::new(parts).unwrap(), Order::Linear, Vec::new());
    assert_eq!(model.guessed, 2);
    assert!(
        model
            .nodes
            .iter()
            .all(|n| (n.thickness - 0.3).abs() < 1e-12)
    );
}

#[test]
fn an_excess_at_a_seam_is_fitted_to_the_elements() {
    // Pages of elements 1 long, thickness 0.4, and 0.5 at the spine.
    let mesh = marked(book(3, 2, 2), Line::CopingBorder);
    let ball = |at: DVec3| Ball {
        radius: if at.x.hypot(at.y) < 0.5 { 0.25 } else { 0.2 },
        ..Ball::default()
    };
    let surface = build(&mesh, mesh.vertices.iter().map(|v| ball(v.at)).collect());
    let model = model(&surface, Order::Linear, Vec::new());
    for node in &model.nodes {
        let spine = node.position.x.hypot(node.position.y) < 0.5;
        let excess = node.thickness - 0.4;
        // 0.3 of 0.4 over a mean distance between 1 and the diagonal's.
        let fits = if spine {
            (0.0085..=0.0121).contains(&excess)
        } else {
            excess.abs() < 1e-12
        };
        assert!(fits, "{node:?}");
    }
}

#[test]
fn feet_of_another_wall_do_not_turn_a_sheet() {
    // As at straight junctions: the spine's feet are those of the first page.
    let spine = |at: DVec3| (at.x.hypot(at.y) < 0.5).then_some(DVec3::Y);
    let surface = surface(book(4, 2, 3), 0.4, &spine);
    let model = model(&surface, Order::Linear, Vec::new());
    check(&model);
}

#[test]
fn a_sharp_bend_is_a_crease_even_if_nobody_marked_it() {
    let mut mesh = grid(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0]);
    for v in mesh.vertices.iter_mut().filter(|v| v.at.x > 1.5) {
        v.at = DVec3::new(1.0, v.at.y, 1.0);
    }
    let surface = surface(mesh, 1.0, &|_| None);
    let model = model(&surface, Order::Linear, Vec::new());
    check(&model);
    assert!(model.lines.iter().all(|l| l.kind != SetKind::Crease));
}
