//! All small cases, and noise.

use glam::{DVec3, IVec3};

use super::*;
use crate::mesh::{Bounds, self_intersections};
use crate::settings::precision::Precision;

/// Trilinear interpolation of values at the grid's nodes.
struct Nodes {
    grid: Grid,
    values: Vec<f64>,
}

impl Nodes {
    /// Values in cells; nodes at the grid's rim are outside.
    fn new(side: usize, value: impl Fn(IVec3) -> f64) -> Nodes {
        let bounds = Bounds::of([DVec3::ZERO, DVec3::splat(side as f64 - 1.0)]);
        let grid = Grid::around(&bounds, 1.0, Precision::Double).unwrap();
        let nodes = grid.cells() + 1;
        let mut values = Vec::new();
        for z in 0..nodes.z {
            for y in 0..nodes.y {
                for x in 0..nodes.x {
                    let at = IVec3::new(x, y, z);
                    let rim = at.cmplt(IVec3::splat(2)).any() || at.cmpge(nodes - 2).any();
                    values.push(if rim { 0.3 } else { value(at - 2) });
                }
            }
        }
        Nodes { grid, values }
    }

    fn value(&self, p: DVec3) -> f64 {
        let low = self.grid.node(IVec3::ZERO);
        let nodes = self.grid.cells() + 1;
        let q = (p - low).clamp(DVec3::ZERO, (nodes - 1).as_dvec3() - 1e-9);
        let base = q.floor().as_ivec3();
        let f = q - q.floor();
        let mut sum = 0.0;
        for corner in 0..8 {
            let step = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let at = base + step;
            let weight = (DVec3::ONE - f + step.as_dvec3() * (2.0 * f - 1.0)).element_product();
            sum += weight * self.values[(at.x + nodes.x * (at.y + nodes.y * at.z)) as usize];
        }
        sum
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let slope = |axis: DVec3| self.value(p + 1e-6 * axis) - self.value(p - 1e-6 * axis);
        DVec3::from_array(DVec3::AXES.map(slope)).normalize_or(DVec3::Z)
    }
}

impl Implicit for Nodes {
    fn sample(&self, p: DVec3, _: u32) -> Sample {
        let value = self.value(p);
        Sample {
            value,
            gradient: self.gradient(p),
            unsigned: value.abs(),
            element: 0,
        }
    }

    fn element(&self, p: DVec3, _: u32) -> (f64, DVec3) {
        (self.value(p), self.gradient(p))
    }

    fn crossing(&self, ends: [DVec3; 2], _: [Sample; 2]) -> Crossing {
        let [a, b] = ends.map(|p| self.value(p));
        Crossing {
            t: a / (a - b),
            element: 0,
            splits: 0,
            queries: 0,
        }
    }
}

/// Closed, manifold at edges and vertices, free of intersections.
fn check(mesh: &TriMesh, what: &str) {
    let uses = mesh.edges();
    for uses in uses.by_edge() {
        assert_eq!(uses.len(), 2, "{what}: an edge of {} triangles", uses.len());
    }
    assert!(uses.census().is_closed(), "{what}: not closed");
    // One fan a vertex: as many triangles as in a walk around it.
    let mut next = rustc_hash::FxHashMap::default();
    let mut degree = vec![0; mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
            next.insert((a, b), c);
            degree[a as usize] += 1;
        }
    }
    for &[a, b, _] in &mesh.triangles {
        let mut at = next[&(a, b)];
        let mut steps = 1;
        while at != b {
            at = next[&(a, at)];
            steps += 1;
        }
        assert_eq!(steps, degree[a as usize], "{what}: two fans at a vertex");
    }
    let pairs = self_intersections(mesh);
    assert!(pairs.is_empty(), "{what}: {} pairs cut", pairs.len());
}

fn contoured(nodes: &Nodes, tolerance: f64) -> TriMesh {
    let settings = Settings {
        tolerance,
        filters: Filters::default(),
    };
    contour(
        nodes,
        &nodes.grid,
        &settings,
        &|_, _, _| {},
        &Stop::default(),
    )
    .unwrap()
    .mesh
}

/// A number between 0 and 1 that looks like noise.
fn noise(seed: u64, at: IVec3) -> f64 {
    let mut x = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((at.x as u64) << 40 ^ (at.y as u64) << 20 ^ at.z as u64);
    for _ in 0..3 {
        x ^= x >> 31;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// Every pattern of one cell's corners, with crossings anywhere.
#[test]
fn all_patterns() {
    for corners in 1..=255 {
        for seed in 0..3 {
            let nodes = Nodes::new(6, |at| {
                let c = at - 2;
                let inside = c.cmpge(IVec3::ZERO).all()
                    && c.cmple(IVec3::ONE).all()
                    && corners >> (c.x + 2 * c.y + 4 * c.z) & 1 != 0;
                let size = 0.02 + 0.28 * noise(seed, at);
                if inside { -size } else { size }
            });
            for tolerance in [f64::INFINITY, 1e-6] {
                let mesh = contoured(&nodes, tolerance);
                check(
                    &mesh,
                    &format!("corners {corners:#b}, seed {seed}, {tolerance}"),
                );
                assert!(mesh.volume() > 0.0);
            }
        }
    }
}

/// Sides at random: half of the faces are ambiguous, most cells have several
/// loops.
#[test]
fn noise_everywhere() {
    for seed in 0..6 {
        for share in [0.2, 0.5, 0.8] {
            let nodes = Nodes::new(9, |at| {
                let size = 0.003 + 0.3 * noise(seed + 100, at).powi(3);
                if noise(seed, at) < share { -size } else { size }
            });
            for tolerance in [f64::INFINITY, 1e-6] {
                let mesh = contoured(&nodes, tolerance);
                check(&mesh, &format!("seed {seed}, share {share}, {tolerance}"));
            }
        }
    }
}

#[test]
fn nothing_inside_gives_no_triangles() {
    let mesh = contoured(&Nodes::new(5, |_| 0.3), 1e-3);
    assert!(mesh.triangles.is_empty() && mesh.positions.is_empty());
}

/// A function that changes at random between nodes, by far more than the way.
struct Liar(Grid);

impl Implicit for Liar {
    fn sample(&self, p: DVec3, _: u32) -> Sample {
        let value = 4.0 * noise(7, (p * 1e4).as_ivec3()) - 1.0;
        Sample {
            value,
            gradient: DVec3::X,
            unsigned: value.abs(),
            element: 0,
        }
    }

    fn element(&self, p: DVec3, _: u32) -> (f64, DVec3) {
        (self.sample(p, 0).value, DVec3::X)
    }

    fn crossing(&self, _: [DVec3; 2], _: [Sample; 2]) -> Crossing {
        Crossing {
            t: 0.5,
            element: 0,
            splits: 0,
            queries: 0,
        }
    }
}

#[test]
fn contradictions_leave_no_hole() {
    let bounds = Bounds::of([DVec3::ZERO, DVec3::splat(24.0)]);
    let liar = Liar(Grid::around(&bounds, 1.0, Precision::Double).unwrap());
    // Any number of cells will do for a box.
    for (octree, box_cells) in [
        (false, 32),
        (true, 32),
        (true, 0),
        (true, 12),
        (true, i32::MAX),
    ] {
        let settings = Settings {
            tolerance: 1e-3,
            filters: Filters {
                box_cells,
                octree,
                ..Filters::default()
            },
        };
        let result = contour(&liar, &liar.0, &settings, &|_, _, _| {}, &Stop::default()).unwrap();
        assert!(result.mesh.triangles.len() > 1000);
        check(&result.mesh, "liar");
    }
}
