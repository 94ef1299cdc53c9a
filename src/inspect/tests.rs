//! Plates whose thickness is known.

use glam::DVec3;

use super::*;
use crate::mesh::{PartOptions, TriMesh};

/// A box of 12 triangles, its four narrow sides coping.
fn plate(x: f64, y: f64, z: f64) -> Part {
    let positions = (0..8)
        .map(|i| {
            let bit = |b: usize| f64::from(u8::from(i >> b & 1 == 1));
            DVec3::new(x * bit(0), y * bit(1), z * bit(2))
        })
        .collect();
    let quads: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = quads
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    let coping = (0..12).map(|t| t >= 4).collect();
    let mesh = TriMesh {
        positions,
        triangles,
    };
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

#[test]
fn a_plate_is_counted_and_measured() {
    let shape = Shape::of(&plate(20.0, 10.0, 2.0));
    assert_eq!((shape.triangles, shape.vertices), (12, 8));
    assert_eq!((shape.coping_triangles, shape.components), (8, 1));
    assert!(shape.watertight);
    assert_eq!((shape.open_edges, shape.non_manifold_edges), (0, 0));
    assert_eq!(shape.euler, 2);
    assert!((shape.volume - 400.0).abs() < 1e-9);
    assert!((shape.area - 520.0).abs() < 1e-9);
    assert!((shape.wall_area - 400.0).abs() < 1e-9);
}

#[test]
fn a_plate_is_as_thick_as_it_is() {
    let part = plate(20.0, 10.0, 2.0);
    let walls = Walls::of(&part);
    let thickness = walls.thickness(Some(2.1)).unwrap();
    for value in [
        thickness.p5,
        thickness.p50,
        thickness.p95,
        thickness.thinnest,
    ] {
        assert!((value - 2.0).abs() < 1e-9, "{value}");
    }
    let check = thickness.check.unwrap();
    assert!(!check.passed && check.share_below > 0.999);
    assert!(walls.thickness(Some(2.0)).unwrap().check.unwrap().passed);
    assert_eq!(thickness.range(), [2.1, 2.1]);
}

#[test]
fn a_map_has_numbers_on_walls_and_none_on_coping() {
    let part = plate(20.0, 10.0, 2.0);
    let map = Walls::of(&part).map();
    assert_eq!(map.thickness.len(), map.mesh.positions.len());
    assert!((map.mesh.area() - part.area()).abs() < 1e-6);
    for (at, thickness) in map.mesh.positions.chunks(3).zip(map.thickness.chunks(3)) {
        let middle = at.iter().sum::<DVec3>().z / 3.0;
        let wall = !(1e-9..=2.0 - 1e-9).contains(&middle);
        for value in thickness {
            assert!(if wall {
                (value - 2.0).abs() < 1e-9
            } else {
                value.is_nan()
            });
        }
    }
}
