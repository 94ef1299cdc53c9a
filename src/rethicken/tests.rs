use glam::DVec3;

use super::*;
use crate::mesh::self_intersections;

/// A rectangle of 2 x n x m triangles in the plane z = 0, radius by place.
fn sheet(size: [f64; 2], n: [u32; 2], radius: impl Fn(DVec3) -> f64) -> (Vec<DVec3>, Vec<f64>, Vec<[u32; 3]>) {
    let (nx, ny) = (n[0], n[1]);
    let at = |i: u32, j: u32| {
        DVec3::new(size[0] * f64::from(i) / f64::from(nx), size[1] * f64::from(j) / f64::from(ny), 0.0)
    };
    let positions: Vec<DVec3> = (0..=ny).flat_map(|j| (0..=nx).map(move |i| at(i, j))).collect();
    let radii = positions.iter().map(|&p| radius(p)).collect();
    let v = |i: u32, j: u32| j * (nx + 1) + i;
    let triangles = (0..ny)
        .flat_map(|j| (0..nx).flat_map(move |i| {
            let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
            [[a, b, c], [a, c, d]]
        }))
        .collect();
    (positions, radii, triangles)
}

fn solid_of(surface: &BallSurface, cell: f64) -> TriMesh {
    let settings = Settings { cell, ..Settings::new(surface) };
    let mesh = rethicken(surface, &settings, &|_, _, _| ()).unwrap().mesh;
    assert!(self_intersections(&mesh).is_empty());
    mesh
}

#[test]
fn a_sheet_with_flat_borders_is_a_box() {
    let (p, r, t) = sheet([7.0, 5.0], [9, 6], |_| 1.0);
    let surface = BallSurface::new(p, r, t, |_| true).unwrap();
    let mesh = solid_of(&surface, 0.6);
    let bounds = mesh.bounds();
    let (low, high) = (DVec3::new(0.0, 0.0, -1.0), DVec3::new(7.0, 5.0, 1.0));
    assert!((bounds.min - low).length() < 1e-9 && (bounds.max - high).length() < 1e-9, "{bounds:?}");
    assert!((mesh.volume() - 70.0).abs() < 1e-6, "{}", mesh.volume());
}

#[test]
fn a_sheet_with_round_borders_is_a_pad() {
    let (p, r, t) = sheet([7.0, 5.0], [3, 2], |_| 1.0);
    let surface = BallSurface::new(p, r, t, |_| false).unwrap();
    let mesh = solid_of(&surface, 0.3);
    let pi = std::f64::consts::PI;
    let volume = 70.0 + 12.0 * pi + 4.0 / 3.0 * pi;
    assert!((mesh.volume() / volume - 1.0).abs() < 5e-3, "{} {volume}", mesh.volume());
}
