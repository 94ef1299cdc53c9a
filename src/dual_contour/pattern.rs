//! How a surface may pass between the corners of a cell.
//!
//! Numbers: corner `x + 2 y + 4 z`. Edge `4 axis + u + 2 v`, where `u` and `v`
//! are the corner's bits along the two axes that follow `axis` (x, y, z, x...).
//! Face `2 axis + side`.
//!
//! On each face the surface leaves a *trace* from crossed edge to crossed edge.
//! A face with four crossed edges is *ambiguous*: its inside corners may be
//! *joined* to each other, or parted, and the cells that share it have to agree.
//! The traces of a cell join to closed *loops*, each of which gets a vertex of
//! its own. Sets of corners and of faces are bits.

use std::sync::LazyLock;

/// Two corners of an edge.
pub(super) fn edge_corners(edge: usize) -> [usize; 2] {
    let (axis, u, v) = (edge / 4, edge % 2, edge / 2 % 2);
    let low = u << ((axis + 1) % 3) | v << ((axis + 2) % 3);
    [low, low | 1 << axis]
}

/// The four edges of a face: two along the axis after the face's own, then
/// two along the one after that.
pub(super) fn face_edges(face: usize) -> [usize; 4] {
    let (a, side) = (face / 2, face % 2);
    let (b, c) = ((a + 1) % 3, (a + 2) % 3);
    [
        4 * b + 2 * side,
        4 * b + 2 * side + 1,
        4 * c + side,
        4 * c + side + 2,
    ]
}

/// How the surface passes through a cell.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// Number of loops; none if no edge is crossed.
    pub loops: usize,
    /// Loop of each crossed edge.
    pub loop_of: [u8; 12],
    /// Bit a face: it has four crossed edges.
    pub ambiguous: u8,
}

impl Pattern {
    fn new(corners: u8, joined: u8) -> Pattern {
        let crossed = |edge: usize| {
            let [a, b] = edge_corners(edge);
            (corners >> a ^ corners >> b) & 1 != 0
        };
        let mut ambiguous = 0;
        let mut links: Vec<[usize; 2]> = Vec::new();
        for face in 0..6 {
            let edges: Vec<usize> = face_edges(face)
                .into_iter()
                .filter(|&e| crossed(e))
                .collect();
            match edges[..] {
                [a, b] => links.push([a, b]),
                [_, _, _, _] => {
                    ambiguous |= 1 << face;
                    for trace in 0..2 {
                        let pair: Vec<usize> = (edges.iter().copied())
                            .filter(|&e| trace_of(corners, joined, face, e) == trace)
                            .collect();
                        links.push([pair[0], pair[1]]);
                    }
                }
                _ => {}
            }
        }
        // Merge the edges of a loop under its lowest edge.
        let mut lowest: [usize; 12] = std::array::from_fn(|e| e);
        for _ in 0..12 {
            for &[a, b] in &links {
                let low = lowest[a].min(lowest[b]);
                (lowest[a], lowest[b]) = (low, low);
            }
        }
        let mut loop_of = [u8::MAX; 12];
        let mut loops = 0;
        for edge in (0..12).filter(|&e| crossed(e)) {
            if lowest[edge] == edge {
                loop_of[edge] = loops;
                loops += 1;
            } else {
                loop_of[edge] = loop_of[lowest[edge]];
            }
        }
        Pattern {
            loops: usize::from(loops),
            loop_of,
            ambiguous,
        }
    }

    /// Whether the face has four crossed edges.
    pub fn is_ambiguous(&self, face: usize) -> bool {
        self.ambiguous >> face & 1 != 0
    }
}

/// Which of an ambiguous face's two traces ends on this crossed edge.
///
/// A trace goes round one of the inside corners, or of the outside ones if the
/// inside is joined. The trace round the corner that is lower along the second
/// axis after the face's own comes first.
pub(super) fn trace_of(corners: u8, joined: u8, face: usize, edge: usize) -> usize {
    let second = (face / 2 + 2) % 3;
    let [a, b] = edge_corners(edge);
    let round = joined >> face & 1 == 0;
    let corner = if (corners >> a & 1 != 0) == round {
        a
    } else {
        b
    };
    corner >> second & 1
}

/// The pattern of a cell by its corners inside the solid and by those of its
/// ambiguous faces whose inside is joined.
pub(super) fn pattern(corners: u8, joined: u8) -> &'static Pattern {
    static PATTERNS: LazyLock<Vec<Vec<Pattern>>> = LazyLock::new(|| {
        (0..=255)
            .map(|corners| {
                let ambiguous = Pattern::new(corners, 0).ambiguous;
                (0..1 << ambiguous.count_ones())
                    .map(|rank| Pattern::new(corners, spread(rank, ambiguous)))
                    .collect()
            })
            .collect()
    });
    let variants = &PATTERNS[usize::from(corners)];
    &variants[rank(joined, variants[0].ambiguous)]
}

/// Number of a subset of `set` among its subsets.
fn rank(subset: u8, set: u8) -> usize {
    bits(set)
        .enumerate()
        .map(|(i, bit)| usize::from(subset >> bit & 1) << i)
        .sum()
}

/// The subset with this number.
fn spread(rank: usize, set: u8) -> u8 {
    bits(set)
        .enumerate()
        .filter(|&(i, _)| rank >> i & 1 != 0)
        .fold(0, |subset, (_, bit)| subset | 1 << bit)
}

fn bits(set: u8) -> impl Iterator<Item = usize> {
    (0..8).filter(move |&bit| set >> bit & 1 != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_know_their_edges() {
        for face in 0..6 {
            for edge in face_edges(face) {
                for corner in edge_corners(edge) {
                    assert_eq!(corner >> (face / 2) & 1, face % 2);
                }
            }
        }
    }

    #[test]
    fn every_crossed_edge_is_in_one_loop() {
        for (corners, joined) in (0..=255u8).flat_map(|c| (0..64).map(move |j| (c, j))) {
            let p = pattern(corners, joined & pattern(corners, 0).ambiguous);
            let used = p.loop_of.iter().filter(|&&l| l != u8::MAX).count();
            let crossed = (0..12)
                .filter(|&e| {
                    let [a, b] = edge_corners(e);
                    (corners >> a ^ corners >> b) & 1 != 0
                })
                .count();
            assert_eq!(used, crossed);
            assert!(p.loops <= 4);
            for l in 0..p.loops {
                let size = p.loop_of.iter().filter(|&&x| usize::from(x) == l).count();
                assert!(size >= 3, "{corners:#b}");
            }
        }
        // One corner, two opposite corners of a face, of the cell, four corners.
        assert_eq!(pattern(0b1, 0).loops, 1);
        assert_eq!(pattern(0b1001, 0).loops, 2);
        assert_eq!(pattern(0b1000_0001, 0).loops, 2);
        assert_eq!(pattern(0b0110_1001, 0).loops, 4);
        assert_eq!(pattern(0b1001_0110, 0).loops, 4);
        // The two corners of a face, joined; all corners parted, then joined.
        assert_eq!(pattern(0b1001, 1 << 4).loops, 1);
        assert_eq!(pattern(0b1001_0110, 63).loops, 4);
    }
}
