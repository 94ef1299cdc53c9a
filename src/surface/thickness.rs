//! Thickness over a mid-surface, weighted by area.

use crate::surface::MidSurface;
use serde::Serialize;

/// Figures of the thickness, part units: least, percentiles of the area,
/// greatest, and mean.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Thickness {
    /// Least.
    pub min: f64,
    /// 5 % of the area is thinner.
    pub p5: f64,
    /// 25 % of the area is thinner.
    pub p25: f64,
    /// 50 % of the area is thinner.
    pub p50: f64,
    /// 75 % of the area is thinner.
    pub p75: f64,
    /// 95 % of the area is thinner.
    pub p95: f64,
    /// Greatest.
    pub max: f64,
    /// Mean over the area.
    pub mean: f64,
}

impl Thickness {
    /// Every vertex counts with a third of the area of its triangles; none
    /// without triangles.
    pub fn of(surface: &MidSurface) -> Option<Thickness> {
        let mut weights = vec![0.0; surface.vertices().len()];
        for triangle in surface.triangles() {
            let corners = triangle.corners.map(|v| v as usize);
            let [a, b, c] = corners.map(|v| surface.vertices()[v].position);
            let area = 0.5 * (b - a).cross(c - a).length();
            for corner in corners {
                weights[corner] += area / 3.0;
            }
        }
        let vertices = surface.vertices().iter().zip(weights);
        let mut samples: Vec<(f64, f64)> = vertices
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(vertex, weight)| (vertex.ball.thickness, weight))
            .collect();
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (first, last) = (samples.first()?.0, samples.last()?.0);
        let total: f64 = samples.iter().map(|sample| sample.1).sum();
        let percentile = |percent: f64| {
            let mut sum = 0.0;
            let reached = samples.iter().find(|sample| {
                sum += sample.1;
                sum >= 0.01 * percent * total
            });
            reached.map_or(last, |sample| sample.0)
        };
        Some(Thickness {
            min: first,
            p5: percentile(5.0),
            p25: percentile(25.0),
            p50: percentile(50.0),
            p75: percentile(75.0),
            p95: percentile(95.0),
            max: last,
            mean: samples.iter().map(|(t, weight)| t * weight).sum::<f64>() / total,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::surface::{Ball, MidTriangle, MidVertex, SurfaceParts, VertexKind};
    use glam::DVec3;

    use super::*;

    #[test]
    fn area_weighs() {
        // A triangle of area 1 and one of area 3, of thickness 1 and 5.
        let points = [
            [0.0, 0.0],
            [2.0, 0.0],
            [0.0, 1.0],
            [5.0, 0.0],
            [8.0, 0.0],
            [5.0, 2.0],
        ];
        let vertices = points.iter().enumerate().map(|(n, [x, y])| MidVertex {
            position: DVec3::new(*x, *y, 0.0),
            kind: VertexKind::Sheet,
            ball: Ball {
                thickness: if n < 3 { 1.0 } else { 5.0 },
                ..Ball::default()
            },
        });
        let triangle = |corners| MidTriangle { corners, sheet: 0 };
        let surface = MidSurface::new(SurfaceParts {
            vertices: vertices.collect(),
            triangles: vec![triangle([0, 1, 2]), triangle([3, 4, 5])],
            ..SurfaceParts::default()
        })
        .unwrap();
        let t = Thickness::of(&surface).unwrap();
        assert_eq!(
            (t.min, t.p5, t.p50, t.p95, t.max),
            (1.0, 1.0, 5.0, 5.0, 5.0)
        );
        assert!((t.mean - 4.0).abs() < 1e-12);
        assert!(Thickness::of(&MidSurface::default()).is_none());
    }
}
