//! Limit points (2.2) and unit normals (2.3) of control vertices.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::refine::{Boundary, Quads, boundary_neighbours};

/// Limit point and normal of every control vertex.
#[derive(Clone, Debug)]
pub(super) struct Corners {
    pub limits: Vec<DVec3>,
    /// Unit, outward.
    pub normals: Vec<DVec3>,
    /// Vertices whose normal is an average of others', ascending.
    pub averaged: Vec<u32>,
    /// Vertices for which even that gave none; their normal is zero.
    pub missing: Vec<u32>,
}

impl Corners {
    pub fn new(mesh: &Quads, boundary: Boundary) -> Corners {
        let cage = mesh.cage();
        let vertices = cage.positions().len() as u32;
        let limits = (0..vertices)
            .into_par_iter()
            .map(|v| limit(mesh, v, boundary))
            .collect();
        let span = cage
            .positions()
            .iter()
            .fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
        let known: Vec<Option<DVec3>> = (0..vertices)
            .into_par_iter()
            .map(|v| normal(mesh, v, span))
            .collect();
        let (normals, averaged, missing) = fill(mesh, known);
        Corners {
            limits,
            normals,
            averaged,
            missing,
        }
    }
}

/// Limit point of a vertex: (2.2), which is (N V + 4 E + F) / (N + 5) with the
/// means E and F. On the boundary that of the curve.
fn limit(mesh: &Quads, vertex: u32, boundary: Boundary) -> DVec3 {
    let cage = mesh.cage();
    let p = cage.position(vertex);
    let degree = cage.degree(vertex);
    if cage.on_boundary(vertex) {
        if boundary.holds(degree) {
            return p;
        }
        let [first, last] = boundary_neighbours(cage, vertex);
        return (4.0 * p + first + last) / 6.0;
    }
    let (mut edges, mut faces) = (DVec3::ZERO, DVec3::ZERO);
    for h in cage.fan(vertex) {
        edges += cage.position(cage.end(h));
        faces += cage.position(cage.origin(cage.next(cage.next(h))));
    }
    let n = f64::from(degree);
    (n * n * p + 4.0 * edges + faces) / (n * (n + 5.0))
}

/// Unit normal of a vertex by (2.3), from the two tangents in closed form;
/// none where they vanish or are parallel.
///
/// The boundary tangents are those of the boundary curve and, across, of the
/// eigenvector of a fan of `n` faces.
fn normal(mesh: &Quads, vertex: u32, span: f64) -> Option<DVec3> {
    let cage = mesh.cage();
    let p = cage.position(vertex);
    let mut edges: Vec<DVec3> = Vec::with_capacity(8);
    let mut faces: Vec<DVec3> = Vec::with_capacity(8);
    for h in cage.fan(vertex) {
        edges.push(cage.position(cage.end(h)) - p);
        faces.push(cage.position(cage.origin(cage.next(cage.next(h)))) - p);
        if cage.on_boundary(vertex) && edges.len() == cage.degree(vertex) as usize {
            edges.push(cage.position(cage.origin(cage.prev(h))) - p);
        }
    }
    // All relative to the vertex itself: the weights of a tangent sum to 0, so
    // the vertex drops out and far-off parts lose no digits.
    let n = faces.len();
    let wide = n as f64;
    let (mut t1, mut t2) = (DVec3::ZERO, DVec3::ZERO);
    if !cage.on_boundary(vertex) {
        let turn = 2.0 * PI / wide;
        let a = 1.0 + turn.cos() + (PI / wide).cos() * (2.0 * (9.0 + turn.cos())).sqrt();
        for i in 0..n {
            let (s0, c0) = (turn * i as f64).sin_cos();
            let (s1, c1) = (turn * (i + 1) as f64).sin_cos();
            t1 += a * c0 * edges[i] + (c0 + c1) * faces[i];
            t2 += a * s0 * edges[i] + (s0 + s1) * faces[i];
        }
    } else if n == 1 {
        (t1, t2) = (edges[0], edges[1]);
    } else {
        let turn = PI / wide;
        let (sin, cos) = turn.sin_cos();
        let r = (cos + 1.0) / sin;
        t1 = edges[0] - edges[n];
        t2 = -r * (1.0 + 2.0 * cos) * (edges[0] + edges[n]);
        for (i, &edge) in edges.iter().enumerate().take(n).skip(1) {
            t2 += 4.0 * (turn * i as f64).sin() * edge;
        }
        for (i, &face) in faces.iter().enumerate() {
            t2 += ((turn * i as f64).sin() + (turn * (i + 1) as f64).sin()) * face;
        }
    }
    let reach = edges
        .iter()
        .chain(&faces)
        .fold(0.0_f64, |most, e| most.max(e.length_squared()));
    let cross = t1.cross(t2);
    let length = cross.length();
    // The first bound tells parallel tangents, the second what is but the
    // rounding of the coordinates.
    let sound = length > 1e-10 * reach && length > 1e-20 * span * span;
    sound.then(|| cross / length)
}

/// The averaging rule of the paper's section 4: a missing normal becomes the
/// mean of its edge neighbours' normals, in rounds.
///
/// Deviation: the mean is normalised, so that the wall there is as thick as
/// asked, and all missing ones of a round are filled from the rounds before
/// it, so that the outcome does not depend on an order of vertices.
fn fill(mesh: &Quads, mut known: Vec<Option<DVec3>>) -> (Vec<DVec3>, Vec<u32>, Vec<u32>) {
    let cage = mesh.cage();
    let mut left: Vec<u32> = (0..known.len() as u32)
        .filter(|&v| known[v as usize].is_none())
        .collect();
    let mut averaged = Vec::new();
    while !left.is_empty() {
        let mut round = Vec::new();
        for &v in &left {
            let mut sum = DVec3::ZERO;
            for h in cage.fan(v) {
                sum += known[cage.end(h) as usize].unwrap_or_default();
                // The last spoke of a boundary fan starts no face.
                if cage.twin(cage.prev(h)).is_none() {
                    let last = cage.origin(cage.prev(h));
                    sum += known[last as usize].unwrap_or_default();
                }
            }
            if sum.length() > 1e-12 {
                round.push((v, sum.normalize()));
            }
        }
        if round.is_empty() {
            break;
        }
        for &(v, normal) in &round {
            known[v as usize] = Some(normal);
            averaged.push(v);
        }
        left.retain(|&v| known[v as usize].is_none());
    }
    averaged.sort_unstable();
    let normals = known.into_iter().map(Option::unwrap_or_default).collect();
    (normals, averaged, left)
}
