//! Where no ball of the mid-surface reaches: pruned convex corners.

use glam::DVec3;

use crate::field::{Field, Footpoint};
use crate::mesh::{FaceId, Part, TriMesh};
use crate::walls::thickness::Ray;
use crate::walls::{Walls, object_angle};

/// Object angles below this, degrees, are bends of a round made of facets: a
/// ball misses such an edge by less than 0.01 of its radius, and goes on along
/// the bisector.
const FACETS: f64 = 15.0;

/// Facets of a round that a ball may come to rest on before it stops for good.
const MOST_FACETS: usize = 8;

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
/// of that reaches the point. A point of a coping face goes with the ball
/// that grows through it from the nearest wall. Only the part and the
/// mid-surface are asked, never the solid.
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
        let inward = -field.normal(face);
        let (face, point, direction) = if self.part.coping()[face.index()] {
            let within = p + step * inward;
            let foot = field.footpoint(within);
            (
                foot.face,
                foot.point,
                (within - foot.point).normalize_or_zero(),
            )
        } else {
            (face, p, inward)
        };
        let Some((centre, [own, touch])) = self.ball(face, point, direction) else {
            return false;
        };
        !self.walls.separate(centre, &own, &touch)
            && self.surface.footpoint(centre).distance > ON_SHEET * own.distance
    }

    /// The greatest ball that touches a wall's point from a direction, and two
    /// of its footpoints that see each other under [`FACETS`] or more.
    fn ball(
        &self,
        face: FaceId,
        point: DVec3,
        direction: DVec3,
    ) -> Option<(DVec3, [Footpoint; 2])> {
        let field = self.walls.field();
        let mut ray = Ray {
            from: point,
            direction,
            radius: 0.0,
            growth: 1.0,
        };
        let mut face = face;
        for _ in 0..MOST_FACETS {
            let (centre, touch) = ray.ball(field, face)?;
            // The ball leaves the place where it began, and slides over facets.
            let own = field.footpoint_on(centre, face);
            let angle = object_angle(centre, &own, &touch);
            if angle >= FACETS {
                return Some((centre, [own, touch]));
            }
            // On, touching both.
            let away = [own, touch].map(|foot| (centre - foot.point).normalize_or_zero());
            let direction = (away[0] + away[1]).normalize_or_zero();
            ray = Ray {
                from: centre,
                direction,
                radius: own.distance,
                growth: direction.dot(away[0]),
            };
            face = touch.face;
        }
        None
    }
}
