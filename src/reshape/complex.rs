//! A triangle complex that can be edited: edges of one, two, three or more
//! triangles, collapses and flips that keep the topology.

use glam::DVec3;
use rayon::slice::ParallelSliceMut;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::mesh::FaceId;
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};

/// Vertex without triangles, in [`Complex::triangles`].
const GONE: u32 = u32::MAX;

/// What an edge on a line is: how many triangles it has and its mark. A line
/// goes on through a vertex only if its class stays the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class {
    /// Number of triangles.
    pub(super) valence: u32,
    /// What a follower gave it.
    pub(super) mark: Option<Line>,
}

/// What a vertex is to the topology.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rank {
    /// Inside a sheet.
    Inner,
    /// Inside a line.
    Line,
    /// Where lines meet, end or change, or where a pinch is.
    Corner,
}

/// The neighbours of a vertex along its line.
pub(super) type Pair = [u32; 2];

/// An editable triangle complex.
///
/// Lines are the edges with a mark or with a number of triangles other than
/// two. Edits keep the complex homeomorphic to itself, lines going to lines
/// and corners to corners.
pub(super) struct Complex {
    at: Vec<DVec3>,
    coping: Vec<Option<FaceId>>,
    rank: Vec<Rank>,
    triangles: Vec<[u32; 3]>,
    around: Vec<SmallVec<[u32; 8]>>,
    lines: FxHashMap<(u32, u32), Class>,
}

impl Complex {
    /// Triangles with a repeated corner are dropped.
    pub(super) fn new(mesh: &MarkedMesh) -> Complex {
        let sound = |c: &&[u32; 3]| c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(sound).copied().collect();
        let count = mesh.vertices.len();
        let mut around = vec![SmallVec::new(); count];
        let mut edges = Vec::with_capacity(3 * triangles.len());
        for (t, c) in triangles.iter().enumerate() {
            for k in 0..3 {
                around[c[k] as usize].push(t as u32);
                edges.push(edge(c[k], c[(k + 1) % 3]));
            }
        }
        edges.par_sort_unstable();
        let mut complex = Complex {
            at: mesh.vertices.iter().map(|v| v.at).collect(),
            coping: mesh.vertices.iter().map(|v| v.coping).collect(),
            rank: vec![Rank::Inner; count],
            triangles,
            around,
            lines: FxHashMap::default(),
        };
        for group in edges.chunk_by(|a, b| a == b) {
            let mark = (mesh.lines.get(&group[0]).copied()).filter(|&l| l != Line::Sheet);
            let valence = group.len() as u32;
            if valence != 2 || mark.is_some() {
                complex.lines.insert(group[0], Class { valence, mark });
                for v in [group[0].0, group[0].1] {
                    complex.rank[v as usize] = Rank::Line;
                }
            }
        }
        for v in 0..count as u32 {
            let corner = complex.pinched(v)
                || (complex.rank[v as usize] == Rank::Line && complex.line_through(v).is_none());
            if corner {
                complex.rank[v as usize] = Rank::Corner;
            }
        }
        complex
    }

    /// The mesh again: vertices in use and triangles left, in their old order;
    /// `old[v]` is vertex `v`.
    pub(super) fn into_mesh(self, old: &[MarkedVertex]) -> MarkedMesh {
        self.into_mesh_with(old, FxHashMap::default())
    }

