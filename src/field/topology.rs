//! Which triangles share edges and vertices, if they form a closed manifold.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::triangle::Triangle;

/// Adjacency of a closed, oriented manifold.
#[derive(Clone, Debug)]
pub(super) struct Topology {
    /// Vertex numbers of each slot's corners.
    pub vertices: Vec<[u32; 3]>,
    /// Across edge `i` (corner `i` to `i + 1`).
    pub neighbours: Vec<[Side; 3]>,
    pub vertex_count: usize,
}

/// One edge of one triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    pub slot: u32,
    pub edge: u8,
}

impl Topology {
    /// Of triangles by slot, those without area from `in_trees` on. By the
    /// caller's vertex numbers if they make a closed manifold, with or without
    /// the triangles that have no area, else by equal positions, else none.
    ///
    /// Positions are tried because a reader may leave vertices unwelded, and
    /// because leaving out a triangle that has shrunk to an edge closes the gap
    /// only when its two coincident corners count as one.
    pub fn new(triangles: &[Triangle], in_trees: usize, indices: &[[u32; 3]]) -> Option<Topology> {
        let given = |triangles: &[Triangle]| {
            let of = |t: &Triangle| indices.get(t.face.index()).copied();
            let names: Option<Vec<_>> = triangles.iter().map(of).collect();
            closed(renumber(names?.into_iter().flatten()))
        };
        let sound = &triangles[..in_trees];
        if sound.is_empty() {
            return None;
        }
        let all = || (in_trees < triangles.len()).then(|| given(triangles));
        let by_position = || {
            let corners = sound.iter().flat_map(|t| t.corners);
            closed(renumber(corners.map(position_key)))
        };
        given(sound)
            .or_else(|| all().flatten())
            .or_else(by_position)
    }

    /// Walks round the vertex at corner `corner` of `slot`, from triangle to
    /// triangle; gives each triangle's slot and corner once.
    pub fn fan(&self, slot: u32, corner: u8) -> impl Iterator<Item = (u32, u8)> {
        let start = (slot, corner);
        let mut next = Some(start);
        std::iter::from_fn(move || {
            let (slot, corner) = next?;
            let across = self.neighbours[slot as usize][usize::from(corner)];
            let then = (across.slot, (across.edge + 1) % 3);
            next = (then != start).then_some(then);
            Some((slot, corner))
        })
    }
}

/// Bits of a position; negative zero counts as zero.
pub(super) fn position_key(p: DVec3) -> [u64; 3] {
    [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())
}

/// Numbers keys by first appearance; three in a row make a triangle.
fn renumber<K: Eq + std::hash::Hash>(keys: impl Iterator<Item = K>) -> (Vec<[u32; 3]>, usize) {
    let mut numbers = FxHashMap::default();
    let flat: Vec<u32> = keys
        .map(|key| {
            let next = numbers.len() as u32;
            *numbers.entry(key).or_insert(next)
        })
        .collect();
    let vertices = flat.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (vertices, numbers.len())
}

/// The adjacency, if each directed edge occurs once, its reverse too, and the
/// triangles round each vertex form a single fan.
fn closed((vertices, vertex_count): (Vec<[u32; 3]>, usize)) -> Option<Topology> {
    let mut sides = FxHashMap::default();
    sides.reserve(3 * vertices.len());
    for (slot, t) in vertices.iter().enumerate() {
        for edge in 0..3 {
            let side = Side {
                slot: slot as u32,
                edge: edge as u8,
            };
            if sides.insert((t[edge], t[(edge + 1) % 3]), side).is_some() {
                return None;
            }
        }
    }
    let neighbour = |t: &[u32; 3], edge: usize| sides.get(&(t[(edge + 1) % 3], t[edge])).copied();
    let neighbours = vertices
        .iter()
        .map(|t| Some([neighbour(t, 0)?, neighbour(t, 1)?, neighbour(t, 2)?]))
        .collect::<Option<Vec<_>>>()?;
    let topology = Topology {
        vertices,
        neighbours,
        vertex_count,
    };
    topology.has_single_fans().then_some(topology)
}

impl Topology {
    fn has_single_fans(&self) -> bool {
        let mut seen = vec![false; self.vertex_count];
        let mut walked = 0;
        for (slot, t) in self.vertices.iter().enumerate() {
            for corner in 0..3 {
                let vertex = t[usize::from(corner)] as usize;
                if !seen[vertex] {
                    seen[vertex] = true;
                    walked += self.fan(slot as u32, corner).count();
                }
            }
        }
        // A second fan at some vertex would have been left unwalked.
        walked == 3 * self.vertices.len()
    }
}
