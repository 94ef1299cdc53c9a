//! Triangles and pairs of triangles to quadrilaterals: long edges are halved.
//!
//! A mesh of twice the size is paired to quadrilaterals as far as good ones come
//! of it; then every edge that is long against the size wanted is halved. A
//! quadrilateral whose sides are all long becomes four, a triangle three, round
//! its centre; with one or two long sides they become fewer. So no triangle
//! remains where elements are of the size wanted, whatever the layout of the
//! vertices (as Remacle and others, "Blossom-Quad", 2012, propose for full-quad
//! meshes), and small features are not halved. Middles lie on their lines and
//! sheets, so the result conforms and is as true as before.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::{SmallVec, smallvec};

use super::Remesher;
use super::edits::LONG;
use super::faces::{Face, Faces, Pairing, quality};
use crate::mesh::FaceId;
use crate::reshape::facing::TURN;
use crate::reshape::shape::Shape;
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

/// Which sides of a face are halved; sides run from a corner to the next.
#[derive(Clone, Copy, PartialEq)]
enum Pattern {
    None,
    /// A side.
    One(usize),
    /// A side and the one across.
    Opposite(usize),
    /// A side and the next.
    Adjacent(usize),
    All,
}

impl Pattern {
    /// All but one side count as all: the last one is to be halved too.
    fn of(face: &Face, halved: &FxHashSet<(u32, u32)>) -> Pattern {
        let sides = face.len();
        let is_halved = |k: usize| halved.contains(&side(face, k));
        let all: SmallVec<[usize; 4]> = (0..sides).filter(|&k| is_halved(k)).collect();
        match *all {
            [] => Pattern::None,
            [k] => Pattern::One(k),
            [0, 2] if sides == 4 => Pattern::Opposite(0),
            [1, 3] if sides == 4 => Pattern::Opposite(1),
            [0, 3] if sides == 4 => Pattern::Adjacent(3),
            [k, _] if sides == 4 => Pattern::Adjacent(k),
            _ => Pattern::All,
        }
    }

    fn has_centre(self) -> bool {
        matches!(self, Pattern::Adjacent(_) | Pattern::All)
    }
}

/// The side of a face from a corner on.
fn side(face: &Face, k: usize) -> (u32, u32) {
    edge(face[k % face.len()], face[(k + 1) % face.len()])
}

/// The faces that one becomes; `None` if a middle or centre is missing.
fn cut_up(
    face: &Face,
    pattern: Pattern,
    middle: &dyn Fn(usize) -> Option<u32>,
    centre: Option<u32>,
    at: &dyn Fn(u32) -> DVec3,
) -> Option<SmallVec<[Face; 4]>> {
    let sides = face.len();
    // Corners counted from the end of a side on.
    let from = |k: usize| move |n: usize| face[(k + n) % sides];
    Some(match pattern {
        Pattern::None => smallvec![face.clone()],
        Pattern::One(k) => {
            let (c, m) = (from(k), middle(k)?);
            if sides == 3 {
                return Some(smallvec![
                    smallvec![c(0), m, c(2)],
                    smallvec![m, c(1), c(2)]
                ]);
            }
            let one: [Face; 2] = [smallvec![m, c(1), c(2)], smallvec![c(0), m, c(2), c(3)]];
            let two: [Face; 2] = [smallvec![c(0), m, c(3)], smallvec![m, c(1), c(2), c(3)]];
            let better = worst(&one, at) >= worst(&two, at);
            if better { one } else { two }.into_iter().collect()
        }
        Pattern::Opposite(k) => {
            let (c, m, n) = (from(k), middle(k)?, middle(k + 2)?);
            smallvec![smallvec![c(0), m, n, c(3)], smallvec![m, c(1), c(2), n]]
        }
        Pattern::Adjacent(k) => {
            let (c, m, n) = (from(k), middle(k)?, middle(k + 1)?);
            let x = centre?;
            smallvec![
                smallvec![c(0), m, x, c(3)],
                smallvec![m, c(1), n, x],
                smallvec![x, n, c(2), c(3)]
            ]
        }
        Pattern::All => {
            let x = centre?;
            let part = |k: usize| {
                let [m, n] = [middle(k)?, middle(k + sides - 1)?];
                Some(Face::from_slice(&[face[k], m, x, n]))
            };
            (0..sides).map(part).collect::<Option<_>>()?
        }
    })
}

