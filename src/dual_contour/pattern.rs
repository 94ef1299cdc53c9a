//! The 256 ways in which a surface may pass between the corners of a cell.
//!
//! Numbers: corner `x + 2 y + 4 z`. Edge `4 axis + u + 2 v`, where `u` and `v`
//! are the corner's bits along the two axes that follow `axis` (x, y, z, x...).
//! Face `2 axis + side`.
//!
//! On each face the surface leaves a *trace* from crossed edge to crossed edge.
//! A face with four crossed edges is *ambiguous*; both cells that share it part
//! its two inside corners from each other. The traces of a cell join to closed
//! *loops*, each of which gets a vertex of its own.

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
    fn new(corners: usize) -> Pattern {
        let inside = |corner: usize| corners >> corner & 1 != 0;
        let crossed = |edge: usize| {
            let [a, b] = edge_corners(edge);
            inside(a) != inside(b)
        };
        let mut ambiguous = 0;
        let mut links: Vec<[usize; 2]> = Vec::new();
        for face in 0..6 {
            let edges: Vec<usize> = face_edges(face).into_iter().filter(|&e| crossed(e)).collect();
            match edges[..] {
                [a, b] => links.push([a, b]),
                [_, _, _, _] => {
                    ambiguous |= 1 << face;
                    for trace in 0..2 {
                        let pair: Vec<usize> = (edges.iter().copied())
                            .filter(|&e| trace_of(corners, face, e) == trace)
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
/// The trace around the inside corner that is lower along the second axis
/// after the face's own comes first.
pub(super) fn trace_of(corners: usize, face: usize, edge: usize) -> usize {
    let second = (face / 2 + 2) % 3;
    let [a, b] = edge_corners(edge);
    let corner = if corners >> a & 1 != 0 { a } else { b };
    corner >> second & 1
}

/// The pattern of a cell whose corners inside the solid are the bits set.
pub(super) fn pattern(corners: u8) -> &'static Pattern {
    static PATTERNS: LazyLock<Vec<Pattern>> =
        LazyLock::new(|| (0..256).map(Pattern::new).collect());
    &PATTERNS[usize::from(corners)]
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
        for corners in 0..=255u8 {
            let p = pattern(corners);
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
        assert_eq!(pattern(0b1).loops, 1);
        assert_eq!(pattern(0b1001).loops, 2);
        assert_eq!(pattern(0b1000_0001).loops, 2);
        assert_eq!(pattern(0b0110_1001).loops, 4);
        assert_eq!(pattern(0b1001_0110).loops, 4);
    }
}
