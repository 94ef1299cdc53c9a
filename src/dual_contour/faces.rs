//! Vertices on cell faces: the error-driven half-way points.
//!
//! The edge between the vertices of two neighbouring cells is a chord of the
//! surface. Where it strays by more than the tolerance, it gets a third vertex
//! where the surface crosses the cells' common face. That is the face vertex
//! of the hybrid of primal and dual contouring (Ju and Udeshi, 2006), which
//! the paper does without: every cell is cut into pyramids over its faces, so a
//! vertex anywhere inside the face keeps the triangles apart from all others.
//! It answers the paper's first limitation (triangles stray between samples),
//! and on a crease, where it is put on the crease, the third.
//!
//! Where a cell has several loops, or a face is ambiguous, the vertex is not a
//! matter of error: it parts the sheets. It then has to stay on its loop's side
//! of the planes that part the loops; the middle between the two crossings of
//! its trace always does.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::block::{block_of, local, node_of};
use super::cells::{
    Apart, CellBlock, CellRef, Cells, Crossings, Neighbourhood, loops, neighbourhood, owner,
};
use super::edges::{Edges, Hermite};
use super::grid::Grid;
use super::implicit::Implicit;
use super::pattern::{face_edges, trace_of};
use super::vertex::{Finder, Vertex, stray};

/// A chord is asked about where the normals at its ends let it stray by more
/// than this fraction of the tolerance.
const ASKED_FROM: f64 = 0.4;

/// Vertices on the lower faces of the cells of a block.
struct FaceBlock {
    key: IVec3,
    /// `(6 cell + 2 axis + trace, number within the block)`, sorted.
    codes: Vec<u16>,
    vertices: Vec<Vertex>,
    start: u32,
}

/// All vertices on faces.
pub(super) struct Faces {
    blocks: Vec<FaceBlock>,
    pub queries: u64,
    places: FxHashMap<IVec3, u32>,
}

impl Faces {
    /// Places a vertex on every face whose chord strays by more than
    /// `tolerance`, and where sheets have to be parted. Numbers start at
    /// `start`.
    pub fn place(
        solid: &impl Implicit,
        grid: &Grid,
        edges: &Edges,
        cells: &Cells,
        tolerance: f64,
        mut start: u32,
    ) -> Faces {
        let placed: Vec<(FaceBlock, u64)> = cells
            .blocks
            .par_iter()
            .map(|block| {
                let mut work = Work {
                    solid,
                    grid,
                    cells,
                    block,
                    all_edges: edges,
                    edges: neighbourhood(edges, block.key),
                    tolerance,
                    queries: 0,
                };
                let placed = work.run();
                (placed, work.queries)
            })
            .collect();
        let mut queries = 0;
        let mut blocks = Vec::new();
        for (mut block, asked) in placed {
            queries += asked;
            if !block.codes.is_empty() {
                block.start = start;
                start += block.vertices.len() as u32;
                blocks.push(block);
            }
        }
        let places = (0..).zip(&blocks).map(|(i, b)| (b.key, i)).collect();
        Faces {
            blocks,
            queries,
            places,
        }
    }

    /// The vertex of a trace on the lower face of a cell across `axis`.
    pub fn vertex(&self, cell: IVec3, axis: usize, trace: usize) -> Option<u32> {
        let block = &self.blocks[*self.places.get(&block_of(cell))? as usize];
        let code = code(local(cell), axis, trace);
        let i = block.codes.binary_search(&code).ok()?;
        Some(block.start + i as u32)
    }

    /// All vertices, in the order of their numbers.
    pub fn vertices(&self) -> impl Iterator<Item = &Vertex> {
        self.blocks.iter().flat_map(|b| &b.vertices)
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.blocks.iter().map(|b| b.vertices.len()).sum()
    }
}

fn code(cell: usize, axis: usize, trace: usize) -> u16 {
    (6 * cell + 2 * axis + trace) as u16
}

struct Work<'a, I> {
    solid: &'a I,
    grid: &'a Grid,
    cells: &'a Cells,
    block: &'a CellBlock,
    all_edges: &'a Edges,
    edges: Neighbourhood<'a>,
    tolerance: f64,
    queries: u64,
}

