//! Where a segment comes to a given distance from one triangle.
//!
//! The space around a triangle falls into seven regions by what holds the
//! closest point: its face, an edge or a vertex (Definition 4 of Liu and Wang,
//! "Fast Intersection-free Offset Surface Generation from Freeform Models with
//! Triangular Meshes"). A segment is cut where it passes from region to region;
//! in each the distance has a closed form (Remarks 5 to 7 there).

use glam::DVec3;
use smallvec::SmallVec;

use super::triangle::{Feature, Triangle};

impl Triangle {
    /// The fraction of the way from `from` to `to` at which the distance to
    /// the triangle grows to `distance`. None unless it is at most that at the
    /// start and more at the end; the distance to a convex set is convex along
    /// a line, so there is one such place.
    pub fn leaves(&self, from: DVec3, to: DVec3, distance: f64) -> Option<f64> {
        let square = distance * distance;
        let far = |t: f64| self.closest(from.lerp(to, t)).square > square;
        if far(0.0) || !far(1.0) {
            return None;
        }
        let mut start = 0.0;
        for end in self.cuts(from, to) {
            if end == 1.0 || far(end) {
                let way = self.leaves_in_region(from, to, start, end, distance);
                return Some(way.clamp(start, end));
            }
            start = end;
        }
        None
    }

    /// Where the segment passes from region to region, ascending, and its end.
    fn cuts(&self, from: DVec3, to: DVec3) -> SmallVec<[f64; 10]> {
        let c = self.corners;
        let normal = (c[1] - c[0]).cross(c[2] - c[0]);
        let step = to - from;
        let mut cuts = SmallVec::new();
        let mut cut = |plane: DVec3, through: DVec3| {
            let t = plane.dot(through - from) / plane.dot(step);
            // Not so for a segment along the plane, whose fraction is no
            // number.
            if t > 0.0 && t < 1.0 {
                cuts.push(t);
            }
        };
        for i in 0..3 {
            let (a, b) = (c[i], c[(i + 1) % 3]);
            cut(normal.cross(b - a), a);
            cut(b - a, a);
            cut(b - a, b);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.push(1.0);
        cuts
    }

    /// The same where the segment stays in one region from `start` to `end`.
    fn leaves_in_region(&self, from: DVec3, to: DVec3, start: f64, end: f64, distance: f64) -> f64 {
        let c = self.corners;
        let step = to - from;
        let vertex = |corner: u8| c[usize::from(corner)];
        let (offset, rate) = match self.closest(from.lerp(to, 0.5 * (start + end))).feature {
            // Remark 5: the height above the face's plane is linear.
            Feature::Face => {
                let normal = self.normal();
                let height = normal.dot(from - c[0]);
                let rise = normal.dot(step);
                let target = distance.copysign(height + end * rise);
                return (target - height) / rise;
            }
            // Remark 6: the distance from the edge's line.
            Feature::Edge(edge) => {
                let along = (vertex((edge + 1) % 3) - vertex(edge)).normalize();
                let across = |v: DVec3| v - along * along.dot(v);
                (across(from - vertex(edge)), across(step))
            }
            // Remark 7: the distance from the vertex.
            Feature::Corner(corner) => (from - vertex(corner), step),
        };
        greater_root(
            rate.length_squared(),
            offset.dot(rate),
            offset.length_squared() - distance * distance,
        )
    }
}

/// Greater root of `a t^2 + 2 b t + c`, without cancellation.
fn greater_root(a: f64, b: f64, c: f64) -> f64 {
    let root = (b * b - a * c).max(0.0).sqrt();
    if b > 0.0 {
        -c / (b + root)
    } else {
        (root - b) / a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::FaceId;

    #[test]
    fn distance_at_the_place_is_the_one_asked_for() {
        let triangle = Triangle::new(
            [
                DVec3::ZERO,
                DVec3::new(2.0, 0.3, 0.1),
                DVec3::new(-0.5, 1.0, 0.4),
            ],
            FaceId(0),
        );
        let mut found = 0;
        for i in 0..4000 {
            let r = |k: i32| f64::from((i * 7919 + k * 104_729 + i * i * k) % 1009) / 168.0 - 3.0;
            let from = DVec3::new(r(1), r(2), r(3));
            let to = from + 0.5 * DVec3::new(r(4), r(5), r(6));
            let distance = 0.2 + 0.3 * f64::from(i % 5);
            let d = |t: f64| triangle.closest(from.lerp(to, t)).square.sqrt();
            match triangle.leaves(from, to, distance) {
                Some(t) => {
                    found += 1;
                    assert!((d(t) - distance).abs() < 1e-12, "{i}: {} {distance}", d(t));
                }
                None => assert!(d(0.0) > distance || d(1.0) <= distance),
            }
        }
        assert!(found > 100, "{found}");
    }
}
