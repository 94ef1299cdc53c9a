//! The offset of a part as a function: signed distance less the offset.

use std::cell::RefCell;

use glam::DVec3;

use crate::dual_contour::{Bracket, Crossing, Implicit, Sample, hybrid};
use crate::field::Field;
use crate::mesh::{Bounds, FaceId};

/// Points within a distance of a part (`distance > 0`), or inside it and
/// farther than that from its surface (`distance < 0`). Equation (1) of the
/// paper.
pub(super) struct OffsetSolid<'a> {
    field: &'a Field,
    /// Positive outwards.
    distance: f64,
    /// Distances that differ by less are the same: epsilon of equation (8).
    tolerance: f64,
}

impl OffsetSolid<'_> {
    pub fn new(field: &Field, distance: f64) -> OffsetSolid<'_> {
        let (low, high) = field.bounds();
        OffsetSolid {
            field,
            distance,
            tolerance: 1e-12 * ((high - low).length() + distance.abs()),
        }
    }

    /// A box around the surface.
    pub fn bounds(&self) -> Bounds {
        let (low, high) = self.field.bounds();
        Bounds {
            min: low - self.distance,
            max: high + self.distance,
        }
    }

    /// A triangle that holds the closest points of both ends: the necessary
    /// condition of Remark 4 for one triangle to hold those of all points
    /// between.
    ///
    /// The closest point may be reported for any of the triangles that share
    /// its edge or vertex. So all that share the first one's are tried, and one
    /// holds the second one's if its own distance there is the least one. That
    /// covers every combination of face, edge and vertex.
    fn common(&self, ends: [(DVec3, u32); 2]) -> Option<u32> {
        thread_local! {
            static SHARING: RefCell<Vec<FaceId>> = const { RefCell::new(Vec::new()) };
        }
        let [(p, first), (q, second)] = ends;
        if first == second {
            return Some(first);
        }
        let least = self.field.footpoint_on(q, FaceId(second)).distance;
        SHARING.with_borrow_mut(|sharing| {
            self.field.sharing(p, FaceId(first), sharing);
            sharing
                .iter()
                .find(|&&face| self.field.footpoint_on(q, face).distance - least <= self.tolerance)
                .map(|face| face.0)
        })
    }
}

impl Implicit for OffsetSolid<'_> {
    fn sample(&self, p: DVec3, hint: u32) -> Sample {
        let reach = self.distance.abs();
        let (foot, inside) = self.field.sided_footpoint_near(p, FaceId(hint), reach);
        let side = match inside {
            Some(true) => -1.0,
            Some(false) => 1.0,
            // Which side of the part is not known here, and does not matter:
            // the point is on the near side of the offset either way.
            None => self.distance.signum(),
        };
        Sample {
            value: side * foot.distance - self.distance,
            gradient: side * direction(self.field, p, foot.point, foot.face),
            unsigned: (foot.distance - reach).abs(),
            element: foot.face.0,
        }
    }

    fn element(&self, p: DVec3, element: u32) -> (f64, DVec3) {
        let foot = self.field.footpoint_on(p, FaceId(element));
        let side = self.distance.signum();
        (
            side * foot.distance - self.distance,
            side * direction(self.field, p, foot.point, foot.face),
        )
    }

    /// If one triangle may hold all closest points (Remark 4), its closed form
    /// gives the crossing. If none does, the nearer end's own triangle does:
    /// the distance is the least of all triangles', so the surface can only be
    /// farther on, and the query there tells the next triangle.
    fn crossing(&self, ends: [DVec3; 2], samples: [Sample; 2]) -> Crossing {
        let reach = self.distance.abs();
        let guess = |bracket: &Bracket| {
            let [from, to] = bracket.ends;
            let [near, far] = bracket.samples.map(|s| s.element);
            let closed = |element: u32| self.field.leaves(FaceId(element), from, to, reach);
            self.common([(from, near), (to, far)])
                .and_then(closed)
                .or_else(|| (!bracket.shaky).then(|| closed(near)).flatten())
        };
        let outward = self.distance.signum();
        hybrid(self, ends, samples, outward, self.tolerance, guess).crossing
    }
}

/// Unit direction from the part to a point; on the part itself that of the
/// face.
fn direction(field: &Field, p: DVec3, foot: DVec3, face: FaceId) -> DVec3 {
    (p - foot)
        .try_normalize()
        .unwrap_or_else(|| field.normal(face))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriMesh;

    #[test]
    fn at_a_sliver_values_are_lower_bounds() {
        // A tetrahedron; on one side an edge has a vertex in its middle, and a
        // triangle without height closes the gap.
        let positions = vec![
            DVec3::ZERO,
            DVec3::new(4.0, 0.0, 0.0),
            DVec3::new(0.0, 4.0, 0.0),
            DVec3::new(0.0, 0.0, 4.0),
            DVec3::new(2.0, 1e-17, 0.0),
        ];
        let clean = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let dirty = vec![
            [0, 2, 1],
            [0, 4, 3],
            [4, 1, 3],
            [0, 1, 4],
            [1, 2, 3],
            [2, 0, 3],
        ];
        // Turned inside out, so that the edge is a reflex one: points inside
        // are nearest to the sliver.
        let [clean, dirty] = [clean, dirty].map(|triangles: Vec<[u32; 3]>| {
            let positions = positions.clone();
            let triangles = triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect();
            Field::of_mesh(&TriMesh {
                positions,
                triangles,
            })
        });
        for distance in [0.5, -0.5] {
            let [clean, dirty] = [&clean, &dirty].map(|field| OffsetSolid::new(field, distance));
            for i in 0..4000 {
                let r = |k: i32| f64::from((i * 7919 + k * 104_729 + i * i * k) % 1009) / 1009.0;
                let p = DVec3::new(4.0 * r(1), 0.6 * r(2) - 0.3, 0.6 * r(3) - 0.3);
                let [a, b] = [&clean, &dirty].map(|solid| solid.sample(p, 0));
                // Within the distance the side may be left open: the value is
                // then a lower bound, which the band may rely on.
                assert_eq!(a.value < 0.0, b.value < 0.0, "{p}");
                let free = p.y.hypot(p.z) < distance.abs();
                let bound = b.value.abs() <= a.value.abs() + 1e-9;
                assert!(
                    bound && (free || b.value == a.value),
                    "{p}: {} {}",
                    a.value,
                    b.value
                );
            }
        }
    }
}
