//! Triangles around each crossed edge (section VI of the paper).
//!
//! The vertices of the four cells around a crossed edge, and those on the
//! faces between them, form a ring. The *envelope* of the edge is the union of
//! the tetrahedra that join the edge to each side of the ring (Definition 5);
//! envelopes of different edges do not overlap, so triangles that stay in
//! theirs never meet. A fan from a point of the edge always does. Two triangles
//! over a diagonal do if the two cell vertices off the diagonal are convex:
//! the plane through such a vertex and its neighbours passes between the edge's
//! two nodes (Remark 8 for both nodes at once; Propositions 2 and 3).
//! Decided exactly, with a coplanar node counted as concave.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use robust::{Coord3D, orient3d};
use serde::Serialize;
use smallvec::SmallVec;

use super::block::{block_of, local, node_of};
use super::cells::{CellBlock, CellRef, Cells, around, numbers_around};
use super::edges::{EdgeBlock, Edges};
use super::faces::Faces;
use super::grid::Grid;
use super::implicit::Implicit;
use super::pattern::trace_of;
use super::vertex::{Vertex, stray};
use crate::mesh::is_thin;

/// How the rings were triangulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RingCounts {
    /// Rings, one a crossed edge.
    pub rings: u64,
    /// With two concave vertices, where no diagonal stays in the envelope, or
    /// all but in a line.
    pub concave: u64,
    /// With a vertex on the edge because the better diagonal strays.
    pub refined: u64,
    /// Closest-point queries.
    pub queries: u64,
}

impl RingCounts {
    fn plus(mut self, other: RingCounts) -> RingCounts {
        self.rings += other.rings;
        self.concave += other.concave;
        self.refined += other.refined;
        self.queries += other.queries;
        self
    }
}

/// Triangles lower than this, over their longest side, are not made.
pub(super) const NEEDLE: f64 = 1e-8;

/// Marks a vertex that a block numbers itself.
const OWN: u32 = 1 << 31;

/// Triangles of a block; a vertex with [`OWN`] is one of `own`.
#[derive(Default)]
struct Piece {
    triangles: Vec<[u32; 3]>,
    own: Vec<Vertex>,
    counts: RingCounts,
}

/// Triangles, and the vertices on edges, which are numbered from `start` on.
pub(super) fn triangulate(
    solid: &impl Implicit,
    grid: &Grid,
    edges: &Edges,
    cells: &Cells,
    faces: &Faces,
    tolerance: f64,
    start: u32,
) -> (Vec<[u32; 3]>, Vec<Vertex>, RingCounts) {
    let pieces: Vec<Piece> = edges
        .blocks
        .par_iter()
        .map(|block| {
            let mut work = Work {
                solid,
                grid,
                cells,
                faces,
                block,
                home: cells.block(block.key),
                tolerance,
                piece: Piece::default(),
            };
            for axis in 0..3 {
                for at in block.crossed[axis].ones() {
                    work.ring(axis, at);
                }
            }
            work.piece.triangles.shrink_to_fit();
            work.piece.own.shrink_to_fit();
            work.piece
        })
        .collect();
    // With room for a few more, so that mending need not copy the list.
    let total: usize = pieces.iter().map(|p| p.triangles.len()).sum();
    let mut triangles = Vec::with_capacity(total + total / 64);
    let mut own = Vec::with_capacity(pieces.iter().map(|p| p.own.len()).sum());
    let mut counts = RingCounts::default();
    for piece in pieces {
        let first = start + own.len() as u32;
        let number = |v: u32| if v & OWN != 0 { first + (v & !OWN) } else { v };
        triangles.extend(piece.triangles.iter().map(|t| t.map(number)));
        own.extend(piece.own);
        counts = counts.plus(piece.counts);
    }
    (triangles, own, counts)
}

struct Work<'a, I> {
    solid: &'a I,
    grid: &'a Grid,
    cells: &'a Cells,
    faces: &'a Faces,
    block: &'a EdgeBlock,
    /// The cells of the edges' own block.
    home: Option<&'a CellBlock>,
    tolerance: f64,
    piece: Piece,
}