impl<I: Implicit> Work<'_, I> {
    fn run(&mut self) -> FaceBlock {
        let mut out = FaceBlock {
            key: self.block.key,
            codes: Vec::new(),
            vertices: Vec::new(),
            start: 0,
        };
        let block = self.block;
        // Blocks below, across each axis.
        let below: [Option<&CellBlock>; 3] =
            std::array::from_fn(|axis| self.cells.block(block.key - IVec3::AXES[axis]));
        for at in block.active.ones() {
            let place = node_of(block.key, at);
            let Some(cell) = block.cell(at) else {
                continue;
            };
            for (axis, below) in below.iter().enumerate() {
                let next = place - IVec3::AXES[axis];
                let there = if block_of(next) == block.key {
                    Some(block)
                } else {
                    *below
                };
                let Some(other) = there.and_then(|b| b.cell(local(next))) else {
                    continue;
                };
                for trace in 0..2 {
                    if let Some(found) = self.trace(place, cell, other, axis, trace) {
                        out.codes.push(code(at, axis, trace));
                        out.vertices.push(found);
                    }
                }
            }
        }
        out
    }

    /// The vertex of one trace on the lower face of a cell, if it needs one.
    fn trace(
        &mut self,
        place: IVec3,
        cell: CellRef,
        other: CellRef,
        axis: usize,
        trace: usize,
    ) -> Option<Vertex> {
        let face = 2 * axis;
        let ambiguous = cell.pattern.is_ambiguous(face);
        if trace == 1 && !ambiguous {
            return None;
        }
        let mut ends = (0..4).filter(|&i| {
            let edge = face_edges(face)[i];
            cell.pattern.loop_of[edge] != u8::MAX
                && (!ambiguous || trace_of(cell.corners, cell.joined, face, edge) == trace)
        });
        let (i, j) = (ends.next()?, ends.next()?);
        let edge = face_edges(face)[i];
        let crossings: Crossings = [edge, face_edges(face)[j]]
            .into_iter()
            .filter_map(|edge| self.hermite(place, edge))
            .collect();
        let [first, second] = crossings[..] else {
            return None;
        };
        let mut finder = Finder {
            solid: self.solid,
            grid: self.grid,
            cell: self.grid.cell_box(place),
            crossings: &crossings,
            flat: None,
            queries: 0,
        };
        let found = if ambiguous || cell.pattern.loops > 1 || other.pattern.loops > 1 {
            let middle = 0.5 * (first.point + second.point);
            let start = self.grid.settle_on_face(middle, &finder.cell, axis);
            let apart = [
                self.apart(place, cell, edge),
                self.apart(place - IVec3::AXES[axis], other, face_edges(face + 1)[i]),
                self.apart_on_face(place, cell, face, trace),
            ];
            let allowed = |p: DVec3| apart.iter().flatten().all(|a| a.allows(p));
            let mut found = finder.on_face(axis, start, allowed).vertex();
            if !allowed(found.position) {
                found.position = start;
            }
            Some(found)
        } else {
            let (_, a) = cell.vertex(edge);
            let (_, b) = other.vertex(face_edges(face + 1)[i]);
            (stray(a, b) > ASKED_FROM * self.tolerance)
                .then(|| self.split(&mut finder, axis, [a.position, b.position]))
                .flatten()
        };
        self.queries += finder.queries;
        found
    }

    /// The vertex that splits a chord, if it strays too far and the vertex
    /// mends that.
    fn split(&self, finder: &mut Finder<I>, axis: usize, chord: [DVec3; 2]) -> Option<Vertex> {
        let [a, b] = chord;
        let hint = finder.crossings[0].element;
        let (middle, _) = finder.sample(0.5 * (a + b), hint);
        if middle.value.abs() <= self.tolerance {
            return None;
        }
        let plane = finder.cell.low[axis];
        let way = (plane - b[axis]) / (a[axis] - b[axis]);
        let mut start = b.lerp(a, way);
        start[axis] = plane;
        let found = finder.on_face(axis, start, |_| true);
        (found.value.abs() < 0.5 * middle.value.abs()).then(|| found.vertex())
    }

    /// What keeps the loop through an edge apart from the cell's others.
    fn apart(&self, place: IVec3, cell: CellRef, edge: usize) -> Option<Apart> {
        if cell.pattern.loops < 2 {
            return None;
        }
        let key = block_of(place);
        let near = neighbourhood(self.all_edges, key);
        let loops = loops(self.solid, self.grid, &near, key, place, cell.pattern);
        Some(Apart::new(&loops, usize::from(cell.pattern.loop_of[edge])))
    }

    /// What keeps a trace apart from the other one of its face.
    fn apart_on_face(
        &self,
        place: IVec3,
        cell: CellRef,
        face: usize,
        trace: usize,
    ) -> Option<Apart> {
        if !cell.pattern.is_ambiguous(face) {
            return None;
        }
        let mut traces = [Crossings::new(), Crossings::new()];
        for edge in face_edges(face) {
            let which = trace_of(cell.corners, cell.joined, face, edge);
            traces[which].extend(self.hermite(place, edge));
        }
        Some(Apart::new(&traces, trace))
    }

    fn hermite(&self, cell: IVec3, edge: usize) -> Option<Hermite> {
        let (block, at) = owner(&self.edges, self.block.key, cell, edge);
        block?.hermite(self.solid, self.grid, edge / 4, at)
    }
}
