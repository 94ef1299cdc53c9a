//! Corners of the part where two walls touch in a point, coping between them
//! on both sides: a flush tab, a web that passes the edge of its plate. The
//! mid-surface between the two walls runs into such a corner with no thickness
//! left, and its border on from one coping to the other.

use glam::DVec3;
use smallvec::SmallVec;

use super::Walls;
use crate::mesh::FaceId;

/// Where a border that ran into a corner goes on.
#[derive(Clone, Copy, Debug)]
pub struct Onward {
    /// The corner.
    pub corner: DVec3,
    /// The coping triangle over which the border leaves it.
    pub coping: FaceId,
    /// A point of the border there, a given way from the corner.
    pub at: DVec3,
    /// The two walls that tie at that point.
    pub walls: [FaceId; 2],
}

/// Triangles at a corner, each with the number of the corner in it.
type Run = SmallVec<[(FaceId, usize); 8]>;

impl Walls<'_> {
    /// The way on from corner `k` of a coping triangle, where the triangles round
    /// that corner are coping, wall, coping, wall; `way` is how far from the corner.
    pub fn onward(&self, coping: FaceId, k: usize, way: f64) -> Option<Onward> {
        let corner = self.field.corners(coping)[k];
        let [_, one, other, two] = self.runs(coping, k)?;
        let off = |run: &Run, p: DVec3| {
            (run.iter())
                .map(|t| (self.field.footpoint_on(p, t.0).distance, t.0))
                .min_by(|a, b| a.0.total_cmp(&b.0))
        };
        for &(face, k) in &other {
            let c = self.field.corners(face);
            let side = |j: usize| (c[(k + j) % 3] - corner).normalize_or_zero();
            let (from, to) = (side(1), side(2));
            let place = |s: f64| corner + way * from.lerp(to, s).normalize_or_zero();
            let lead = |s: f64| Some(off(&one, place(s))?.0 - off(&two, place(s))?.0);
            let (mut low, mut high) = (0.0, 1.0);
            if lead(low)? > 0.0 || lead(high)? <= 0.0 {
                continue;
            }
            // To the last bit of a double.
            for _ in 0..f64::MANTISSA_DIGITS {
                let middle = 0.5 * (low + high);
                if lead(middle)? > 0.0 {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            let at = place(low);
            return Some(Onward {
                corner,
                coping: face,
                at,
                walls: [off(&one, at)?.1, off(&two, at)?.1],
            });
        }
        None
    }

    /// The triangles round a corner, counter-clockwise, in runs of coping and
    /// wall, from the run of a coping triangle on; `None` unless they are four.
    fn runs(&self, coping: FaceId, k: usize) -> Option<[Run; 4]> {
        let vertex = self.indices[coping.index()][k];
        let mut ring = Run::new();
        let (mut face, mut corner) = (coping, k);
        loop {
            ring.push((face, corner));
            // Over the edge that ends in the corner.
            face = self.neighbours[face.index()][(corner + 2) % 3]?;
            corner = (self.indices[face.index()].iter()).position(|&v| v == vertex)?;
            if face == coping {
                break;
            }
            // Triangles with a repeated corner may lead round and round.
            if ring.len() > self.neighbours.len() {
                return None;
            }
        }
        let is_coping = |t: &(FaceId, usize)| !self.is_way(t.0);
        // The run of the first triangle may have begun before it.
        let first = (ring.iter()).rposition(|t| !is_coping(t))? + 1;
        let before = ring.len() - first;
        ring.rotate_right(before);
        let runs: SmallVec<[Run; 4]> = (ring.chunk_by(|a, b| is_coping(a) == is_coping(b)))
            .map(Run::from_slice)
            .collect();
        runs.into_inner().ok()
    }
}
