//! Solids and sheets that nobody would draw, out of any bytes.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use midsurf::mesh::TriMesh;

/// A mesh, its tags, and numbers to choose settings by.
#[derive(Debug)]
pub struct Case {
    pub mesh: TriMesh,
    pub coping: Vec<bool>,
    /// Between 0 and 1.
    pub choice: f64,
}

/// Bytes one by one, zeros after the end.
struct Draw<'a>(std::slice::Iter<'a, u8>);

impl Draw<'_> {
    fn new(bytes: &[u8]) -> Draw<'_> {
        Draw(bytes.iter())
    }

    fn byte(&mut self) -> u8 {
        self.0.next().copied().unwrap_or(0)
    }

    fn below(&mut self, bound: u8) -> u8 {
        self.byte() % bound
    }

    /// From 0 to 1.
    fn share(&mut self) -> f64 {
        f64::from(self.byte()) / 255.0
    }

    /// A length that is often equal to others drawn, or nearly.
    fn length(&mut self) -> f64 {
        let whole = f64::from(self.below(5));
        let near = [0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.3];
        whole
            + near[usize::from(self.below(8))]
                * if self.byte().is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
    }

    /// Plain three times of four.
    fn turn(&mut self) -> DQuat {
        let by = if self.below(4) == 0 {
            6.0 * self.share()
        } else {
            0.0
        };
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), by)
    }
}

/// A solid: a union of cubes, or boxes that overlap, touch and nearly touch, with
/// slivers, somewhere, turned.
pub fn solid(bytes: &[u8]) -> Case {
    let mut draw = Draw::new(bytes);
    let turn = draw.turn();
    let choice = draw.share();
    let shift = [0.0, 0.0, 1e3, 1e6][usize::from(draw.below(4))];
    let mut mesh = if draw.byte().is_multiple_of(2) {
        let thin = [1.0, 0.2, 0.05, 1e-3][usize::from(draw.below(4))];
        let mut bits = (0..4).map(|_| draw.byte()).collect::<Vec<u8>>();
        bits[0] |= 1;
        let filled: Vec<bool> = (0..27).map(|k| bits[k / 8] >> (k % 8) & 1 == 1).collect();
        voxels(&filled, DVec3::new(1.0, thin, 1.0))
    } else {
        boxes(&mut draw)
    };
    if draw.byte() % 4 == 1 {
        splinter(&mut mesh, &mut draw);
    }
    for p in &mut mesh.positions {
        *p = turn * *p + DVec3::splat(shift);
    }
    let coping = mesh.triangles.iter().map(|_| draw.below(4) == 1).collect();
    Case {
        mesh,
        coping,
        choice,
    }
}

/// A surface with boundary: a grid of heights with holes.
pub fn sheet(bytes: &[u8]) -> Case {
    let mut draw = Draw::new(bytes);
    let choice = draw.share();
    let side = 2 + usize::from(draw.below(4));
    let row = side + 1;
    let rough = [0.0, 0.05, 0.3, 1.0][usize::from(draw.below(4))];
    let mut mesh = TriMesh::default();
    for k in 0..row * row {
        let (x, y) = ((k % row) as f64, (k / row) as f64);
        let height = rough * (2.0 * draw.share() - 1.0);
        mesh.positions.push(DVec3::new(x, y, height));
    }
    for k in 0..side * side {
        let at = (k / side * row + k % side) as u32;
        let [a, b, c, d] = [at, at + 1, at + 1 + row as u32, at + row as u32];
        match draw.below(8) {
            0 if k > 0 => {}
            1 => mesh.triangles.extend([[a, b, d], [b, c, d]]),
            2 => mesh.triangles.push([a, b, c]),
            _ => mesh.triangles.extend([[a, b, c], [a, c, d]]),
        }
    }
    let coping = vec![false; mesh.triangles.len()];
    Case {
        mesh,
        coping,
        choice,
    }
}

