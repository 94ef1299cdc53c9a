//! The mid-surface in some tetrahedra, as little as joining needs.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::store::{Store, inner_vertex};
use crate::lattice::TetKey;
use crate::mesh::FaceId;
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};
use crate::trace::tet::{Polygon, TetSurface, VertexKey};

/// Triangles of some tetrahedra over vertices of its own, which other pieces
/// have under the same keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Names of the vertices, ascending.
    pub(super) keys: Vec<VertexKey>,
    /// The vertices, in the order of their names.
    pub(super) vertices: Vec<PieceVertex>,
    /// Walls of all vertices, one after the other.
    pub(super) walls: Vec<FaceId>,
    /// Tetrahedra that hold something, ascending.
    pub(super) tets: Vec<PieceTet>,
    /// Triangles of all tetrahedra, one after the other.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Marked edges of all tetrahedra, one after the other.
    pub(super) lines: Vec<([u32; 2], Line)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PieceVertex {
    pub(super) at: DVec3,
    pub(super) coping: Option<FaceId>,
    pub(super) walls_end: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PieceTet {
    pub(super) key: TetKey,
    pub(super) triangles_end: u32,
    pub(super) lines_end: u32,
}

impl Piece {
    /// The piece of solved tetrahedra, ascending.
    pub(super) fn new(store: &mut Store, solved: &[(TetKey, TetSurface)]) -> Piece {
        let marked = |(_, surface): &(TetKey, TetSurface)| -> Vec<VertexKey> {
            let ends = surface.polygons.iter().flat_map(marked_sides);
            ends.flat_map(|(ends, _)| ends).collect()
        };
        let mut keys: Vec<VertexKey> = (solved.iter())
            .flat_map(|(_, surface)| surface.triangles.iter().flatten().copied())
            .chain(solved.iter().flat_map(marked))
            .collect();
        keys.sort_unstable();
        keys.dedup();
        let mut piece = Piece {
            keys: Vec::with_capacity(keys.len()),
            vertices: Vec::with_capacity(keys.len()),
            walls: Vec::with_capacity(2 * keys.len()),
            ..Piece::default()
        };
        for key in keys {
            let vertex = match key {
                VertexKey::Inner(tet, n) => (solved.binary_search_by_key(&tet, |s| s.0).ok())
                    .and_then(|found| solved[found].1.inner.get(n as usize))
                    .map(inner_vertex),
                _ => store.vertex(key),
            };
            if let Some(vertex) = vertex {
                piece.walls.extend(&vertex.walls);
                piece.keys.push(key);
                piece.vertices.push(PieceVertex {
                    at: vertex.at,
                    coping: vertex.coping,
                    walls_end: piece.walls.len() as u32,
                });
            }
        }
        for (key, surface) in solved.iter().filter(|s| !s.1.polygons.is_empty()) {
            piece.add(*key, surface);
        }
        piece.walls.shrink_to_fit();
        piece.tets.shrink_to_fit();
        piece.triangles.shrink_to_fit();
        piece.lines.shrink_to_fit();
        piece
    }

    fn add(&mut self, key: TetKey, surface: &TetSurface) {
        let keys = &self.keys;
        let number = |k: &VertexKey| keys.binary_search(k).ok().map(|n| n as u32);
        for t in &surface.triangles {
            if let [Some(a), Some(b), Some(c)] = [number(&t[0]), number(&t[1]), number(&t[2])] {
                self.triangles.push([a, b, c]);
            }
        }
        for (ends, line) in surface.polygons.iter().flat_map(marked_sides) {
            if let [Some(a), Some(b)] = ends.map(|k| number(&k)) {
                self.lines.push(([a, b], line));
            }
        }
        self.tets.push(PieceTet {
            key,
            triangles_end: self.triangles.len() as u32,
            lines_end: self.lines.len() as u32,
        });
    }

    /// Where the triangles and lines of a tetrahedron lie.
    fn ranges(&self, tet: usize) -> [std::ops::Range<usize>; 2] {
        let before = tet.checked_sub(1).map(|t| self.tets[t]);
        let (t, l) = before.map_or((0, 0), |b| (b.triangles_end, b.lines_end));
        let tet = self.tets[tet];
        [
            t as usize..tet.triangles_end as usize,
            l as usize..tet.lines_end as usize,
        ]
    }

    fn vertex(&self, n: usize) -> MarkedVertex {
        let from = n.checked_sub(1).map_or(0, |m| self.vertices[m].walls_end);
        let v = &self.vertices[n];
        MarkedVertex {
            at: v.at,
            walls: (self.walls[from as usize..v.walls_end as usize]
                .iter()
                .copied())
            .collect(),
            coping: v.coping,
        }
    }

    /// Which vertices are corners of triangles.
    ///
    /// Others are ends of a marked side of a polygon without area; the mark
    /// counts where the neighbours have a triangle there.
    fn corners(&self) -> Vec<bool> {
        let mut used = vec![false; self.keys.len()];
        for &v in self.triangles.iter().flatten() {
            used[v as usize] = true;
        }
        used
    }

    /// Its tetrahedra.
    pub(super) fn tets(&self) -> impl Iterator<Item = TetKey> {
        self.tets.iter().map(|t| t.key)
    }

    /// Drops all other tetrahedra, and vertices that only they use.
    pub(super) fn retained(self, keep: impl Fn(TetKey) -> bool) -> Piece {
        if self.tets().all(&keep) {
            return self;
        }
        let kept: Vec<usize> = (0..self.tets.len())
            .filter(|&t| keep(self.tets[t].key))
            .collect();
        let mut used = vec![false; self.vertices.len()];
        for &t in &kept {
            let [triangles, lines] = self.ranges(t);
            let ends = self.lines[lines].iter().flat_map(|(ends, _)| ends);
            for &v in self.triangles[triangles].iter().flatten().chain(ends) {
                used[v as usize] = true;
            }
        }
        let mut number = vec![0; used.len()];
        let mut out = Piece::default();
        for v in (0..used.len()).filter(|&v| used[v]) {
            number[v] = out.keys.len() as u32;
            let vertex = self.vertex(v);
            out.walls.extend(&vertex.walls);
            out.keys.push(self.keys[v]);
            out.vertices.push(PieceVertex {
                walls_end: out.walls.len() as u32,
                ..self.vertices[v]
            });
        }
        for &t in &kept {
            let [triangles, lines] = self.ranges(t);
            let renumber = |c: [u32; 3]| c.map(|v| number[v as usize]);
            (out.triangles).extend(self.triangles[triangles].iter().copied().map(renumber));
            let lines = self.lines[lines].iter();
            out.lines
                .extend(lines.map(|&(ends, line)| (ends.map(|v| number[v as usize]), line)));
            out.tets.push(PieceTet {
                key: self.tets[t].key,
                triangles_end: out.triangles.len() as u32,
                lines_end: out.lines.len() as u32,
            });
        }
        out
    }

    /// Cells that hold a triangle.
    pub(super) fn cells(pieces: &[Piece]) -> usize {
        let mut cells: Vec<_> = (pieces.iter())
            .flat_map(|p| {
                let full = |t: &usize| !p.ranges(*t)[0].is_empty();
                (0..p.tets.len()).filter(full).map(|t| p.tets[t].key.cell())
            })
            .collect();
        cells.par_sort_unstable();
        cells.dedup();
        cells.len()
    }
}

/// Sides of a polygon that are not inside a sheet.
fn marked_sides(polygon: &Polygon) -> impl Iterator<Item = ([VertexKey; 2], Line)> {
    let n = polygon.corners.len();
    let sides = polygon.lines.iter().enumerate();
    sides
        .filter(|(_, line)| **line != Line::Sheet)
        .map(move |(k, &line)| ([polygon.corners[k], polygon.corners[(k + 1) % n]], line))
}

/// Number of a vertex that the mesh does not have.
const NONE: u32 = u32::MAX;

/// Joins pieces to one mesh: vertices in the order of their keys, triangles in
/// that of their tetrahedra, however the pieces were cut.
pub(super) fn join(mut pieces: Vec<Piece>) -> MarkedMesh {
    let mut keys: Vec<VertexKey> = Vec::with_capacity(pieces.iter().map(|p| p.keys.len()).sum());
    for piece in &pieces {
        let corners = piece.keys.iter().zip(piece.corners());
        keys.extend(corners.filter(|(_, used)| *used).map(|(key, _)| key));
    }
    keys.par_sort_unstable();
    keys.dedup();
    let mut mesh = MarkedMesh::default();
    let blank = MarkedVertex {
        at: DVec3::ZERO,
        walls: Default::default(),
        coping: None,
    };
    mesh.vertices.resize(keys.len(), blank);
    // Numbers of each piece's vertices in the mesh.
    let numbers: Vec<Vec<u32>> = (pieces.par_iter())
        .map(|piece| {
            let number = |key| keys.binary_search(key).map_or(NONE, |n| n as u32);
            piece.keys.iter().map(number).collect()
        })
        .collect();
    drop(keys);
    for (piece, numbers) in pieces.iter_mut().zip(&numbers) {
        for (v, &n) in (numbers.iter().enumerate()).filter(|(_, n)| **n != NONE) {
            mesh.vertices[n as usize] = piece.vertex(v);
        }
        (piece.keys, piece.vertices, piece.walls) = Default::default();
    }
    let mut order: Vec<(TetKey, u32, u32)> = (pieces.iter().enumerate())
        .flat_map(|(p, piece)| {
            let tets = piece.tets.iter().enumerate();
            tets.map(move |(t, tet)| (tet.key, p as u32, t as u32))
        })
        .collect();
    order.par_sort_unstable();
    mesh.triangles
        .reserve_exact(pieces.iter().map(|p| p.triangles.len()).sum());
    for (_, p, t) in order {
        let (piece, numbers) = (&pieces[p as usize], &numbers[p as usize]);
        let [triangles, lines] = piece.ranges(t as usize);
        let number = |v: u32| numbers[v as usize];
        (mesh.triangles).extend(piece.triangles[triangles].iter().map(|c| c.map(number)));
        for &([a, b], line) in &piece.lines[lines] {
            let (a, b) = (number(a), number(b));
            if a != NONE && b != NONE {
                mesh.lines.insert(edge(a, b), line);
            }
        }
    }
    mesh
}

/// Whether pieces that have a vertex in common know it alike, to the last bit.
pub(super) fn agree(pieces: &[Piece]) -> bool {
    let mut all: Vec<(VertexKey, u32, u32)> = (pieces.iter().enumerate())
        .flat_map(|(p, piece)| {
            let keys = piece.keys.iter().enumerate();
            keys.map(move |(v, &key)| (key, p as u32, v as u32))
        })
        .collect();
    all.par_sort_unstable();
    let vertex = |&(_, p, v): &(VertexKey, u32, u32)| pieces[p as usize].vertex(v as usize);
    let alike = |a: &MarkedVertex, b: &MarkedVertex| {
        (a.at, a.coping) == (b.at, b.coping) && a.walls == b.walls
    };
    all.par_windows(2)
        .all(|pair| pair[0].0 != pair[1].0 || alike(&vertex(&pair[0]), &vertex(&pair[1])))
}

/// Those of some tetrahedra to which the mid-surface of no other leads, from
/// one to the next.
pub(super) fn unreached(pieces: &[Piece], some: Vec<TetKey>) -> FxHashSet<TetKey> {
    let mut left: FxHashSet<TetKey> = some.into_iter().collect();
    if left.is_empty() {
        return left;
    }
    let mut open: Vec<(TetKey, Vec<VertexKey>)> = Vec::new();
    let mut reached: FxHashSet<VertexKey> = FxHashSet::default();
    for piece in pieces {
        for (t, tet) in piece.tets.iter().enumerate() {
            let corners = piece.triangles[piece.ranges(t)[0].clone()].iter().flatten();
            let corners = corners.map(|&v| piece.keys[v as usize]);
            match left.contains(&tet.key) {
                true => open.push((tet.key, corners.collect())),
                false => reached.extend(corners),
            }
        }
    }
    loop {
        let before = open.len();
        open.retain(|(tet, corners)| {
            let apart = !corners.iter().any(|c| reached.contains(c));
            if !apart {
                reached.extend(corners);
                left.remove(tet);
            }
            apart
        });
        if open.len() == before {
            return left;
        }
    }
}
