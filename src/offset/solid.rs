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
        let side = if self.field.is_closed_manifold() || foot.distance >= reach {
            if inside { -1.0 } else { 1.0 }
        } else {
            // Which side of the part is not known here, and does not matter:
            // the point is on the near side of the offset either way.
            self.distance.signum()
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
