//! Raw meshes made by hand, for tests.

use glam::DVec3;
use smallvec::SmallVec;

use crate::field::Field;
use crate::lattice::Lattice;
use crate::mesh::{Part, PartOptions};
use crate::settings::progress::Stop;
use crate::surface::MidSurface;
use crate::surface::build::build;
use crate::surface::graph::SheetGraph;
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};
use crate::trace::feet::balls;
use crate::trace::walk::{BLOCK_BITS, Tracer};
use crate::walls::{Separation, Walls};

/// A field without triangles: no vertex has a footpoint.
pub(crate) fn no_field() -> Field {
    Field::from_triangles(Vec::new(), Vec::new(), Vec::new())
}

/// The surface that a mesh is, and its graph.
pub(crate) fn built(mesh: &MarkedMesh, field: &Field) -> (MidSurface, SheetGraph) {
    let surface = build(mesh, balls(mesh, field));
    let graph = SheetGraph::of(&surface);
    (surface, graph)
}

pub(crate) fn vertex(at: DVec3) -> MarkedVertex {
    MarkedVertex {
        at,
        walls: SmallVec::new(),
        coping: None,
    }
}

/// Triangles over positions, nothing marked.
pub(crate) fn mesh(positions: &[DVec3], triangles: &[[u32; 3]]) -> MarkedMesh {
    MarkedMesh {
        vertices: positions.iter().copied().map(vertex).collect(),
        triangles: triangles.to_vec(),
        lines: Default::default(),
    }
}

/// Marks edges by their number of triangles: one as `border`, three or more
/// as seam.
pub(crate) fn marked(mut mesh: MarkedMesh, border: Line) -> MarkedMesh {
    for (e, triangles) in mesh.edge_triangles() {
        match triangles.len() {
            1 => mesh.lines.insert(e, border),
            2 => None,
            _ => mesh.lines.insert(e, Line::Seam),
        };
    }
    mesh
}

/// Pages bound along a spine: `pages` strips of `across` by `along` quads,
/// each turned the other way than the last.
///
/// Vertex `s` of the spine is at `(0, 0, s)`; page `p` leaves it at the angle
/// `p / pages` of a turn.
pub(crate) fn book(pages: usize, across: usize, along: usize) -> MarkedMesh {
    let mut positions: Vec<DVec3> = (0..=along).map(|s| DVec3::Z * s as f64).collect();
    let mut triangles = Vec::new();
    for page in 0..pages {
        let turn = page as f64 / pages as f64 * std::f64::consts::TAU;
        let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
        let base = positions.len();
        for r in 1..=across {
            positions.extend((0..=along).map(|s| out * r as f64 + DVec3::Z * s as f64));
        }
        let at = |r: usize, s: usize| match r {
            0 => s as u32,
            _ => (base + (r - 1) * (along + 1) + s) as u32,
        };
        for r in 0..across {
            for s in 0..along {
                let q = [at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s + 1)];
                for mut t in [[q[0], q[1], q[2]], [q[0], q[2], q[3]]] {
                    if page % 2 == 1 {
                        t.swap(0, 1);
                    }
                    triangles.push(t);
                }
            }
        }
    }
    mesh(&positions, &triangles)
}

/// A closed band of `n` quads round the z axis, with so many half twists.
pub(crate) fn band(n: usize, half_twists: usize) -> MarkedMesh {
    let mut positions = Vec::new();
    for k in 0..n {
        let turn = k as f64 / n as f64 * std::f64::consts::TAU;
        let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
        let tilt = 0.5 * turn * half_twists as f64;
        let across = out * tilt.cos() + DVec3::Z * tilt.sin();
        positions.extend([3.0 * out - across, 3.0 * out + across]);
    }
    let triangles: Vec<[u32; 3]> = (0..n as u32)
        .flat_map(|k| {
            let [a, b] = [2 * k, 2 * k + 1];
            let last = k as usize + 1 == n;
            let [mut c, mut d] = if last { [0, 1] } else { [a + 2, b + 2] };
            if last && half_twists % 2 == 1 {
                std::mem::swap(&mut c, &mut d);
            }
            [[a, c, d], [a, d, b]]
        })
        .collect();
    mesh(&positions, &triangles)
}

/// A flat grid over the given abscissas and ordinates, cut along diagonals.
pub(crate) fn grid(xs: &[f64], ys: &[f64]) -> MarkedMesh {
    let positions: Vec<DVec3> = (ys.iter())
        .flat_map(|&y| xs.iter().map(move |&x| DVec3::new(x, y, 0.0)))
        .collect();
    let n = xs.len() as u32;
    let triangles: Vec<[u32; 3]> = (0..ys.len() as u32 - 1)
        .flat_map(|j| (0..n - 1).map(move |i| j * n + i))
        .flat_map(|a| [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]])
        .collect();
    mesh(&positions, &triangles)
}

/// The same mesh with vertices numbered backwards and triangles in reverse,
/// every other one turned.
pub(crate) fn shuffled(mesh: &MarkedMesh) -> MarkedMesh {
    let last = mesh.vertices.len() as u32 - 1;
    let turn = |(n, t): (usize, &[u32; 3])| {
        let [a, b, c] = t.map(|v| last - v);
        if n % 2 == 0 { [a, b, c] } else { [b, a, c] }
    };
    MarkedMesh {
        vertices: mesh.vertices.iter().rev().cloned().collect(),
        triangles: mesh.triangles.iter().enumerate().map(turn).rev().collect(),
        lines: (mesh.lines.iter())
            .map(|(e, &line)| (edge(last - e.0, last - e.1), line))
            .collect(),
    }
}

/// A part of the `fixtures` folder.
pub(crate) fn part(name: &str) -> Part {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let file = folder.join(format!("{name}.obj"));
    let loaded = crate::io::read_mesh(&file).unwrap();
    let tags = folder.join(format!("{name}.coping.txt"));
    let coping = crate::coping::read_tags(&tags, &loaded, &file).unwrap();
    Part::new(loaded.mesh, coping.flags, PartOptions::default())
        .unwrap()
        .0
}

/// The raw mesh of a part.
pub(crate) fn raw(part: &Part, field: &Field, cell: f64) -> MarkedMesh {
    let separation = Separation {
        min_angle: 15.0,
        keep_fins_from: None,
    };
    let walls = Walls::new(part, field, separation);
    let (low, high) = field.bounds();
    let lattice = Lattice::covering(low, high, cell).unwrap();
    let mut tracer = Tracer::new(&walls, lattice, BLOCK_BITS);
    tracer.run(&|_, _, _| (), &Stop::default()).unwrap();
    tracer.assemble()
}