fn worst(faces: &[Face], at: &dyn Fn(u32) -> DVec3) -> f64 {
    let qualities = faces.iter().map(|face| {
        let corners: SmallVec<[DVec3; 4]> = face.iter().map(|&v| at(v)).collect();
        quality(&corners)
    });
    qualities.fold(1.0, f64::min)
}

impl Remesher<'_> {
    /// Cuts all up to quadrilaterals.
    pub(super) fn halve(&mut self) -> Faces {
        let coarse = self.matched(COARSE, &[]);
        let halved = self.long_sides(&coarse);
        let patterns: Vec<Pattern> = coarse.iter().map(|f| Pattern::of(f, &halved)).collect();
        // The centre of a quadrilateral is the middle of the edge inside it.
        let diagonals = (coarse.iter().zip(&patterns))
            .filter(|(face, pattern)| face.len() == 4 && pattern.has_centre())
            .map(|(face, _)| edge(face[0], face[2]));
        let mut edges: Vec<(u32, u32)> = halved.iter().copied().chain(diagonals).collect();
        edges.sort_unstable();
        let lone: Vec<&Face> = (coarse.iter().zip(&patterns))
            .filter(|(face, pattern)| face.len() == 3 && pattern.has_centre())
            .map(|(face, _)| face)
            .collect();
        // All are found before anything changes.
        let this = &*self;
        let middles: Vec<(MarkedVertex, bool)> = (edges.par_iter())
            .map(|&(a, b)| this.halfway(a, b))
            .collect();
        let centres: Vec<(MarkedVertex, bool)> =
            lone.par_iter().map(|face| this.centre_of(face)).collect();

        let mut middle: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for ((a, b), (vertex, chord)) in edges.into_iter().zip(middles) {
            let new = self.complex.add_middle(a, b, vertex.at);
            self.note_middle([a, b], new, vertex, chord);
            middle.insert((a, b), new);
        }
        let mut new: Vec<u32> = Vec::with_capacity(centres.len());
        for (face, (vertex, chord)) in lone.into_iter().zip(centres) {
            new.push(self.complex.add_inner(vertex.at));
            self.note_vertex(new[new.len() - 1], vertex, chord, face);
        }
        let mut centres = new.into_iter();
        let mut faces: Vec<Face> = Vec::new();
        for (face, pattern) in coarse.iter().zip(patterns) {
            let centre = match face.len() {
                _ if !pattern.has_centre() => None,
                4 => middle.get(&edge(face[0], face[2])).copied(),
                _ => centres.next(),
            };
            let middle = |k: usize| middle.get(&side(face, k)).copied();
            match cut_up(face, pattern, &middle, centre, &|v| self.complex.at(v)) {
                Some(parts) => faces.extend(parts),
                None => faces.push(face.clone()),
            }
        }
        self.size = std::mem::take(&mut self.fine);
        self.cut(faces)
    }

    /// Sides that are long against the size wanted, and the last side of a face
    /// of which all others are.
    fn long_sides(&self, faces: &[Face]) -> FxHashSet<(u32, u32)> {
        let mut halved: FxHashSet<(u32, u32)> = FxHashSet::default();
        for face in faces {
            for (a, b) in (0..face.len()).map(|k| side(face, k)) {
                let wanted = 0.5 * (self.fine[a as usize] + self.fine[b as usize]);
                if self.length(a, b) > LONG * wanted && !self.is_left(a, b) {
                    halved.insert((a, b));
                }
            }
        }
        loop {
            let before = halved.len();
            for face in faces {
                if Pattern::of(face, &halved) == Pattern::All {
                    halved.extend((0..face.len()).map(|k| side(face, k)));
                }
            }
            if halved.len() == before {
                return halved;
            }
        }
    }

    /// The point of a sheet at the middle of a triangle, and whether it is on
    /// the chord only.
    fn centre_of(&self, corners: &Face) -> (MarkedVertex, bool) {
        let at = [0, 1, 2].map(|k| self.complex.at(corners[k]));
        let guess = (at[0] + at[1] + at[2]) / 3.0;
        let hints: SmallVec<[FaceId; 12]> = (corners.iter())
            .flat_map(|&v| self.vertices[v as usize].walls.iter().copied())
            .collect();
        let longest = (0..3).map(|k| at[k].distance(at[(k + 1) % 3]));
        let reach = REACH * longest.fold(0.0, f64::max);
        let whole = Shape::of(at).normal;
        // Beside a bend the nearest point may be that of another wall.
        let turns_none = |v: &MarkedVertex| {
            (0..3).all(|k| {
                let part = Shape::of([at[k], at[(k + 1) % 3], v.at]);
                part.normal.dot(whole) >= TURN
            })
        };
        match self
            .ground
            .on_sheet(guess, &hints, reach)
            .filter(turns_none)
        {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every way to halve some sides of a face fills it: sides inside come twice,
    /// once each way, halved sides in halves, and areas add up.
    #[test]
    fn parts_fill_the_face_whatever_sides_are_halved() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.1, 0.9], [0.0, 1.0]];
        for sides in [3, 4] {
            let corners = square[..sides].iter().map(|&[x, y]| DVec3::new(x, y, 0.0));
            let mut points: Vec<DVec3> = corners.collect();
            let face: Face = (0..sides as u32).collect();
            for k in 0..sides {
                points.push(points[k].midpoint(points[(k + 1) % sides]));
            }
            points.push(points[..sides].iter().sum::<DVec3>() / sides as f64);
            let at = |v: u32| points[v as usize];
            for mask in 0u32..1 << sides {
                let is_halved = |k: &usize| mask >> k & 1 == 1;
                let mut halved: FxHashSet<_> = (0..sides)
                    .filter(is_halved)
                    .map(|k| side(&face, k))
                    .collect();
                let pattern = Pattern::of(&face, &halved);
                if pattern == Pattern::All {
                    halved.extend((0..sides).map(|k| side(&face, k)));
                }
                let middle = |k: usize| {
                    let known = halved.contains(&side(&face, k));
                    known.then_some((sides + k % sides) as u32)
                };
                let centre = pattern.has_centre().then_some(2 * sides as u32);
                let parts = cut_up(&face, pattern, &middle, centre, &at).unwrap();
                let mut open: FxHashSet<(u32, u32)> = FxHashSet::default();
                let mut area = DVec3::ZERO;
                for part in &parts {
                    for k in 0..part.len() {
                        let (a, b) = (part[k], part[(k + 1) % part.len()]);
                        area += 0.5 * at(a).cross(at(b));
                        if !open.remove(&(b, a)) {
                            assert!(open.insert((a, b)), "{sides} {mask:b}: {a} {b} twice");
                        }
                    }
                }
                let mut rim: FxHashSet<(u32, u32)> = FxHashSet::default();
                for k in 0..sides {
                    let (a, b) = (face[k], face[(k + 1) % sides]);
                    match middle(k) {
                        Some(m) => rim.extend([(a, m), (m, b)]),
                        None => rim.extend([(a, b)]),
                    }
                }
                assert_eq!(open, rim, "{sides} {mask:b}");
                let whole = (1..sides - 1)
                    .map(|k| 0.5 * (at(k as u32) - at(0)).cross(at(k as u32 + 1) - at(0)).z);
                assert!(
                    (area.z - whole.sum::<f64>()).abs() < 1e-12,
                    "{sides} {mask:b}"
                );
                let triangles = parts.iter().filter(|p| p.len() == 3).count();
                let odd = (sides + halved.len()) % 2 == 1;
                assert!(odd || sides == 3 || triangles == 0, "{sides} {mask:b}");
            }
        }
    }
}
