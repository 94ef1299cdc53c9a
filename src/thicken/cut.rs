//! The contour cut off near the patch.
//!
//! The contour of the solid closes it on all sides, on the patch's side by a
//! copy of the patch that is not wanted. Points of the solid's surface at a
//! distance of `level` from the patch lie on the cross-section, and what is
//! farther away is the rest of the cross-section and the inner shell. So the
//! contour is cut along that level, and what is nearer is dropped: the curves
//! of the cut run along the boundary curves, at one height on the strips.
//!
//! Here we leave the paper, which neglects single faces near the patch and
//! lets the others reach for boundary vertices: a cut leaves clean curves
//! whatever the cells, with no holes to be found and filled one by one.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::mesh::TriMesh;

use super::patch::Patch;

/// What is left of the contour.
pub(super) struct Cut {
    pub mesh: TriMesh,
    /// Curves of the cut, as vertices in the order in which the triangles run
    /// them.
    pub curves: Vec<Vec<u32>>,
}

impl Cut {
    /// Merges neighbours of a curve for which `same` holds, the later into the
    /// earlier, and drops the triangles that this flattens. `same` is given
    /// places within the curve.
    pub fn merge(&mut self, curve: usize, same: impl Fn(usize, usize) -> bool) -> Vec<usize> {
        let vertices = &self.curves[curve];
        let mut into: FxHashMap<u32, u32> = FxHashMap::default();
        let mut kept: Vec<usize> = Vec::with_capacity(vertices.len());
        for i in 0..vertices.len() {
            match kept.last() {
                Some(&last) if same(last, i) => {
                    into.insert(vertices[i], vertices[last]);
                }
                _ => kept.push(i),
            }
        }
        while let [first, .., last] = kept[..]
            && kept.len() > 3
            && same(last, first)
        {
            into.insert(vertices[last], vertices[first]);
            kept.pop();
        }
        self.curves[curve] = kept.iter().map(|&i| vertices[i]).collect();
        if !into.is_empty() {
            let name = |mut v: u32| {
                while let Some(&other) = into.get(&v) {
                    v = other;
                }
                v
            };
            for t in &mut self.mesh.triangles {
                *t = t.map(name);
            }
            let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
            self.mesh.triangles.retain(whole);
        }
        kept
    }
}

/// Distance of each vertex from the patch.
pub(super) fn distances(patch: &Patch, mesh: &TriMesh) -> Vec<f64> {
    let positions = mesh.positions.par_iter();
    positions
        .map(|&p| patch.field.footpoint(p).distance)
        .collect()
}

/// The part of a closed mesh whose vertices are at least `level` away.
pub(super) fn cut(mesh: &TriMesh, distances: &[f64], level: f64) -> Cut {
    let mut out = Builder {
        mesh,
        distances,
        level,
        positions: Vec::new(),
        triangles: Vec::new(),
        kept: vec![u32::MAX; mesh.positions.len()],
        made: FxHashMap::default(),
        next: FxHashMap::default(),
    };
    for &t in &mesh.triangles {
        out.triangle(t);
    }
    let curves = out.curves();
    Cut {
        mesh: TriMesh {
            positions: out.positions,
            triangles: out.triangles,
        },
        curves,
    }
}

struct Builder<'a> {
    mesh: &'a TriMesh,
    distances: &'a [f64],
    level: f64,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// New number of each kept vertex.
    kept: Vec<u32>,
    /// Vertices on cut edges.
    made: FxHashMap<[u32; 2], u32>,
    /// Edges of the cut, by their first vertex.
    next: FxHashMap<u32, u32>,
}

impl Builder<'_> {
    fn is_kept(&self, v: u32) -> bool {
        self.distances[v as usize] >= self.level
    }

    fn triangle(&mut self, t: [u32; 3]) {
        let Some(first) = (0..3).find(|&i| self.is_kept(t[i]) && !self.is_kept(t[(i + 2) % 3]))
        else {
            if self.is_kept(t[0]) {
                let whole = t.map(|v| self.keep(v));
                self.triangles.push(whole);
            }
            return;
        };
        // Kept from `a` on; the corner before it is not.
        let [a, b, c] = [0, 1, 2].map(|i| t[(first + i) % 3]);
        let (low, last) = (self.made_on(a, c), self.keep(a));
        if self.is_kept(b) {
            let (b_kept, high) = (self.keep(b), self.made_on(b, c));
            // The shorter diagonal.
            let at = |v: u32| self.positions[v as usize];
            if at(last).distance_squared(at(high)) < at(b_kept).distance_squared(at(low)) {
                self.triangles.push([last, b_kept, high]);
                self.triangles.push([last, high, low]);
            } else {
                self.triangles.push([last, b_kept, low]);
                self.triangles.push([b_kept, high, low]);
            }
            self.next.insert(high, low);
        } else {
            let high = self.made_on(a, b);
            self.triangles.push([last, high, low]);
            self.next.insert(high, low);
        }
    }

    fn keep(&mut self, v: u32) -> u32 {
        let slot = &mut self.kept[v as usize];
        if *slot == u32::MAX {
            *slot = self.positions.len() as u32;
            self.positions.push(self.mesh.positions[v as usize]);
        }
        *slot
    }

    /// The vertex between a kept one and one that is not.
    fn made_on(&mut self, a: u32, b: u32) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(&v) = self.made.get(&key) {
            return v;
        }
        let [from, to] = key.map(|v| (self.mesh.positions[v as usize], self.distances[v as usize]));
        let way = (self.level - from.1) / (to.1 - from.1);
        let v = self.positions.len() as u32;
        self.positions.push(from.0.lerp(to.0, way));
        self.made.insert(key, v);
        v
    }

    /// The mesh is a closed manifold and the cut meets no vertex, so every
    /// vertex of the cut has one edge before and one after it.
    fn curves(&mut self) -> Vec<Vec<u32>> {
        let mut starts: Vec<u32> = self.next.keys().copied().collect();
        starts.sort_unstable();
        let mut curves = Vec::new();
        for start in starts {
            let mut curve = Vec::new();
            let mut at = start;
            while let Some(then) = self.next.remove(&at) {
                curve.push(at);
                at = then;
            }
            if !curve.is_empty() {
                curves.push(curve);
            }
        }
        curves
    }
}