/// A solid with faults: triangles lost, doubled, turned, corners moved a little,
/// or each triangle with vertices of its own.
pub fn soup(bytes: &[u8]) -> Case {
    let (shape, faults) = bytes.split_at(bytes.len() / 2);
    let mut case = solid(shape);
    let mut draw = Draw::new(faults);
    let mesh = &mut case.mesh;
    if draw.byte() % 2 == 1 {
        let corners = mesh.triangles.iter().flatten();
        mesh.positions = corners.map(|&v| mesh.positions[v as usize]).collect();
        let count = mesh.triangles.len() as u32;
        mesh.triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    }
    for _ in 0..draw.below(6) {
        let at = usize::from(draw.byte()) % mesh.triangles.len();
        let [a, b, c] = mesh.triangles[at];
        match draw.below(6) {
            0 if mesh.triangles.len() > 1 => {
                mesh.triangles.remove(at);
            }
            1 => mesh.triangles.push([a, b, c]),
            2 => mesh.triangles.push([b, a, c]),
            3 => mesh.triangles[at] = [b, a, c],
            4 => {
                // A vertex on an edge, of one side only.
                let middle = 0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]);
                mesh.positions.push(middle);
                let m = mesh.positions.len() as u32 - 1;
                mesh.triangles[at] = [a, m, c];
                mesh.triangles.push([m, b, c]);
            }
            _ => mesh.positions[a as usize].x += 1e-9 * draw.length(),
        }
    }
    case.coping = vec![false; case.mesh.triangles.len()];
    case
}

/// Some boxes, each with vertices of its own.
fn boxes(draw: &mut Draw) -> TriMesh {
    let mut mesh = TriMesh::default();
    for _ in 0..=draw.below(4) {
        let first = mesh.positions.len() as u32;
        let at = DVec3::new(draw.length(), draw.length(), draw.length());
        let size = DVec3::new(draw.length(), draw.length(), draw.length());
        let size = size.abs().max(DVec3::splat(1e-3));
        let corner = |k: u32| DVec3::new((k & 1).into(), (k >> 1 & 1).into(), (k >> 2).into());
        mesh.positions.extend((0..8).map(|k| at + size * corner(k)));
        let quads: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        for quad in quads {
            let [a, b, c, d] = quad.map(|v| v + first);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Splits a triangle and its neighbour beside a point very close to a corner.
fn splinter(mesh: &mut TriMesh, draw: &mut Draw) {
    let at = usize::from(draw.byte()) % mesh.triangles.len();
    let [a, b, c] = mesh.triangles[at];
    let share = [0.5, 1e-3, 1e-7, 1e-12][usize::from(draw.below(4))];
    let beside = |v: u32, w: u32, mesh: &TriMesh| {
        mesh.positions[v as usize].lerp(mesh.positions[w as usize], share)
    };
    let other = mesh.triangles.iter().position(|t| {
        let runs = [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        runs.contains(&(b, a))
    });
    let Some(other) = other else { return };
    let Some(d) = mesh.triangles[other]
        .into_iter()
        .find(|v| *v != a && *v != b)
    else {
        return;
    };
    mesh.positions.push(beside(a, b, mesh));
    let m = mesh.positions.len() as u32 - 1;
    mesh.triangles[at] = [a, m, c];
    mesh.triangles[other] = [b, m, d];
    mesh.triangles.extend([[m, b, c], [m, a, d]]);
}

/// Union of unit cubes of a 3 x 3 x 3 block, one triangle pair a face that bounds
/// it, stretched; edges where cubes touch alone have four triangles.
pub fn voxels(filled: &[bool], size: DVec3) -> TriMesh {
    let at = |x: i32, y: i32, z: i32| {
        let inside = [x, y, z].iter().all(|k| (0..3).contains(k));
        inside && filled[(x + 3 * y + 9 * z) as usize]
    };
    let mut mesh = TriMesh::default();
    let mut node = BTreeMap::new();
    for (k, _) in filled.iter().enumerate().filter(|(_, full)| **full) {
        let cell = [k as i32 % 3, k as i32 / 3 % 3, k as i32 / 9];
        for axis in 0..3 {
            for side in [0, 1] {
                let mut over = cell;
                over[axis] += 2 * side - 1;
                if at(over[0], over[1], over[2]) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |du: i32, dv: i32| {
                    let mut p = cell;
                    p[axis] += side;
                    p[u] += du;
                    p[v] += dv;
                    p
                };
                let mut ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side == 0 {
                    ring.reverse();
                }
                let [a, b, c, d] = ring.map(|p| {
                    *node.entry(p).or_insert_with(|| {
                        let at = DVec3::new(p[0].into(), p[1].into(), p[2].into());
                        mesh.positions.push(size * at);
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}
