//! Limit points (2.2) and unit normals (2.3) of control vertices.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rayon::prelude::*;

use super::cage::Cage;
use super::dart::{self, Mask};
use super::refine::{Boundary, Quads};
use super::sharp::{Rule, Sector, Sectors};

/// Sides of a crease nearer to back to back than that, by the eigenvalue of
/// their mean direction, are not mitred along it: the step would be 30 times as
/// long as the wall is thick.
const BACK_TO_BACK: f64 = 1e-3;

/// Limit point of every control vertex, normal of every sector.
#[derive(Clone, Debug)]
pub(super) struct Corners {
    pub limits: Vec<DVec3>,
    /// Unit normal, outward, of each sector.
    pub sides: Vec<DVec3>,
    /// Of each vertex the step that leaves all its sectors by one.
    pub mitres: Vec<DVec3>,
    /// Its direction.
    pub normals: Vec<DVec3>,
    /// Vertices whose normal is an average of others', ascending.
    pub averaged: Vec<u32>,
    /// Vertices for which even that gave none; their normal is zero.
    pub missing: Vec<u32>,
}

impl Corners {
    pub fn new(mesh: &Quads, sectors: &Sectors, boundary: Boundary) -> Corners {
        let cage = mesh.cage();
        let vertices = cage.positions().len();
        let limits = (0..vertices as u32)
            .into_par_iter()
            .map(|v| limit(cage, v, boundary))
            .collect();
        let span = cage
            .positions()
            .iter()
            .fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
        let known: Vec<Option<DVec3>> = sectors
            .list
            .par_iter()
            .map(|sector| normal(cage, sector, span))
            .collect();
        let (sides, averaged, missing) = fill(cage, sectors, known);
        let mut mitres = sides[..vertices].to_vec();
        // Further sectors of a vertex follow each other.
        let origin = |sector: &Sector| cage.origin(sector.first);
        let mut next = vertices;
        for further in sectors.list[vertices..].chunk_by(|a, b| origin(a) == origin(b)) {
            let v = origin(&further[0]) as usize;
            let mut meeting = vec![sides[v]];
            meeting.extend_from_slice(&sides[next..next + further.len()]);
            mitres[v] = mitre(&meeting);
            next += further.len();
        }
        let normals = mitres.iter().map(|m| m.normalize_or_zero()).collect();
        Corners {
            limits,
            sides,
            mitres,
            normals,
            averaged,
            missing,
        }
    }
}

/// The shortest step that leaves planes with these unit normals by one; the
/// best one where they are too many.
///
/// The paper has smooth surfaces alone. With it a wall below plane sides is as
/// thick as asked for up to their crease, inside a bend as outside.
pub(super) fn mitre(normals: &[DVec3]) -> DVec3 {
    let mut square = DMat3::ZERO;
    for n in normals {
        square += DMat3::from_cols(n.x * *n, n.y * *n, n.z * *n);
    }
    let eigen = SymmetricEigen::new(Matrix3::from_column_slice(&square.to_cols_array()));
    let sum: DVec3 = normals.iter().sum();
    let mut step = DVec3::ZERO;
    for (axis, &value) in eigen.eigenvectors.column_iter().zip(&eigen.eigenvalues) {
        if value > BACK_TO_BACK {
            let axis = DVec3::new(axis[0], axis[1], axis[2]);
            step += axis.dot(sum) / value * axis;
        }
    }
    step
}

/// Limit point of a vertex: (2.2), which is (N V + 4 E + F) / (N + 5) with the
/// means E and F. On a cut that of the curve.
fn limit(cage: &Cage, vertex: u32, boundary: Boundary) -> DVec3 {
    let p = cage.position(vertex);
    let around = cage.around(vertex, boundary, 0);
    let far = |h: u32| cage.position(cage.origin(cage.next(cage.next(h))));
    match around.rule {
        Rule::Corner => p,
        Rule::Crease => (4.0 * p + around.ends) / 6.0,
        Rule::Smooth => {
            let (mut edges, mut faces) = (DVec3::ZERO, DVec3::ZERO);
            for h in cage.fan(vertex) {
                edges += cage.position(cage.end(h));
                faces += far(h);
            }
            let n = f64::from(cage.degree(vertex));
            (n * n * p + 4.0 * edges + faces) / (n * (n + 5.0))
        }
        Rule::Dart => {
            let sharp = cage.fan(vertex).find(|&h| cage.across(h).is_none());
            let fan: Vec<u32> = sharp.into_iter().flat_map(|h| cage.sector(h)).collect();
            let edge = |k: usize| cage.position(cage.end(fan[k]));
            Mask::new(fan.len()).weigh(p, edge, |k| far(fan[k]))
        }
    }
}

