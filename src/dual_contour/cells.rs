//! Cells that the surface passes through, and their vertices.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::block::{Bits, block_of, local, node_of};
use super::edges::{EdgeBlock, Edges, Hermite};
use super::grid::Grid;
use super::implicit::Implicit;
use super::pattern::{Pattern, edge_corners, face_edges, pattern, trace_of};
use super::qef;
use super::vertex::{Finder, Vertex};

/// The active cells of a block.
pub(super) struct CellBlock {
    pub key: IVec3,
    pub active: Bits,
    /// Corners inside the solid, and ambiguous faces whose inside is joined,
    /// by active cell.
    sides: Vec<[u8; 2]>,
    /// Number of the first vertex within the block, by active cell.
    first: Vec<u32>,
    vertices: Vec<Vertex>,
    /// Number of the block's first vertex in the mesh.
    start: u32,
}

/// An active cell.
#[derive(Clone, Copy)]
pub(super) struct CellRef<'a> {
    pub corners: u8,
    pub joined: u8,
    pub pattern: &'static Pattern,
    vertices: &'a [Vertex],
    first: u32,
}

impl<'a> CellRef<'a> {
    /// The vertex of the loop that this crossed edge is in, and its number.
    ///
    /// An edge that is crossed has corners of different sides (`settle`), and so
    /// a loop in the pattern.
    pub fn vertex(&self, edge: usize) -> (u32, &'a Vertex) {
        let i = self.pattern.loop_of[edge];
        (self.first + u32::from(i), &self.vertices[usize::from(i)])
    }
}

/// All active cells.
pub(super) struct Cells {
    /// Sorted by key.
    pub blocks: Vec<CellBlock>,
    pub queries: u64,
    places: FxHashMap<IVec3, u32>,
}

impl Cells {
    /// Finds the cells with crossed edges and places their vertices.
    pub fn place(solid: &impl Implicit, grid: &Grid, edges: &Edges) -> Cells {
        let solved: Vec<(CellBlock, u64)> = touched(edges)
            .into_par_iter()
            .map(|(key, active)| place_block(solid, grid, edges, key, active))
            .collect();
        let mut start = 0;
        let mut queries = 0;
        let blocks: Vec<CellBlock> = solved
            .into_iter()
            .map(|(mut block, asked)| {
                block.start = start;
                start += block.vertices.len() as u32;
                queries += asked;
                block
            })
            .collect();
        let places = (0..).zip(&blocks).map(|(i, b)| (b.key, i)).collect();
        Cells {
            blocks,
            queries,
            places,
        }
    }

    /// The block with this key; none if no cell of it is active.
    pub fn block(&self, key: IVec3) -> Option<&CellBlock> {
        self.places.get(&key).map(|&i| &self.blocks[i as usize])
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

impl CellBlock {
    /// The cell with this lower node, if it is active.
    pub fn cell(&self, local: usize) -> Option<CellRef<'_>> {
        if !self.active.get(local) {
            return None;
        }
        let i = self.active.rank(local);
        let [corners, joined] = self.sides[i];
        let pattern = pattern(corners, joined);
        let first = self.first[i] as usize;
        Some(CellRef {
            corners,
            joined,
            pattern,
            vertices: &self.vertices[first..first + pattern.loops],
            first: self.start + self.first[i],
        })
    }
}

/// Cells around each crossed edge, by block, sorted.
fn touched(edges: &Edges) -> Vec<(IVec3, Bits)> {
    let mut found: FxHashMap<IVec3, Bits> = FxHashMap::default();
    for block in &edges.blocks {
        // Most cells lie in the block of their edge.
        let mut own = Bits::default();
        for axis in 0..3 {
            for at in block.crossed[axis].ones() {
                for cell in around(node_of(block.key, at), axis) {
                    if block_of(cell) == block.key {
                        own.set(local(cell));
                    } else {
                        found.entry(block_of(cell)).or_default().set(local(cell));
                    }
                }
            }
        }
        found.entry(block.key).or_default().or(&own);
    }
    let mut sorted: Vec<(IVec3, Bits)> = found.into_iter().collect();
    sorted.sort_unstable_by_key(|(key, _)| key.to_array());
    sorted
}

/// The four cells around the edge from a node along `axis`, counter-clockwise
/// as seen from the edge's upper end.
pub(super) fn around(node: IVec3, axis: usize) -> [IVec3; 4] {
    let (b, c) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
    [node, node - b, node - b - c, node - c]
}

/// Number that the edge has in each of the cells [`around`] it.
pub(super) fn numbers_around(axis: usize) -> [usize; 4] {
    [4 * axis, 4 * axis + 1, 4 * axis + 3, 4 * axis + 2]
}

/// The edge blocks that the cells of a block reach into: bit 1 for one more
/// along x, 2 along y, 4 along z.
pub(super) type Neighbourhood<'a> = [Option<&'a EdgeBlock>; 8];

