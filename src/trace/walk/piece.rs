//! The mid-surface in some tetrahedra, as little as joining needs.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::store::{Store, inner_vertex};
use crate::lattice::TetKey;
use crate::mesh::FaceId;
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};
use crate::trace::tet::{TetSurface, VertexKey};

/// Triangles of some tetrahedra over vertices of its own, which other pieces
/// have under the same keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Piece {
    /// Names of the vertices, ascending.
    keys: Vec<VertexKey>,
    /// The vertices, in the order of their names.
    vertices: Vec<PieceVertex>,
    /// Walls of all vertices, one after the other.
    walls: Vec<FaceId>,
    /// Tetrahedra that hold something, ascending.
    tets: Vec<PieceTet>,
    /// Triangles of all tetrahedra, one after the other.
    triangles: Vec<[u32; 3]>,
    /// Marked edges of all tetrahedra, one after the other.
    lines: Vec<([u32; 2], Line)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PieceVertex {
    at: DVec3,
    coping: Option<FaceId>,
    walls_end: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct PieceTet {
    key: TetKey,
    triangles_end: u32,
    lines_end: u32,
}

impl Piece {
    /// The piece of solved tetrahedra, ascending.
    pub(super) fn new(store: &mut Store, solved: &[(TetKey, TetSurface)]) -> Piece {
        let mut keys: Vec<VertexKey> = (solved.iter())
            .flat_map(|(_, surface)| surface.triangles.iter().flatten().copied())
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
        for polygon in &surface.polygons {
            let n = polygon.corners.len();
            for (k, &line) in polygon.lines.iter().enumerate() {
                if line == Line::Sheet {
                    continue;
                }
                let ends = [&polygon.corners[k], &polygon.corners[(k + 1) % n]];
                if let [Some(a), Some(b)] = ends.map(number) {
                    self.lines.push(([a, b], line));
                }
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
            walls: (self.walls[from as usize..v.walls_end as usize].iter().copied()).collect(),
            coping: v.coping,
        }
    }

    /// Drops tetrahedra, and vertices that no other uses.
    pub(super) fn without(self, dropped: &FxHashSet<TetKey>) -> Piece {
        if !self.tets.iter().any(|t| dropped.contains(&t.key)) {
            return self;
        }
        let kept: Vec<usize> = (0..self.tets.len())
            .filter(|&t| !dropped.contains(&self.tets[t].key))
            .collect();
        let mut used = vec![false; self.vertices.len()];
        for &t in &kept {
            for &v in self.triangles[self.ranges(t)[0].clone()].iter().flatten() {
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
            for &(ends, line) in &self.lines[lines] {
                // Both ends are corners of triangles, or were never named.
                if ends.iter().all(|&v| used[v as usize]) {
                    out.lines.push((ends.map(|v| number[v as usize]), line));
                }
            }
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

/// Joins pieces to one mesh: vertices in the order of their keys, triangles in
/// that of their tetrahedra, however the pieces were cut.
pub(super) fn join(mut pieces: Vec<Piece>) -> MarkedMesh {
    let mut keys: Vec<VertexKey> = Vec::with_capacity(pieces.iter().map(|p| p.keys.len()).sum());
    for piece in &pieces {
        keys.extend(&piece.keys);
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
    // Numbers of each piece's vertices in the mesh. Every key was collected above.
    let numbers: Vec<Vec<u32>> = (pieces.par_iter())
        .map(|piece| {
            let number = |key| keys.partition_point(|k| k < key) as u32;
            piece.keys.iter().map(number).collect()
        })
        .collect();
    drop(keys);
    for (piece, numbers) in pieces.iter_mut().zip(&numbers) {
        for (v, &n) in numbers.iter().enumerate() {
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
            mesh.lines.insert(edge(number(a), number(b)), line);
        }
    }
    mesh
}
