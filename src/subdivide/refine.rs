//! One Catmull-Clark step: (2.1), and its boundary rules.

use glam::DVec3;
use rayon::prelude::*;

use super::cage::{Cage, NONE};
use super::error::CageError;
use super::sharp::{Around, Rule, Sharpness, decayed};

/// What becomes of the boundary. Boundary curves are uniform cubic B-splines
/// of the boundary vertices either way; the paper has closed meshes only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// A boundary vertex of a single face stays in place, a sharp corner.
    #[default]
    EdgeAndCorner,
    /// Such a vertex is smoothed like the others.
    EdgeOnly,
    /// Faces with a vertex on the boundary have no surface, but shape that of
    /// their neighbours.
    None,
}

impl Boundary {
    /// Whether a boundary vertex with that many faces is held in place.
    pub(super) fn holds(self, degree: u32) -> bool {
        self == Boundary::EdgeAndCorner && degree == 1
    }
}

/// A control mesh of quadrilaterals alone: what has a parametric limit surface.
///
/// Face `f` has its corners at half-edges `4 f ..= 4 f + 3`.
#[derive(Clone, Debug)]
pub struct Quads(Cage);

impl Quads {
    /// The cage, if all its faces have four corners.
    pub fn new(cage: Cage) -> Option<Quads> {
        cage.is_quads().then_some(Quads(cage))
    }

    /// The mesh.
    pub fn cage(&self) -> &Cage {
        &self.0
    }

    /// Vertices of a face; the first is at `(u, v) = (0, 0)`, then (1, 0),
    /// (1, 1), (0, 1).
    pub fn corners(&self, face: usize) -> [u32; 4] {
        let ring = self.0.face(face);
        [ring[0], ring[1], ring[2], ring[3]]
    }
}