/// Ambiguous faces of a cell whose inside is joined: those where the function
/// is nearer to zero half-way along the traces that this makes.
///
/// Both cells at a face come to the same answer, from the same four crossings.
fn joined(
    solid: &impl Implicit,
    grid: &Grid,
    near: &Neighbourhood,
    key: IVec3,
    cell: IVec3,
    corners: u8,
    queries: &mut u64,
) -> u8 {
    let pattern = pattern(corners, 0);
    let mut joined = 0;
    for face in (0..6).filter(|&face| pattern.is_ambiguous(face)) {
        let misfit = [0, 1 << face].map(|choice| {
            let mut traces = [Crossings::new(), Crossings::new()];
            for edge in face_edges(face) {
                if let (Some(block), at) = owner(near, key, cell, edge) {
                    let which = trace_of(corners, choice, face, edge);
                    traces[which].extend(block.hermite(solid, grid, edge / 4, at));
                }
            }
            let strays = traces.map(|trace| {
                let hint = trace.first().map_or(0, |first| first.element);
                solid.sample(qef::mass_point(&trace), hint).value.abs()
            });
            strays[0].max(strays[1])
        });
        *queries += 4;
        if misfit[1] < misfit[0] {
            joined |= 1 << face;
        }
    }
    joined
}

/// The neighbourhood of the block with this key.
pub(super) fn neighbourhood(edges: &Edges, key: IVec3) -> Neighbourhood<'_> {
    std::array::from_fn(|corner| edges.block(key + corner_step(corner)))
}

/// The crossings of each loop of a cell.
pub(super) fn loops(
    solid: &impl Implicit,
    grid: &Grid,
    near: &Neighbourhood,
    key: IVec3,
    cell: IVec3,
    pattern: &Pattern,
) -> SmallVec<[Crossings; 4]> {
    let mut loops: SmallVec<[Crossings; 4]> = SmallVec::new();
    loops.resize_with(pattern.loops, Crossings::new);
    for (edge, &l) in pattern.loop_of.iter().enumerate() {
        if l != u8::MAX
            && let (Some(block), at) = owner(near, key, cell, edge)
        {
            loops[usize::from(l)].extend(block.hermite(solid, grid, edge / 4, at));
        }
    }
    loops
}

fn corner_step(corner: usize) -> IVec3 {
    IVec3::new(
        corner as i32 & 1,
        corner as i32 >> 1 & 1,
        corner as i32 >> 2,
    )
}

/// A cell's edge: the block that owns it, and its lower node there.
pub(super) fn owner<'a>(
    near: &Neighbourhood<'a>,
    key: IVec3,
    cell: IVec3,
    edge: usize,
) -> (Option<&'a EdgeBlock>, usize) {
    let node = cell + corner_step(edge_corners(edge)[0]);
    let beyond = block_of(node) - key;
    (
        near[(beyond.x | beyond.y << 1 | beyond.z << 2) as usize],
        local(node),
    )
}

