//! Which triangles pair to quadrilaterals: a matching among the pairs that make a
//! good one (Remacle and others, "Blossom-Quad", 2012), grown by augmenting
//! paths of bounded length: unlike the maximum matching there, it takes time in
//! proportion to the mesh.

use smallvec::SmallVec;

use super::Remesher;
use super::faces::{Face, Pairing, jacobian};

/// Pairs that may change partners to let one more pair in. A maximum matching
/// would search farther for next to nothing.
const LONGEST: usize = 9;

/// What makes a triangle half of a quadrilateral: its other half, and the
/// corners of both.
type Half = (u32, [u32; 4]);

/// A matching that grows.
struct Matching {
    /// Good other halves of each triangle, best first.
    options: Vec<SmallVec<[Half; 3]>>,
    halves: Vec<Option<Half>>,
}

impl Matching {
    fn is_lone(&self, t: u32) -> bool {
        self.halves[t as usize].is_none()
    }

    fn join(&mut self, s: u32, t: u32, quad: [u32; 4]) {
        self.halves[s as usize] = Some((t, quad));
        self.halves[t as usize] = Some((s, quad));
    }

    /// Gives a triangle another half over at most `depth` pairs that change
    /// partners; `path` holds the triangles on the way. Whether it did.
    fn augment(&mut self, t: u32, depth: usize, path: &mut SmallVec<[u32; 32]>) -> bool {
        path.push(t);
        for n in 0..self.options[t as usize].len() {
            let (s, quad) = self.options[t as usize][n];
            if path.contains(&s) {
                continue;
            }
            let partner = self.halves[s as usize].map(|half| half.0);
            let free = match partner {
                None => true,
                Some(p) if depth > 0 && !path.contains(&p) => {
                    path.push(s);
                    let moved = self.augment(p, depth - 1, path);
                    moved || {
                        path.pop();
                        false
                    }
                }
                Some(_) => false,
            };
            if free {
                self.join(t, s, quad);
                return true;
            }
        }
        path.pop();
        false
    }
}

impl Remesher<'_> {
    /// Pairs triangles, those of the best shape first, then along paths on
    /// which pairs and other good neighbours alternate: such a path between two
    /// lone triangles gives one pair more. Pairs that are there, `face_of` each
    /// triangle, go before all others.
    pub(super) fn matched(&self, pairing: Pairing, face_of: &[u32]) -> Vec<Face> {
        let count = self.complex.triangle_count();
        let paired = |s: u32, t: u32| {
            let face = |t: u32| face_of.get(t as usize);
            face(s).is_some() && face(s) == face(t)
        };
        let mut wanted: Vec<(f64, u32, u32, [u32; 4])> = Vec::new();
        for (a, b) in self.complex.edges() {
            let Some([(s, c), (t, d)]) = self.complex.wings(a, b) else {
                continue;
            };
            // Both triangles run the same way round the quadrilateral.
            let quad = [a, d, b, c];
            if self.makes(quad, pairing) {
                let quality = jacobian(quad.map(|v| self.complex.at(v)));
                let before = f64::from(paired(s, t));
                wanted.push((quality + before, s, t, quad));
            }
        }
        wanted.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let mut matching = Matching {
            options: vec![SmallVec::new(); count],
            halves: vec![None; count],
        };
        for (_, s, t, quad) in wanted {
            matching.options[s as usize].push((t, quad));
            matching.options[t as usize].push((s, quad));
            if matching.is_lone(s) && matching.is_lone(t) {
                matching.join(s, t, quad);
            }
        }
        for depth in 1..=LONGEST {
            for t in 0..count as u32 {
                if matching.is_lone(t) && self.complex.corners(t).is_some() {
                    matching.augment(t, depth, &mut SmallVec::new());
                }
            }
        }
        let face = |(t, half): (u32, &Option<Half>)| match half {
            Some((other, quad)) => (t < *other).then(|| Face::from_slice(quad)),
            None => self.complex.corners(t).map(|c| Face::from_slice(&c)),
        };
        (0..).zip(&matching.halves).filter_map(face).collect()
    }
}
