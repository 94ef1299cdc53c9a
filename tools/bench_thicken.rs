//! Thickening: the columns of the paper's Table 1 (Wang and Chen, "Thickening
//! Freeform Surfaces for Solid Fabrication") for surfaces of the same numbers of
//! triangles and the same thicknesses in mean edge lengths.
//!
//! `cargo bench --bench thicken`. The paper's surfaces are not public; these are
//! a coiled strip for the pig's tail, a bumpy sheet for the face, and bumpy
//! spheres with an opening for the rest. Times depend on how much area a box of
//! 128 or 256 cells holds, so only the order of magnitude compares. The paper ran
//! on four cores; threads here are as RAYON_NUM_THREADS says. Contour and
//! join stand for the paper's faces, join with the search for
//! self-intersections; sharp, with that search again, stands for its shape.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use glam::DVec3;
use midsurf::mesh::TriMesh;
use midsurf::thicken::{Settings, Side, thicken};

/// Name, triangles, thickness in mean edges; paper's seconds for grid, faces
/// and shape at 128 cells, then at 256.
type Row = (&'static str, usize, f64, [f64; 3], [f64; 3]);

const TABLE: [Row; 6] = [
    (
        "helmet",
        10_822,
        -2.5,
        [1.03, 1.16, 1.33],
        [6.07, 4.93, 5.37],
    ),
    (
        "pig-tail",
        204,
        0.5,
        [0.310, 0.180, 0.460],
        [1.87, 0.980, 1.95],
    ),
    (
        "face",
        23_154,
        2.5,
        [0.983, 0.499, 0.734],
        [5.74, 2.06, 2.79],
    ),
    (
        "femur",
        8_856,
        2.5,
        [1.28, 0.552, 0.828],
        [8.04, 2.52, 3.31],
    ),
    (
        "sculpture",
        57_396,
        3.0,
        [0.954, 0.538, 0.479],
        [5.15, 1.92, 1.59],
    ),
    (
        "repaired",
        134_136,
        3.0,
        [0.850, 0.654, 0.743],
        [4.29, 2.21, 2.33],
    ),
];

fn main() {
    // Neither tests nor a mere listing of them.
    if !std::env::args().any(|arg| arg == "--bench") {
        return;
    }
    println!(
        "{:10} {:>9} {:>9} {:>5} | {:>8} {:>8} {:>8} {:>8} | {:>23} | {:>9} {:>9} {:>5}",
        "surface",
        "triangles",
        "thickness",
        "cells",
        "grid",
        "contour",
        "join",
        "sharp",
        "paper: grid faces shape",
        "result",
        "shell off",
        "sound"
    );
    for (name, triangles, edges, coarse, fine) in TABLE {
        let patch = stand_in(name, triangles);
        let thickness = edges.abs() * mean_edge(&patch);
        let side = if edges < 0.0 {
            Side::Inner
        } else {
            Side::Outer
        };
        for (cells, paper) in [(128.0, coarse), (256.0, fine)] {
            let size = patch.bounds().size().max_element() + 2.0 * thickness;
            let settings = Settings {
                cell: size / cells,
                ..Settings::new(thickness, side)
            };
            print!(
                "{name:10} {:>9} {edges:>9} {cells:>5} | ",
                patch.triangles.len()
            );
            let start = Instant::now();
            match thicken(&patch, &settings, &|_, _, _| ()) {
                Ok(r) => println!(
                    "{:>8.3} {:>8.3} {:>8.3} {:>8.3} | {:>7} {:>7} {:>7} | {:>9} {:>8.4}% {:>5}  ({:.2} s in all)",
                    r.work.band_seconds,
                    r.work.contour_seconds,
                    r.join_seconds,
                    r.sharpen_seconds,
                    paper[0],
                    paper[1],
                    paper[2],
                    r.mesh.triangles.len(),
                    100.0 * r.deviation.mean / thickness,
                    r.is_sound(),
                    start.elapsed().as_secs_f64()
                ),
                Err(error) => println!("{error}"),
            }
        }
    }
}

fn mean_edge(mesh: &TriMesh) -> f64 {
    let edges = mesh.edges();
    let lengths = edges.by_edge().map(|uses| {
        let [a, b] = uses[0].edge.map(|v| mesh.positions[v as usize]);
        a.distance(b)
    });
    let (sum, count) = lengths.fold((0.0, 0), |(s, n), l| (s + l, n + 1));
    sum / f64::from(count)
}

fn stand_in(name: &str, triangles: usize) -> TriMesh {
    match name {
        "pig-tail" => sheet(triangles / 4, 2, |u, v| {
            let (a, d) = (1.5 * TAU * u, 1.0 + 0.4 * (v - 0.5));
            DVec3::new(d * a.cos(), d * a.sin(), 1.2 * u)
        }),
        "face" => {
            let n = ((triangles / 2) as f64).sqrt().round() as usize;
            sheet(n, n, |u, v| {
                let z = 0.12 * (5.0 * u).sin() * (4.0 * v).cos()
                    - 0.3 * ((u - 0.5).powi(2) + (v - 0.5).powi(2));
                DVec3::new(u, v, z)
            })
        }
        _ => {
            let n = ((triangles / 4) as f64).sqrt().round() as usize;
            let open = if name == "helmet" { 0.5 } else { 0.15 };
            // Seamless around; parted at both poles.
            let place = |u: f64, v: f64| {
                let (a, t) = (TAU * u, PI * (0.06 + (0.94 - open) * v));
                let d = 1.0 + 0.06 * (3.0 * a).sin() * (4.0 * t).sin();
                DVec3::new(d * t.sin() * a.cos(), d * t.sin() * a.sin(), d * t.cos())
            };
            let mut mesh = sheet(2 * n, n, |u, v| place(if u == 1.0 { 0.0 } else { u }, v));
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            mesh
        }
    }
}

/// A grid of squares, halved.
fn sheet(nu: usize, nv: usize, place: impl Fn(f64, f64) -> DVec3) -> TriMesh {
    let id = |i: usize, j: usize| (i * (nv + 1) + j) as u32;
    let mut mesh = TriMesh::default();
    for i in 0..=nu {
        for j in 0..=nv {
            mesh.positions
                .push(place(i as f64 / nu as f64, j as f64 / nv as f64));
        }
    }
    for i in 0..nu {
        for j in 0..nv {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            mesh.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    mesh
}
