//! Edges of a non-manifold triangle mesh and the triangles at each.

use rayon::slice::ParallelSliceMut;
use rustc_hash::FxHashMap;

/// All edges, in ascending order of their vertices.
pub(crate) struct Edges {
    /// Vertices, lower first.
    pub(crate) ends: Vec<[u32; 2]>,
    /// Edge `k` of a face runs from its corner `k` to its corner `k + 1`.
    pub(crate) of_face: Vec<[u32; 3]>,
    /// Uses of edge `e`: `uses[first[e]..first[e + 1]]`.
    first: Vec<u32>,
    /// `3 * face + k`, ascending within an edge.
    uses: Vec<u32>,
}

impl Edges {
    /// Edges of triangles without repeated corners.
    pub(crate) fn new(triangles: &[[u32; 3]]) -> Edges {
        let mut all: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        for (t, c) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (c[k], c[(k + 1) % 3]);
                all.push(([a.min(b), a.max(b)], (3 * t + k) as u32));
            }
        }
        // No two entries are equal: the order does not depend on threads.
        all.par_sort_unstable();
        let mut edges = Edges {
            ends: Vec::new(),
            of_face: vec![[0; 3]; triangles.len()],
            first: Vec::new(),
            uses: Vec::with_capacity(all.len()),
        };
        for (ends, slot) in all {
            if edges.ends.last() != Some(&ends) {
                edges.first.push(edges.uses.len() as u32);
                edges.ends.push(ends);
            }
            edges.of_face[slot as usize / 3][slot as usize % 3] = edges.ends.len() as u32 - 1;
            edges.uses.push(slot);
        }
        edges.first.push(edges.uses.len() as u32);
        edges
    }

    /// Number of edges.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The edge between two vertices.
    pub(crate) fn find(&self, a: u32, b: u32) -> Option<usize> {
        self.ends.binary_search(&[a.min(b), a.max(b)]).ok()
    }

    /// Uses of an edge as `3 * face + k`.
    pub(crate) fn uses(&self, edge: usize) -> &[u32] {
        &self.uses[self.first[edge] as usize..self.first[edge + 1] as usize]
    }

    /// The two faces of an edge that has exactly two.
    pub(crate) fn pair(&self, edge: usize) -> Option<[u32; 2]> {
        match self.uses(edge) {
            &[a, b] => Some([a / 3, b / 3]),
            _ => None,
        }
    }
}

/// A chain of edges.
pub(crate) struct Chain {
    /// Vertices in order; a closed chain does not repeat its first.
    pub(crate) path: Vec<u32>,
    /// Whether the last vertex is joined to the first.
    pub(crate) closed: bool,
    /// Class of its edges.
    pub(crate) class: u32,
}

/// Chains edges of equal class; `edges` in ascending order.
///
/// A chain goes on through a vertex where exactly two of the edges meet, both
/// of one class, and which is not in `stops`. Open chains come first, each
/// from the end with the lower vertex, in order of that end; then loops from
/// their lowest vertex towards its lower neighbour.
pub(crate) fn chains(edges: &[([u32; 2], u32)], stops: &dyn Fn(u32) -> bool) -> Vec<Chain> {
    let mut at: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for (n, (ends, _)) in edges.iter().enumerate() {
        for v in ends {
            at.entry(*v).or_default().push(n as u32);
        }
    }
    // The edge by which a chain that came by edge `n` leaves `v`.
    let onward = |v: u32, n: u32| match at[&v].as_slice() {
        &[a, b] if edges[a as usize].1 == edges[b as usize].1 && !stops(v) => Some(a ^ b ^ n),
        _ => None,
    };
    let mut used = vec![false; edges.len()];
    let mut out = Vec::new();
    let walk = |start: u32, first: u32, used: &mut Vec<bool>| {
        let mut path = vec![start];
        let (mut v, mut n) = (start, first);
        let closed = loop {
            used[n as usize] = true;
            let ends = edges[n as usize].0;
            // The other end.
            v ^= ends[0] ^ ends[1];
            match onward(v, n) {
                // Back at the start of a loop.
                Some(next) if used[next as usize] => break true,
                Some(next) => {
                    path.push(v);
                    n = next;
                }
                None => {
                    path.push(v);
                    break false;
                }
            }
        };
        let class = edges[first as usize].1;
        Chain {
            path,
            closed,
            class,
        }
    };
    let mut vertices: Vec<u32> = at.keys().copied().collect();
    vertices.sort_unstable();
    for loops in [false, true] {
        for &v in &vertices {
            for &n in &at[&v] {
                if !used[n as usize] && (loops || onward(v, n).is_none()) {
                    out.push(walk(v, n, &mut used));
                }
            }
        }
    }
    out
}
