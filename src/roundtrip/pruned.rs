//! Where no ball of the mid-surface reaches: pruned convex corners.

use glam::DVec3;

use crate::field::thickness::maximal_ball;
use crate::field::walls::{Walls, object_angle};
use crate::field::{Field, Footpoint};
use crate::mesh::{FaceId, Part, TriMesh};

/// Object angles below this, degrees, are bends of a round made of facets: a
/// ball misses such an edge by less than 0.01 of its radius.
const FACETS: f64 = 15.0;

/// Centres nearer to the mid-surface than this, over the ball's radius, are on
/// it.
const ON_SHEET: f64 = 0.05;

/// How far a point is moved off the edges of its triangle, and one of a coping
/// face into the part to ask for the wall next to it, over the thickness.
const OFF_EDGE: f64 = 0.02;

/// Tells points of the part that were lost with a fin.
///
/// At a point of a wall the greatest ball inside the walls that touches it
/// there is looked at. If it sits in a convex edge of one wall, that is, if
/// its two footpoints are not separate in the sense of the extraction, its
/// centre is on a fin; and if the centre is off the mid-surface too, no ball
/// of that reaches the point. A point of a coping face goes with the nearest
/// wall. Only the part and the mid-surface are asked, never the solid.
pub(super) struct Pruned<'a> {
    part: &'a Part,
    walls: &'a Walls<'a>,
    surface: Field,
    thickness: f64,
}

impl<'a> Pruned<'a> {
    pub fn new(
        part: &'a Part,
        walls: &'a Walls<'a>,
        surface: &TriMesh,
        thickness: f64,
    ) -> Pruned<'a> {
        Pruned {
            part,
            walls,
            surface: Field::of_mesh(surface),
            thickness,
        }
    }

    /// Whether a point on a triangle of the part is one.
    pub fn is_pruned(&self, face: FaceId, p: DVec3) -> bool {
        let field = self.walls.field();
        let step = OFF_EDGE * self.thickness;
        let [a, b, c] = field.corners(face);
        let p = p.move_towards((a + b + c) / 3.0, step);
        let (face, point) = if self.part.coping()[face.index()] {
            let foot = field.footpoint(p - step * field.normal(face));
            (foot.face, foot.point)
        } else {
            (face, p)
        };
        let Some((centre, touch)) = maximal_ball(field, face, point) else {
            return false;
        };
        let own = Footpoint {
            face,
            point,
            distance: centre.distance(point),
        };
        object_angle(centre, &own, &touch) >= FACETS
            && !self.walls.separate(centre, &own, &touch)
            && self.surface.footpoint(centre).distance > ON_SHEET * own.distance
    }
}