/// Unit normal in a sector by (2.3), from the two tangents in closed form; none
/// where they vanish or are parallel.
///
/// Beside a crease the tangents are those of its curve and, across, of the
/// eigenvector of a fan of `n` faces. A corner of several faces has no tangent
/// plane: the mean of its faces' stands in for it.
fn normal(cage: &Cage, sector: &Sector, span: f64) -> Option<DVec3> {
    let p = cage.position(cage.origin(sector.first));
    let mut edges: Vec<DVec3> = Vec::with_capacity(8);
    let mut faces: Vec<DVec3> = Vec::with_capacity(8);
    for h in cage.sector(sector.first) {
        edges.push(cage.position(cage.end(h)) - p);
        faces.push(cage.position(cage.origin(cage.next(cage.next(h)))) - p);
        if !sector.closed && edges.len() == sector.faces as usize {
            edges.push(cage.position(cage.origin(cage.prev(h))) - p);
        }
    }
    // All relative to the vertex itself: the weights of a tangent sum to 0, so
    // the vertex drops out and far-off parts lose no digits.
    let cross = match sector.rule {
        Rule::Smooth => inside(&edges, &faces),
        Rule::Dart => dart::normal(&edges, &faces),
        Rule::Crease if faces.len() > 1 && !sector.closed => beside(&edges, &faces),
        Rule::Crease | Rule::Corner => {
            let next = |k: usize| edges[(k + 1) % edges.len()];
            (0..faces.len()).map(|k| edges[k].cross(next(k))).sum()
        }
    };
    let reach = edges
        .iter()
        .chain(&faces)
        .fold(0.0_f64, |most, e| most.max(e.length_squared()));
    let length = cross.length();
    // The first bound tells parallel tangents, the second what is but the
    // rounding of the coordinates.
    let sound = length > 1e-10 * reach && length > 1e-20 * span * span;
    sound.then(|| cross / length)
}

/// Normal of any length at a smooth vertex, from its edge and face neighbours.
fn inside(edges: &[DVec3], faces: &[DVec3]) -> DVec3 {
    let wide = faces.len() as f64;
    let turn = 2.0 * PI / wide;
    let a = 1.0 + turn.cos() + (PI / wide).cos() * (2.0 * (9.0 + turn.cos())).sqrt();
    let (mut t1, mut t2) = (DVec3::ZERO, DVec3::ZERO);
    for (i, (&edge, &face)) in edges.iter().zip(faces).enumerate() {
        let (s0, c0) = (turn * i as f64).sin_cos();
        let (s1, c1) = (turn * (i + 1) as f64).sin_cos();
        t1 += a * c0 * edge + (c0 + c1) * face;
        t2 += a * s0 * edge + (s0 + s1) * face;
    }
    t1.cross(t2)
}

/// Normal of any length beside a crease or boundary, several faces wide.
fn beside(edges: &[DVec3], faces: &[DVec3]) -> DVec3 {
    let n = faces.len();
    let turn = PI / n as f64;
    let (sin, cos) = turn.sin_cos();
    let r = (cos + 1.0) / sin;
    let along = edges[0] - edges[n];
    let mut across = -r * (1.0 + 2.0 * cos) * (edges[0] + edges[n]);
    for (i, &edge) in edges.iter().enumerate().take(n).skip(1) {
        across += 4.0 * (turn * i as f64).sin() * edge;
    }
    for (i, &face) in faces.iter().enumerate() {
        across += ((turn * i as f64).sin() + (turn * (i + 1) as f64).sin()) * face;
    }
    along.cross(across)
}

/// The averaging rule of the paper's section 4: a missing normal becomes the
/// mean of its edge neighbours' normals, in rounds.
///
/// Deviation: the mean is normalised, so that the wall there is as thick as
/// asked, and all missing ones of a round are filled from the rounds before
/// it, so that the outcome does not depend on an order of vertices.
fn fill(
    cage: &Cage,
    sectors: &Sectors,
    mut known: Vec<Option<DVec3>>,
) -> (Vec<DVec3>, Vec<u32>, Vec<u32>) {
    let mut left: Vec<usize> = (0..known.len()).filter(|&s| known[s].is_none()).collect();
    let mut averaged = Vec::new();
    let at_corner = |known: &[Option<DVec3>], h: u32| {
        known[sectors.of[h as usize] as usize].unwrap_or_default()
    };
    while !left.is_empty() {
        let mut round = Vec::new();
        for &sector in &left {
            let mut sum = DVec3::ZERO;
            for h in cage.sector(sectors.list[sector].first) {
                sum += at_corner(&known, cage.next(h));
                // The last spoke of an open fan starts no face.
                if cage.across(cage.prev(h)).is_none() {
                    sum += at_corner(&known, cage.prev(h));
                }
            }
            if sum.length() > 1e-12 {
                round.push((sector, sum.normalize()));
            }
        }
        if round.is_empty() {
            break;
        }
        for &(sector, normal) in &round {
            known[sector] = Some(normal);
            averaged.push(sector);
        }
        left.retain(|&sector| known[sector].is_none());
    }
    let vertices = |of: Vec<usize>| {
        let origins = of.iter().map(|&s| cage.origin(sectors.list[s].first));
        let mut vertices: Vec<u32> = origins.collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    };
    let normals = known.into_iter().map(Option::unwrap_or_default).collect();
    (normals, vertices(averaged), vertices(left))
}
