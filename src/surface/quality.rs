//! Shape of the triangles.

use serde::Serialize;

use super::MidSurface;
use crate::mesh::smallest_angle;

/// Smallest angles of the triangles, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Quality {
    /// Smallest of all.
    pub least: f64,
    /// A hundredth of the triangles have a smaller one.
    pub percentile_1: f64,
    /// A twentieth of the triangles have a smaller one.
    pub percentile_5: f64,
    /// Half of the triangles have a smaller one.
    pub median: f64,
    /// Share of triangles with an angle below 5 degrees.
    pub share_below_5: f64,
}

impl Quality {
    /// Of the triangles of a surface.
    pub fn of(surface: &MidSurface) -> Quality {
        let mut all: Vec<f64> = (surface.triangles().iter())
            .map(|t| smallest_angle(t.corners.map(|v| surface.vertices()[v as usize].position)))
            .collect();
        all.sort_unstable_by(f64::total_cmp);
        let below = all.partition_point(|&a| a < 5.0);
        let at = |share: f64| all.get((share * all.len() as f64) as usize).copied();
        Quality {
            least: at(0.0).unwrap_or(0.0),
            percentile_1: at(0.01).unwrap_or(0.0),
            percentile_5: at(0.05).unwrap_or(0.0),
            median: at(0.5).unwrap_or(0.0),
            share_below_5: below as f64 / all.len().max(1) as f64,
        }
    }
}
