//! Triangles and pairs of triangles to quadrilaterals: every edge is halved.
//!
//! A mesh of twice the size is paired to quadrilaterals as far as good ones come
//! of it; then every quadrilateral becomes four and every triangle left becomes
//! three, round its centre. So no triangle remains wherever the layout of the
//! vertices does not allow a perfect matching (as Remacle and others,
//! "Blossom-Quad", 2012, propose for full-quad meshes). Middles lie on their
//! lines and sheets, so the result conforms and is as true as before.

use rayon::prelude::*;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::Remesher;
use super::quads::Pairing;
use crate::mesh::FaceId;
use crate::surface::marked::{MarkedVertex, edge};

/// Pairs that become four good quadrilaterals: these bend by half as much on a
/// curved wall, but are as skew.
const COARSE: Pairing = Pairing {
    least: 0.6,
    warp: 14.0,
};

/// How far the centre of a triangle may lie off the chord, in shares of its
/// longest edge.
const REACH: f64 = 0.3;

/// A triangle or quadrilateral before it is cut up, with its centre.
struct Outline {
    corners: SmallVec<[u32; 4]>,
    centre: u32,
}

impl Remesher<'_> {
    /// Cuts all up to quadrilaterals. Triangles `2 n` and `2 n + 1` are the halves
    /// of quadrilateral `n` from then on.
    pub(super) fn halve(&mut self) -> Vec<[u32; 4]> {
        let pairs = self.matched(COARSE);
        let edges = self.complex.edges();
        let lone: Vec<[u32; 3]> = (0..pairs.len() as u32)
            .filter(|&t| pairs[t as usize].is_none())
            .filter_map(|t| self.complex.corners(t))
            .collect();
        // All are found before anything changes.
        let this = &*self;
        let middles: Vec<(MarkedVertex, bool)> = (edges.par_iter())
            .map(|&(a, b)| this.halfway(a, b))
            .collect();
        let centres: Vec<(MarkedVertex, bool)> =
            lone.par_iter().map(|&c| this.centre_of(c)).collect();

        let mut middle: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for ((a, b), (vertex, chord)) in edges.into_iter().zip(middles) {
            let new = self.complex.add_middle(a, b, vertex.at);
            self.note_middle([a, b], new, vertex, chord);
            middle.insert((a, b), new);
        }
        let mut outlines: Vec<Outline> = Vec::new();
        for (t, half) in pairs.iter().enumerate() {
            if let Some((other, corners)) = half
                && t < *other as usize
            {
                // The middle of the edge between the two triangles.
                let centre = middle[&edge(corners[0], corners[2])];
                let corners = SmallVec::from_slice(corners);
                outlines.push(Outline { corners, centre });
            }
        }
        for (corners, (vertex, chord)) in lone.into_iter().zip(centres) {
            let centre = self.complex.add_inner(vertex.at);
            let size = corners.iter().map(|&c| self.size[c as usize]).sum::<f64>() / 3.0;
            self.note_vertex(centre, vertex, chord, size);
            let corners = SmallVec::from_slice(&corners);
            outlines.push(Outline { corners, centre });
        }
        for size in &mut self.size {
            *size *= 0.5;
        }
        let mut quads: Vec<[u32; 4]> = Vec::new();
        for Outline { corners, centre } in outlines {
            let count = corners.len();
            let side = |k: usize| middle[&edge(corners[k % count], corners[(k + 1) % count])];
            quads.extend((0..count).map(|k| [corners[k], side(k), centre, side(k + count - 1)]));
        }
        self.cut_to_quads(&quads);
        quads
    }

    /// Replaces all triangles by the halves of quadrilaterals, cut along the
    /// diagonal that makes the better ones.
    pub(super) fn cut_to_quads(&mut self, quads: &[[u32; 4]]) {
        let mut triangles = Vec::with_capacity(2 * quads.len());
        for &[a, b, c, d] in quads {
            let worst = |pair: [[u32; 3]; 2]| {
                let [p, q] = pair.map(|c| self.complex.shape(c).sine);
                p.min(q)
            };
            let [one, two] = [[[a, b, c], [a, c, d]], [[b, c, d], [b, d, a]]];
            triangles.extend(if worst(one) >= worst(two) { one } else { two });
        }
        self.complex.replace(triangles);
    }

    /// The point of a sheet at the middle of a triangle, and whether it is on
    /// the chord only.
    fn centre_of(&self, corners: [u32; 3]) -> (MarkedVertex, bool) {
        let at = corners.map(|v| self.complex.at(v));
        let guess = (at[0] + at[1] + at[2]) / 3.0;
        let hints: SmallVec<[FaceId; 12]> = (corners.iter())
            .flat_map(|&v| self.vertices[v as usize].walls.iter().copied())
            .collect();
        let longest = (0..3).map(|k| at[k].distance(at[(k + 1) % 3]));
        let reach = REACH * longest.fold(0.0, f64::max);
        match self.ground.on_sheet(guess, &hints, reach) {
            Some(found) => (found, false),
            None => {
                let nearest = self.vertices[corners[0] as usize].clone();
                let chord = MarkedVertex {
                    at: guess,
                    coping: None,
                    ..nearest
                };
                (chord, true)
            }
        }
    }
}
