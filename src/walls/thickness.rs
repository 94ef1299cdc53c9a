//! Maximal balls seen from the wall: wall thickness before any extraction.

use glam::DVec3;

use crate::field::{Field, Footpoint};
use crate::mesh::{FaceId, angle};

/// The largest ball inside the walls that touches `point` of wall `face`
/// (shrinking ball: Ma, Bae and Choi 2012, with exact triangle distances):
/// its centre and where it touches besides. `None` where nothing faces the
/// point, or the ball's centre lies outside the part.
pub fn maximal_ball(field: &Field, face: FaceId, point: DVec3) -> Option<(DVec3, Footpoint)> {
    let start = Ray {
        from: point,
        direction: -field.normal(face),
        radius: 0.0,
        growth: 1.0,
    };
    start.ball(field, face)
}

/// Balls along a ray, each touching the walls where the first one does.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub from: DVec3,
    /// Of length 1, or zero: no ball then.
    pub direction: DVec3,
    /// At `from`.
    pub radius: f64,
    /// Of the radius along the ray, at most 1.
    pub growth: f64,
}

impl Ray {
    /// The farthest ball inside the walls: its centre and where it touches
    /// anew. `hint` is a face near by. `None` if nothing is met, or the centre
    /// lies outside the part.
    pub fn ball(&self, field: &Field, hint: FaceId) -> Option<(DVec3, Footpoint)> {
        const STEPS: usize = 60;
        if self.direction == DVec3::ZERO {
            return None;
        }
        let (low, high) = field.bounds();
        let size = (high - low).length();
        let mut way = size;
        let mut touch = None;
        for _ in 0..STEPS {
            let centre = self.from + way * self.direction;
            let foot = field.footpoint_near(centre, hint);
            if foot.distance >= (self.radius + self.growth * way) * (1.0 - 1e-9) {
                break;
            }
            way = self.meets(foot.point).filter(|&w| w > 1e-9 * size)?;
            touch = Some(foot);
        }
        let centre = self.from + way * self.direction;
        let touch = touch?;
        field.inside(centre).then_some((centre, touch))
    }

    /// How far along the ball touches a point: where `|from + way direction -
    /// point|` is `radius + growth way`.
    fn meets(&self, point: DVec3) -> Option<f64> {
        let to = point - self.from;
        let a = 1.0 - self.growth * self.growth;
        let b = self.direction.dot(to) + self.growth * self.radius;
        let c = to.length_squared() - self.radius * self.radius;
        let root = b * b - a * c;
        // The lesser root, in the form that stands a zero `a`.
        (b > 0.0 && root >= 0.0).then(|| c / (b + root.sqrt()))
    }
}

/// Points spread over a triangle: its centroid, or for a triangle large
/// against `spacing` a grid, at most `most` points.
pub fn spread(corners: [DVec3; 3], spacing: f64, most: usize) -> impl Iterator<Item = DVec3> {
    let [a, b, c] = corners;
    let area = 0.5 * (b - a).cross(c - a).length();
    let wanted = (area / (spacing * spacing)).clamp(1.0, most as f64);
    // n(n + 1)/2 up and n(n - 1)/2 down triangles: n^2 in all.
    let n = (wanted.sqrt() as usize).max(1);
    (0..n).flat_map(move |i| {
        (0..2 * (n - i) - 1).map(move |k| {
            let (j, down) = (k / 2, k % 2 == 1);
            let shift = if down { 2.0 / 3.0 } else { 1.0 / 3.0 };
            let u = (i as f64 + shift) / n as f64;
            let v = (j as f64 + shift) / n as f64;
            a + u * (b - a) + v * (c - a)
        })
    })
}

/// Wall thickness over the walls, weighted by area: sorted values and weights.
#[derive(Clone, Debug, Default)]
pub struct ThicknessProfile {
    /// Ascending by thickness.
    samples: Vec<ThicknessSample>,
}

/// Wall thickness at a point of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThicknessSample {
    /// Between the two contacts of the largest ball that touches here.
    pub thickness: f64,
    /// Wall area that the point stands for.
    pub area: f64,
    /// The point.
    pub at: DVec3,
    /// Its triangle.
    pub face: FaceId,
}

/// The wall at a point of a face; none where nothing faces it, or where the
/// ball sits in a convex corner (object angle at most 135 degrees).
pub fn thickness_at(field: &Field, face: FaceId, point: DVec3) -> Option<f64> {
    let (centre, touch) = maximal_ball(field, face, point)?;
    let (u, v) = (point - centre, touch.point - centre);
    let object_angle = angle(u, v).to_degrees();
    (object_angle > super::MAX_FIN_ANGLE).then(|| point.distance(touch.point))
}

impl ThicknessProfile {
    /// Measures a part at some `count` points of its walls. Balls in convex
    /// corners (object angle at most 135 degrees) are left out.
    pub fn measure(field: &Field, count: usize) -> ThicknessProfile {
        let walls: Vec<FaceId> = (0..field.face_count() as u32)
            .map(FaceId)
            .filter(|&f| !field.is_coping(f))
            .collect();
        let area = |f: FaceId| {
            let [a, b, c] = field.corners(f);
            0.5 * (b - a).cross(c - a).length()
        };
        let total: f64 = walls.iter().map(|&f| area(f)).sum();
        let spacing = (total / count.max(1) as f64).sqrt();
        // Of many small triangles every k-th will do.
        let stride = (walls.len() / count.max(1)).max(1);
        let mut samples = Vec::new();
        for &face in walls.iter().step_by(stride) {
            let points: Vec<DVec3> = spread(field.corners(face), spacing, 64).collect();
            let share = area(face) / points.len() as f64;
            for p in points {
                if let Some(thickness) = thickness_at(field, face, p) {
                    samples.push(ThicknessSample {
                        thickness,
                        area: share,
                        at: p,
                        face,
                    });
                }
            }
        }
        let order = |s: &ThicknessSample| (s.face, s.at.to_array().map(f64::to_bits));
        samples.sort_by(|a, b| {
            let by_thickness = a.thickness.total_cmp(&b.thickness);
            by_thickness.then_with(|| order(a).cmp(&order(b)))
        });
        ThicknessProfile { samples }
    }

    /// The thickness below which `percent` of the wall area lies.
    pub fn percentile(&self, percent: f64) -> Option<f64> {
        let total: f64 = self.samples.iter().map(|s| s.area).sum();
        let mut sum = 0.0;
        for sample in &self.samples {
            sum += sample.area;
            if sum >= 0.01 * percent * total {
                return Some(sample.thickness);
            }
        }
        self.samples.last().map(|s| s.thickness)
    }

    /// Ascending by thickness.
    pub fn samples(&self) -> &[ThicknessSample] {
        &self.samples
    }

    /// Where the wall is thinnest.
    pub fn thinnest(&self) -> Option<&ThicknessSample> {
        self.samples.first()
    }

    /// Share of the measured wall area that is thinner than a length.
    pub fn share_below(&self, length: f64) -> f64 {
        let area = |samples: &[ThicknessSample]| samples.iter().map(|s| s.area).sum::<f64>();
        let thin = self.samples.partition_point(|s| s.thickness < length);
        let whole = area(&self.samples);
        if whole > 0.0 {
            area(&self.samples[..thin]) / whole
        } else {
            0.0
        }
    }
}