/// Corners inside the solid, told from the crossed edges alone: every corner
/// is on the side of its neighbour along an edge that is not crossed.
fn corners(near: &Neighbourhood, key: IVec3, cell: IVec3) -> u8 {
    let mut crossed = [false; 12];
    let mut known = 0u8;
    let mut inside = 0u8;
    for (edge, crossed) in crossed.iter_mut().enumerate() {
        if let (Some(block), at) = owner(near, key, cell, edge)
            && block.crossed[edge / 4].get(at)
        {
            *crossed = true;
            if known == 0 {
                let low = edge_corners(edge)[0];
                known = 1 << low;
                inside = u8::from(block.is_inside(at)) << low;
            }
        }
    }
    while known != 0 && known != u8::MAX {
        for (edge, &crossed) in crossed.iter().enumerate() {
            let [a, b] = edge_corners(edge);
            for (from, to) in [(a, b), (b, a)] {
                if known >> from & 1 != 0 && known >> to & 1 == 0 {
                    known |= 1 << to;
                    inside |= ((inside >> from & 1) ^ u8::from(crossed)) << to;
                }
            }
        }
    }
    inside
}

fn place_block(
    solid: &impl Implicit,
    grid: &Grid,
    edges: &Edges,
    key: IVec3,
    active: Bits,
) -> (CellBlock, u64) {
    let near = neighbourhood(edges, key);
    let count = active.count();
    let mut out = CellBlock {
        key,
        active,
        sides: Vec::with_capacity(count),
        first: Vec::with_capacity(count),
        vertices: Vec::with_capacity(count),
        start: 0,
    };
    let mut queries = 0;
    for at in active.ones() {
        let cell = node_of(key, at);
        let corners = corners(&near, key, cell);
        let joined = joined(solid, grid, &near, key, cell, corners, &mut queries);
        let pattern = pattern(corners, joined);
        out.sides.push([corners, joined]);
        out.first.push(out.vertices.len() as u32);
        let loops = loops(solid, grid, &near, key, cell, pattern);
        for (i, crossings) in loops.iter().enumerate() {
            let mut finder = Finder {
                solid,
                grid,
                cell: grid.cell_box(cell),
                crossings,
                flat: None,
                queries: 0,
            };
            let apart = Apart::new(&loops, i);
            out.vertices.push(finder.in_cell(|p| apart.allows(p)));
            queries += finder.queries;
        }
    }
    (out, queries)
}

/// The crossings of one loop.
pub(super) type Crossings = SmallVec<[Hermite; 12]>;

/// Half-spaces that keep one loop of a cell, and so the fan from its vertex,
/// apart from the others.
///
/// The loops of a cell surround different corners, and a plane across the line
/// between the mean points of two of them parts the loops. The fan from a
/// vertex on the right side of all these planes stays there, and fans of
/// different loops do not meet. The same with the two traces of a face.
pub(super) struct Apart {
    planes: SmallVec<[(DVec3, f64); 3]>,
}

impl Apart {
    pub fn new(loops: &[Crossings], which: usize) -> Apart {
        let mean = qef::mass_point(&loops[which]);
        let mut planes = SmallVec::new();
        for (i, other) in loops.iter().enumerate() {
            if i != which {
                let normal = qef::mass_point(other) - mean;
                let last = |points: &[Hermite], sign: f64| {
                    points
                        .iter()
                        .map(|h| sign * normal.dot(h.point))
                        .fold(f64::NEG_INFINITY, f64::max)
                };
                let (own, theirs) = (last(&loops[which], 1.0), -last(other, -1.0));
                // Should no plane across this line part them, only the mass
                // point is left.
                let bound = if own < theirs {
                    0.5 * (own + theirs)
                } else {
                    f64::NEG_INFINITY
                };
                planes.push((normal, bound));
            }
        }
        Apart { planes }
    }

    pub fn allows(&self, p: DVec3) -> bool {
        self.planes
            .iter()
            .all(|(normal, bound)| normal.dot(p) < *bound)
    }
}
