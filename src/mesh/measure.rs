//! Volume, area and boxes of triangle meshes.

use glam::DVec3;

use super::{FaceId, TriMesh};

/// Whether a triangle is lower than `ratio` times its longest side: two corners
/// fall together, or all lie on one line, or nearly so.
pub fn is_thin([a, b, c]: [DVec3; 3], ratio: f64) -> bool {
    let (u, v) = (b - a, c - a);
    let longest = u.length_squared().max(v.length_squared());
    let longest = longest.max(b.distance_squared(c));
    u.cross(v).length() <= ratio * longest
}

/// Angle between two vectors, radians: exact near 0 and pi too, and 0 if one has
/// no length.
pub fn angle(u: DVec3, v: DVec3) -> f64 {
    u.cross(v).length().atan2(u.dot(v))
}

/// Smallest angle of a triangle, degrees; 0 where corners coincide.
pub fn smallest_angle(p: [DVec3; 3]) -> f64 {
    let at = |k: usize| angle(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]).to_degrees();
    at(0).min(at(1)).min(at(2))
}

/// Axis-parallel box in part units.
///
/// An empty box has `min` above `max`; [`Bounds::is_empty`] tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub min: DVec3,
    /// Highest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Bounds = Bounds {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// Smallest box around points.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        points
            .into_iter()
            .fold(Bounds::EMPTY, |bounds, point| bounds.with(point))
    }

    /// The box grown to hold `point`.
    pub fn with(self, point: DVec3) -> Bounds {
        Bounds {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// The box with all faces moved outwards; an empty box stays empty.
    pub fn grown(self, reach: f64) -> Bounds {
        Bounds {
            min: self.min - reach,
            max: self.max + reach,
        }
    }

    /// Whether no point was ever added.
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// Whether the point lies in the box or on its faces.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether two boxes have a point in common.
    pub fn meets(&self, other: &Bounds) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Edge lengths; zero for an empty box.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            self.max - self.min
        }
    }

    /// Length of the space diagonal; zero for an empty box.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }

    /// Middle of the box; the origin for an empty box.
    pub fn center(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (self.min + self.max)
        }
    }
}

impl TriMesh {
    /// Corner positions of a triangle.
    ///
    /// # Panics
    ///
    /// If the triangle or one of its indices is out of range.
    pub fn corners(&self, face: FaceId) -> [DVec3; 3] {
        self.triangles[face.index()].map(|v| self.positions[v as usize])
    }

    /// Faces in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.triangles.len() as u32).map(FaceId)
    }

    /// Twice the area times the unit normal: the cross product of two edges.
    pub fn area_vector(&self, face: FaceId) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    /// Area of one triangle.
    pub fn triangle_area(&self, face: FaceId) -> f64 {
        0.5 * self.area_vector(face).length()
    }

    /// Area of all triangles.
    pub fn area(&self) -> f64 {
        self.faces().map(|face| self.triangle_area(face)).sum()
    }

    /// Signed volume by the divergence theorem, summed about the centre of
    /// the box so that a part far from the origin keeps its digits.
    ///
    /// Positive when closed and outward oriented. For an open mesh it is the
    /// volume of the mesh closed by cones from the centre.
    pub fn volume(&self) -> f64 {
        let center = self.bounds().center();
        self.volume_about(center, self.faces())
    }

    /// Signed volume of some of the faces with respect to `origin`.
    pub(super) fn volume_about(
        &self,
        origin: DVec3,
        faces: impl IntoIterator<Item = FaceId>,
    ) -> f64 {
        let six_fold: f64 = faces
            .into_iter()
            .map(|face| {
                let [a, b, c] = self.corners(face).map(|p| p - origin);
                a.dot(b.cross(c))
            })
            .sum();
        six_fold / 6.0
    }

    /// Box around the vertices that triangles use.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(
            self.triangles
                .iter()
                .flatten()
                .map(|&v| self.positions[v as usize]),
        )
    }
}
