//! The rooms of the thickening one by one; whole solids are in `tests/it`.

use glam::DVec3;

use crate::dual_contour::Implicit;
use crate::mesh::TriMesh;

use super::ThickenError;
use super::cut::cut;
use super::patch::{OnRim, Patch};
use super::solid::ThickSolid;

/// Two squares of side 4 that meet at x = 0: one in the plane z = 0, the other
/// below it in the plane x = 0. The solid is below and beside them.
fn ell() -> TriMesh {
    TriMesh {
        positions: [
            [4., 0., 0.],
            [4., 4., 0.],
            [0., 4., 0.],
            [0., 0., 0.],
            [0., 4., -4.],
            [0., 0., -4.],
        ]
        .map(DVec3::from)
        .to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]],
    }
}

fn turned(mut mesh: TriMesh) -> TriMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// Points of a grid around the ell, off all its planes.
fn around() -> impl Iterator<Item = DVec3> {
    let step = |i: i32| -2.03 + 0.37 * f64::from(i);
    (0..22).flat_map(move |i| {
        (0..22).flat_map(move |j| (0..22).map(move |k| DVec3::new(step(i), step(j), -step(k))))
    })
}

#[test]
fn the_boundary_of_an_ell() {
    let patch = Patch::new(ell()).unwrap();
    assert_eq!(patch.rim.loops, [[0, 6]]);
    for e in &patch.rim.edges {
        assert!(e.outward.dot(e.down).abs() < 1e-12);
        assert!((e.outward.length() - 1.0).abs() < 1e-12);
    }
    // The solid is inside the fold: nothing opens.
    assert!(patch.rim.sectors.is_empty());
    let other = Patch::new(turned(ell())).unwrap();
    assert_eq!(other.rim.sectors.len(), 2);
    for sector in &other.rim.sectors {
        assert_eq!(sector.outward.abs(), DVec3::Y);
    }
}

#[test]
fn feet_know_side_and_boundary() {
    let patch = Patch::new(ell()).unwrap();
    let foot = patch.foot(DVec3::new(1.0, 2.0, -0.5), 0);
    assert!(foot.side < 0.0 && foot.rim.is_none() && foot.distance == 0.5);
    let foot = patch.foot(DVec3::new(-1.0, 2.0, 1.0), 0);
    assert!(foot.side > 0.0 && foot.rim.is_none());
    let foot = patch.foot(DVec3::new(2.0, -1.0, -1.0), 3);
    assert!(matches!(foot.rim, Some(OnRim::Edge(_))));
    let foot = patch.foot(DVec3::new(5.0, -1.0, -1.0), 3);
    assert_eq!(foot.rim, Some(OnRim::Vertex(0)));
}

#[test]
fn the_function_has_the_sign_of_definition_2() {
    let r = 1.5;
    let patch = Patch::new(ell()).unwrap();
    let inner = ThickSolid::new(&patch, r, 0.3);
    let other = Patch::new(turned(ell())).unwrap();
    let outer = ThickSolid::new(&other, r, 0.3);
    for p in around() {
        let across = p.y > 0.0 && p.y < 4.0;
        let (under, beside) = (-p.z, p.x);
        // Over the fold the nearer plane has the foot.
        let in_corner = under > 0.0 && beside > 0.0;
        let near = under.min(beside);
        let far = under.max(beside);
        let expected = across && in_corner && near <= r && far < 4.0;
        let sample = inner.sample(p, 0);
        assert_eq!(sample.value < 0.0, expected, "{p} {sample:?}");

        let (above, behind) = (p.z, -p.x);
        let expected = across
            && match (above > 0.0, behind > 0.0) {
                (true, true) => above.hypot(behind) <= r,
                (true, false) => above <= r && p.x < 4.0,
                (false, true) => behind <= r && p.z > -4.0,
                (false, false) => false,
            };
        let sample = outer.sample(p, 0);
        assert_eq!(sample.value < 0.0, expected, "{p} {sample:?}");
    }
}

#[test]
fn nodes_near_the_surface_are_never_left_out() {
    let (r, cell) = (1.5, 0.37);
    let patch = Patch::new(ell()).unwrap();
    let solid = ThickSolid::new(&patch, r, cell);
    for p in around() {
        let here = solid.sample(p, 0);
        for axis in DVec3::AXES {
            let there = solid.sample(p + cell * axis, 0);
            if (here.value < 0.0) != (there.value < 0.0) {
                assert!(here.value.abs() <= cell && there.value.abs() <= cell);
            }
        }
    }
}

#[test]
fn elements_meet_the_surface_where_an_edge_crosses_it() {
    let (r, cell) = (1.5, 0.37);
    let patch = Patch::new(ell()).unwrap();
    let solid = ThickSolid::new(&patch, r, cell);
    for p in around() {
        for axis in DVec3::AXES {
            let ends = [p, p + cell * axis];
            let samples = ends.map(|p| solid.sample(p, 0));
            if (samples[0].value < 0.0) == (samples[1].value < 0.0) {
                continue;
            }
            let crossing = solid.crossing(ends, samples);
            let at = ends[0].lerp(ends[1], crossing.t);
            let (value, normal) = solid.element(at, crossing.element);
            assert!(value.abs() < 1e-9, "{at} {crossing:?} {value}");
            assert!((normal.length() - 1.0).abs() < 1e-9);
            let just = solid.sample(at + 1e-6 * normal, 0).value;
            assert!(just >= 0.0, "{at} {normal}");
        }
    }
}

#[test]
fn a_cut_leaves_one_curve() {
    // An octahedron, cut between its lower corner and the rest.
    let mesh = TriMesh {
        positions: vec![
            DVec3::X,
            DVec3::Y,
            -DVec3::X,
            -DVec3::Y,
            DVec3::Z,
            -DVec3::Z,
        ],
        triangles: (0..4)
            .flat_map(|i| {
                let j = (i + 1) % 4;
                [[i, j, 4], [j, i, 5]]
            })
            .collect(),
    };
    let heights: Vec<f64> = mesh.positions.iter().map(|p| 1.0 + p.z).collect();
    let mut half = cut(&mesh, &heights, 0.5);
    assert_eq!(half.curves.len(), 1);
    assert_eq!(half.curves[0].len(), 4);
    assert_eq!(half.mesh.edges().census().open, 4);
    assert_eq!(half.mesh.edges().census().misoriented, 0);
    for &v in &half.curves[0] {
        assert_eq!(half.mesh.positions[v as usize].z, -0.5);
    }
    let kept = half.merge(0, |i, j| (i, j) == (1, 2));
    assert_eq!(kept, [0, 1, 3]);
    assert_eq!(half.mesh.edges().census().open, 3);

    assert!(cut(&mesh, &heights, 3.0).mesh.triangles.is_empty());
    assert!(cut(&mesh, &heights, -1.0).curves.is_empty());
}

#[test]
fn surfaces_that_are_no_patch_are_told_why() {
    let mut mesh = ell();
    mesh.triangles[1].swap(0, 1);
    assert!(matches!(Patch::new(mesh), Err(ThickenError::Sides(_))));
    let mut mesh = ell();
    mesh.triangles.push([3, 2, 1]);
    assert!(matches!(
        Patch::new(mesh),
        Err(ThickenError::NotManifold { triangles: 3, .. })
    ));
}