impl<'a, I: Implicit> Work<'a, I> {
    fn cell(&self, at: IVec3) -> Option<CellRef<'a>> {
        let block = if block_of(at) == self.block.key {
            self.home
        } else {
            self.cells.block(block_of(at))
        };
        block?.cell(local(at))
    }

    fn ring(&mut self, axis: usize, at: usize) {
        let node = node_of(self.block.key, at);
        let places = around(node, axis);
        let numbers = numbers_around(axis);
        // All four cells of a crossed edge are active: `Cells::place` made them
        // from these very edges.
        let [Some(p), Some(q), Some(r), Some(s)] = places.map(|c| self.cell(c)) else {
            debug_assert!(false, "a cell without vertices at a crossed edge");
            return;
        };
        let cells = [p, q, r, s];
        let [a, b, c, d]: [(u32, &Vertex); 4] =
            std::array::from_fn(|i| cells[i].vertex(numbers[i]));
        let corners = [a, b, c, d];
        // The face between a cell of the ring and the next is the lower face
        // of one of the two.
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut ring: SmallVec<[u32; 8]> = SmallVec::new();
        for (i, (owner, across)) in [(0, b), (1, c), (3, b), (0, c)].into_iter().enumerate() {
            ring.push(corners[i].0);
            let pattern = cells[owner].pattern;
            let trace = if pattern.is_ambiguous(2 * across) {
                let cell = &cells[owner];
                trace_of(cell.corners, cell.joined, 2 * across, numbers[owner])
            } else {
                0
            };
            ring.extend(self.faces.vertex(places[owner], across, trace));
        }
        let up = self.block.is_inside(at);
        self.piece.counts.rings += 1;
        if ring.len() > 4 {
            return self.fan(&ring, axis, at, up);
        }
        match self.diagonal(&corners, node, axis) {
            Some(0) => {
                self.emit([ring[0], ring[1], ring[2]], up);
                self.emit([ring[0], ring[2], ring[3]], up);
            }
            Some(_) => {
                self.emit([ring[1], ring[2], ring[3]], up);
                self.emit([ring[1], ring[3], ring[0]], up);
            }
            None => self.fan(&ring, axis, at, up),
        }
    }

    /// From which vertex of the ring on the diagonal should run; none if a
    /// fan is needed.
    fn diagonal(&mut self, ring: &[(u32, &Vertex); 4], node: IVec3, axis: usize) -> Option<usize> {
        let ends = [node, node + IVec3::AXES[axis]].map(|n| coord(self.grid.node(n)));
        let points = ring.map(|(_, v)| v.position);
        let convex = |i: usize| {
            let [a, b, c] = [points[(i + 3) % 4], points[i], points[(i + 1) % 4]].map(coord);
            orient3d(a, b, c, ends[1]) < 0.0 && orient3d(a, b, c, ends[0]) > 0.0
        };
        // Three vertices along a crease make no triangle.
        let wide = |i: usize| {
            let ear = [points[(i + 3) % 4], points[i], points[(i + 1) % 4]];
            !is_thin(ear, NEEDLE)
        };
        let ears = |i: usize, j: usize| convex(i) && convex(j) && wide(i) && wide(j);
        let free = [ears(1, 3), ears(0, 2)];
        let bound = [0, 1].map(|i| stray(ring[i].1, ring[i + 2].1));
        let length = [0, 1].map(|i| points[i].distance_squared(points[i + 2]));
        let shorter = usize::from(length[1] < length[0]);
        let flat = bound[0].max(bound[1]) < 0.4 * self.tolerance;
        match free {
            [false, false] => {
                self.piece.counts.concave += 1;
                None
            }
            _ if flat => Some(if free[shorter] { shorter } else { 1 - shorter }),
            _ => {
                let strays = [0, 1].map(|i| {
                    if !free[i] {
                        return f64::INFINITY;
                    }
                    self.piece.counts.queries += 1;
                    let middle = 0.5 * (points[i] + points[i + 2]);
                    let (_, element) = self.block.crossing(axis, local(node));
                    self.solid.sample(middle, element).value.abs()
                });
                let best = usize::from(strays[1] < strays[0]);
                if strays[best] > self.tolerance {
                    self.piece.counts.refined += 1;
                    return None;
                }
                Some(best)
            }
        }
    }

    /// Triangles from the crossing to each side of the ring.
    fn fan(&mut self, ring: &[u32], axis: usize, at: usize, up: bool) {
        let Some(crossing) = self.block.hermite(self.solid, self.grid, axis, at) else {
            return;
        };
        let centre = OWN | self.piece.own.len() as u32;
        self.piece.own.push(Vertex {
            position: crossing.point,
            normal: crossing.normal.as_vec3(),
            sharp: false,
        });
        for (i, &v) in ring.iter().enumerate() {
            self.emit([centre, v, ring[(i + 1) % ring.len()]], up);
        }
    }

    /// Rings run counter-clockwise as seen from the edge's upper end, which is
    /// outside if the lower one is inside.
    fn emit(&mut self, [a, b, c]: [u32; 3], up: bool) {
        let triangle = if up { [a, b, c] } else { [a, c, b] };
        self.piece.triangles.push(triangle);
    }
}

fn coord(p: DVec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}