    /// As [`into_mesh`](Complex::into_mesh), with marks for further edges.
    pub(super) fn into_mesh_with(
        self,
        old: &[MarkedVertex],
        marks: FxHashMap<(u32, u32), Line>,
    ) -> MarkedMesh {
        let mut number = vec![GONE; self.at.len()];
        let mut vertices = Vec::new();
        for (v, vertex) in old.iter().enumerate() {
            if !self.around[v].is_empty() {
                number[v] = vertices.len() as u32;
                vertices.push(vertex.clone());
            }
        }
        let renumber = |v: u32| number[v as usize];
        let lines = (self.lines.iter()).filter_map(|(e, class)| Some((*e, class.mark?)));
        MarkedMesh {
            vertices,
            triangles: (self.triangles.iter())
                .filter(|c| c[0] != GONE)
                .map(|c| c.map(renumber))
                .collect(),
            lines: lines
                .chain(marks)
                .map(|(e, mark)| (edge(renumber(e.0), renumber(e.1)), mark))
                .collect(),
        }
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.at.len()
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    pub(super) fn at(&self, v: u32) -> DVec3 {
        self.at[v as usize]
    }

    pub(super) fn coping(&self, v: u32) -> Option<FaceId> {
        self.coping[v as usize]
    }

    pub(super) fn rank(&self, v: u32) -> Rank {
        self.rank[v as usize]
    }

    /// Triangles at a vertex; none if it was removed.
    pub(super) fn around(&self, v: u32) -> &[u32] {
        &self.around[v as usize]
    }

    /// Corners of a triangle that still exists.
    pub(super) fn corners(&self, t: u32) -> Option<[u32; 3]> {
        Some(self.triangles[t as usize]).filter(|c| c[0] != GONE)
    }

    /// Class of an edge on a line.
    pub(super) fn class(&self, a: u32, b: u32) -> Option<Class> {
        if self.rank(a) == Rank::Inner || self.rank(b) == Rank::Inner {
            return None;
        }
        self.lines.get(&edge(a, b)).copied()
    }

    /// Whether a sheet ends at an edge.
    pub(super) fn ends_at(&self, a: u32, b: u32) -> bool {
        self.class(a, b).is_some_and(|class| class.valence == 1)
    }

    /// The two neighbours of a vertex along its line, if it has just two,
    /// both over edges of one class.
    pub(super) fn line_through(&self, v: u32) -> Option<Pair> {
        let mut ends: SmallVec<[u32; 4]> = SmallVec::new();
        for &t in self.around(v) {
            for w in self.triangles[t as usize] {
                if w != v && !ends.contains(&w) && self.class(v, w).is_some() {
                    ends.push(w);
                }
            }
        }
        match *ends.as_slice() {
            [a, b] if self.class(v, a) == self.class(v, b) => Some([a.min(b), a.max(b)]),
            _ => None,
        }
    }

    /// Whether the triangles at a vertex hang together only by it.
    fn pinched(&self, v: u32) -> bool {
        let around = self.around(v);
        if around.is_empty() {
            return false;
        }
        // Grow the part of the link that holds the first triangle.
        let mut reached: SmallVec<[u32; 16]> = SmallVec::new();
        let mut taken: SmallVec<[bool; 16]> = SmallVec::from_elem(false, around.len());
        let mut left = around.len();
        loop {
            let before = left;
            for (n, &t) in around.iter().enumerate() {
                let c = self.triangles[t as usize];
                let joined = reached.is_empty() || c.iter().any(|w| *w != v && reached.contains(w));
                if !taken[n] && joined {
                    taken[n] = true;
                    left -= 1;
                    reached.extend(c.into_iter().filter(|w| *w != v));
                }
            }
            if left == 0 {
                return false;
            }
            if left == before {
                return true;
            }
        }
    }

    /// Whether contracting the edge from `u` to `v` keeps the complex
    /// homeomorphic to itself with `u` removed.
    ///
    /// The link conditions for 2-complexes (Dey, Edelsbrunner, Guha, Nekhayev,
    /// "Topology preserving edge contraction", 1999), where edges on lines are
    /// of order one and corners of order two.
    pub(super) fn contractible(&self, u: u32, v: u32) -> bool {
        let class = self.class(u, v);
        match (self.rank(u), self.rank(v)) {
            (Rank::Inner, _) => {}
            (Rank::Line, Rank::Line | Rank::Corner) if class.is_some() => {}
            _ => return false,
        }
        for &t in self.around(u) {
            let c = self.triangles[t as usize];
            if c.contains(&v) {
                // Two lines would fall into one.
                let Some(x) = c.into_iter().find(|&w| w != u && w != v) else {
                    return false;
                };
                if self.class(u, x).is_some() && self.class(v, x).is_some() {
                    return false;
                }
                continue;
            }
            for s in self.around(v) {
                let d = self.triangles[*s as usize];
                if d.contains(&u) {
                    continue;
                }
                let common = (c.iter()).filter(|w| **w != u && d.contains(w));
                let mut count = 0;
                for &x in common {
                    count += 1;
                    // Neighbours in common only across triangles of the edge.
                    if !self.has_triangle(u, v, x) {
                        return false;
                    }
                }
                if count == 2 {
                    return false;
                }
            }
        }
        // A line of three edges must not become one of two.
        if class.is_some()
            && let Some([a, b]) = self.line_through(u)
        {
            let far = if a == v { b } else { a };
            if self.class(v, far).is_some() {
                return false;
            }
        }
        true
    }

    fn has_triangle(&self, a: u32, b: u32, c: u32) -> bool {
        (self.around(a).iter()).any(|&t| {
            let corners = self.triangles[t as usize];
            corners.contains(&b) && corners.contains(&c)
        })
    }

    /// Contracts the edge from `u` to `v`: `u` goes.
    ///
    /// Invariant: [`contractible`](Complex::contractible) said yes.
    pub(super) fn contract(&mut self, u: u32, v: u32) {
        let around = std::mem::take(&mut self.around[u as usize]);
        if self.rank(u) == Rank::Line {
            self.lines.remove(&edge(u, v));
            for &t in &around {
                for w in self.triangles[t as usize] {
                    if w != u
                        && let Some(class) = self.lines.remove(&edge(u, w))
                    {
                        self.lines.insert(edge(v, w), class);
                    }
                }
            }
        }
        for t in around {
            let c = self.triangles[t as usize];
            if c.contains(&v) {
                for w in c.into_iter().filter(|&w| w != u) {
                    self.around[w as usize].retain(|s| *s != t);
                }
                self.triangles[t as usize] = [GONE; 3];
            } else {
                self.triangles[t as usize] = c.map(|w| if w == u { v } else { w });
                self.around[v as usize].push(t);
            }
        }
    }

    /// The two triangles of an edge that has two and is on no line, each with
    /// its third vertex.
    pub(super) fn wings(&self, a: u32, b: u32) -> Option<[(u32, u32); 2]> {
        if self.class(a, b).is_some() {
            return None;
        }
        let mut found: SmallVec<[(u32, u32); 3]> = SmallVec::new();
        for &t in self.around(a) {
            let c = self.triangles[t as usize];
            if c.contains(&b) {
                let third = c.into_iter().find(|&w| w != a && w != b)?;
                found.push((t, third));
            }
        }
        match *found.as_slice() {
            [first, second] if first.1 != second.1 => Some([first, second]),
            _ => None,
        }
    }

    /// Whether two vertices share an edge.
    pub(super) fn adjacent(&self, a: u32, b: u32) -> bool {
        (self.around(a).iter()).any(|&t| self.triangles[t as usize].contains(&b))
    }

    /// Flips the edge `a`, `b` between its two wings.
    ///
    /// Invariant: the wings are those of the edge, their third vertices not
    /// yet adjacent. Corners keep their order, so a triangle keeps the
    /// orientation that it had.
    pub(super) fn flip(&mut self, a: u32, b: u32, [(s, c), (t, d)]: [(u32, u32); 2]) {
        // s = abc loses b for d, t = abd loses a for c.
        let swap =
            |corners: [u32; 3], old: u32, new: u32| corners.map(|w| if w == old { new } else { w });
        self.triangles[s as usize] = swap(self.triangles[s as usize], b, d);
        self.triangles[t as usize] = swap(self.triangles[t as usize], a, c);
        self.around[b as usize].retain(|x| *x != s);
        self.around[d as usize].push(s);
        self.around[a as usize].retain(|x| *x != t);
        self.around[c as usize].push(t);
    }

    /// Moves a vertex.
    pub(super) fn put(&mut self, v: u32, at: DVec3) {
        self.at[v as usize] = at;
    }

    /// Makes a vertex a corner: lines end there.
    pub(super) fn pin(&mut self, v: u32) {
        self.rank[v as usize] = Rank::Corner;
    }

    /// All edges in ascending order, low vertex first.
    pub(super) fn edges(&self) -> Vec<(u32, u32)> {
        let mut all: Vec<(u32, u32)> = (self.triangles.iter())
            .filter(|c| c[0] != GONE)
            .flat_map(|c| [0, 1, 2].map(|k| edge(c[k], c[(k + 1) % 3])))
            .collect();
        all.par_sort_unstable();
        all.dedup();
        all
    }

    /// Edges on lines, ascending.
    pub(super) fn line_edges(&self) -> Vec<((u32, u32), Class)> {
        let mut all: Vec<_> = self.lines.iter().map(|(&e, &class)| (e, class)).collect();
        all.sort_unstable_by_key(|l| l.0);
        all
    }

    /// Splits an edge, and with it all its triangles, by a new vertex at `at`,
    /// whose number is returned. Lines go on through it.
    pub(super) fn split(&mut self, a: u32, b: u32, at: DVec3) -> u32 {
        let middle = self.add_middle(a, b, at);
        let beside: SmallVec<[u32; 4]> = (self.around(a).iter().copied())
            .filter(|&t| self.triangles[t as usize].contains(&b))
            .collect();
        for t in beside {
            let corners = self.triangles[t as usize];
            let new = self.triangles.len() as u32;
            self.triangles[t as usize] = corners.map(|w| if w == b { middle } else { w });
            self.triangles
                .push(corners.map(|w| if w == a { middle } else { w }));
            self.around[b as usize].retain(|s| *s != t);
            self.around[b as usize].push(new);
            self.around[middle as usize].extend([t, new]);
            for c in corners.into_iter().filter(|&c| c != a && c != b) {
                self.around[c as usize].push(new);
            }
        }
        middle
    }

    /// Splits a triangle by a new vertex inside it, whose number is returned.
    pub(super) fn insert(&mut self, t: u32, at: DVec3) -> u32 {
        let middle = self.add_inner(at);
        let [a, b, c] = self.triangles[t as usize];
        let new = self.triangles.len() as u32;
        self.triangles[t as usize] = [a, b, middle];
        self.triangles.extend([[b, c, middle], [c, a, middle]]);
        self.around[c as usize].retain(|s| *s != t);
        self.around[b as usize].push(new);
        self.around[c as usize].extend([new, new + 1]);
        self.around[a as usize].push(new + 1);
        self.around[middle as usize].extend([t, new, new + 1]);
        middle
    }

    /// Adds a vertex on an edge whose triangles the caller will change: lines go
    /// on through it.
    pub(super) fn add_middle(&mut self, a: u32, b: u32, at: DVec3) -> u32 {
        let class = self.class(a, b);
        let middle = self.add_inner(at);
        if let Some(class) = class {
            self.rank[middle as usize] = Rank::Line;
            self.lines.remove(&edge(a, b));
            self.lines.insert(edge(a, middle), class);
            self.lines.insert(edge(middle, b), class);
        }
        middle
    }

    /// Adds a vertex inside a sheet, without triangles.
    pub(super) fn add_inner(&mut self, at: DVec3) -> u32 {
        self.at.push(at);
        self.coping.push(None);
        self.around.push(SmallVec::new());
        self.rank.push(Rank::Inner);
        self.at.len() as u32 - 1
    }

    /// Puts other triangles in the place of all: of the same sheets, between the
    /// same lines.
    pub(super) fn replace(&mut self, triangles: Vec<[u32; 3]>) {
        self.around.iter_mut().for_each(SmallVec::clear);
        for (t, c) in triangles.iter().enumerate() {
            for v in c {
                self.around[*v as usize].push(t as u32);
            }
        }
        self.triangles = triangles;
    }
}