/// One step: a quadrilateral for every corner of the mesh.
///
/// New vertices are the old vertices moved, then one for every edge, then one
/// for every face, so a vertex keeps its number. The quadrilateral of corner
/// `h` has number `h`; within an old quadrilateral it keeps that one's
/// directions of u and v, elsewhere it starts at the old vertex.
///
/// # Errors
///
/// [`CageError::TooLarge`].
pub fn refine(cage: &Cage, boundary: Boundary) -> Result<Quads, CageError> {
    let halves = cage.corner_count();
    if halves > (1 << 26) {
        return Err(CageError::TooLarge {
            corners: 4 * halves,
        });
    }
    let halves = halves as u32;
    let (vertices, faces) = (cage.positions().len() as u32, cage.face_count());

    let mut edge_of = vec![0; halves as usize];
    let mut edges = Vec::with_capacity(cage.edge_count());
    for h in 0..halves {
        match cage.twin(h) {
            Some(twin) if twin < h => edge_of[h as usize] = edge_of[twin as usize],
            _ => {
                edge_of[h as usize] = edges.len() as u32;
                edges.push(h);
            }
        }
    }

    let face_points: Vec<DVec3> = (0..faces)
        .into_par_iter()
        .map(|face| {
            let ring = cage.face(face);
            ring.iter().map(|&v| cage.position(v)).sum::<DVec3>() / ring.len() as f64
        })
        .collect();
    let middle = |h: u32| 0.5 * (cage.position(cage.origin(h)) + cage.position(cage.end(h)));
    let face_point = |h: u32| face_points[cage.face_of(h)];
    let edge_point = |&h: &u32| match cage.twin(h) {
        Some(twin) => {
            let smooth = (2.0 * middle(h) + (face_point(h) + face_point(twin))) / 4.0;
            match cage.edge_sharpness(h).min(1.0) {
                0.0 => smooth,
                sharp => smooth.lerp(middle(h), sharp),
            }
        }
        None => middle(h),
    };
    let smooth = |v: u32| {
        // (2.1) with the means of edge middles and face points: the same
        // weights, and right for polygons too.
        let n = f64::from(cage.degree(v));
        let (mut faces, mut edges) = (DVec3::ZERO, DVec3::ZERO);
        for h in cage.fan(v) {
            faces += face_point(h);
            edges += middle(h);
        }
        (faces / n + 2.0 * (edges / n) + (n - 3.0) * cage.position(v)) / n
    };
    let place = |v: u32, around: &Around| match around.rule {
        Rule::Smooth | Rule::Dart => smooth(v),
        Rule::Crease => 0.75 * cage.position(v) + 0.125 * around.ends,
        Rule::Corner => cage.position(v),
    };
    let fades = cage.steps_to_sharp() > 0;
    let vertex_point = |v: u32| {
        let now = cage.around(v, boundary, 0);
        let point = place(v, &now);
        if !fades || matches!(now.rule, Rule::Smooth | Rule::Dart) {
            return point;
        }
        let next = cage.around(v, boundary, 1);
        if next.rule == now.rule {
            return point;
        }
        place(v, &next).lerp(point, cage.fading(v, boundary))
    };
    let mut positions: Vec<DVec3> = (0..vertices).into_par_iter().map(vertex_point).collect();
    positions.par_extend(edges.par_iter().map(edge_point));
    positions.extend_from_slice(&face_points);

    let turn = |h: u32| {
        let face = cage.face_of(h);
        let quad = cage.face(face).len() == 4;
        if quad { h - cage.start(face) } else { 0 }
    };
    // Side `s` of the quadrilateral at corner `h`: 0 leaves the old vertex,
    // 1 enters the face point, 2 leaves it, 3 returns.
    let side = |h: u32, s: u32| 4 * h + (s + turn(h)) % 4;
    let edge = |h: u32| vertices + edge_of[h as usize];
    let mut corners = vec![0; 4 * halves as usize];
    let mut twins = vec![NONE; 4 * halves as usize];
    for h in 0..halves {
        let (next, prev) = (cage.next(h), cage.prev(h));
        let face = vertices + edges.len() as u32 + cage.face_of(h) as u32;
        let ring = [cage.origin(h), edge(h), face, edge(prev)];
        for (s, &vertex) in ring.iter().enumerate() {
            corners[side(h, s as u32) as usize] = vertex;
        }
        if let Some(twin) = cage.twin(h) {
            twins[side(h, 0) as usize] = side(cage.next(twin), 3);
        }
        if let Some(twin) = cage.twin(prev) {
            twins[side(h, 3) as usize] = side(twin, 0);
        }
        twins[side(h, 1) as usize] = side(next, 2);
        twins[side(h, 2) as usize] = side(prev, 1);
    }
    let starts = (0..=halves).map(|face| 4 * face).collect();

    let old = &cage.sharpness;
    let mut sharpness = Sharpness::default();
    if !old.edges.is_empty() {
        sharpness.edges = vec![0.0; 4 * halves as usize];
        for h in 0..halves {
            for (s, old_edge) in [(0, h), (3, cage.prev(h))] {
                sharpness.edges[side(h, s) as usize] = decayed(old.edges[old_edge as usize]);
            }
        }
    }
    if !old.vertices.is_empty() {
        sharpness.vertices = old.vertices.iter().map(|&sharp| decayed(sharp)).collect();
        sharpness.vertices.resize(positions.len(), 0.0);
    }
    if !old.holes.is_empty() {
        let of_corner = |h| cage.is_hole(cage.face_of(h));
        sharpness.holes = (0..halves).map(of_corner).collect();
    }
    if cage.has_shares() {
        // Linear over edges and faces: a thickness has no shape of its own.
        let mean = |vertices: &[u32]| {
            let sum: f64 = vertices.iter().map(|&v| cage.share(v)).sum();
            sum / vertices.len() as f64
        };
        sharpness.shares.clone_from(&old.shares);
        let of_edges = edges.iter().map(|&h| mean(&[cage.origin(h), cage.end(h)]));
        sharpness.shares.extend(of_edges);
        sharpness
            .shares
            .extend((0..faces).map(|face| mean(cage.face(face))));
    }
    let mesh = Cage::linked(positions, corners, starts, twins, sharpness);
    Ok(Quads(mesh))
}
