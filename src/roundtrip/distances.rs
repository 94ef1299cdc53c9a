//! Distances over a surface.

use serde::Serialize;

/// Distances from points of one surface to another, part units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Distances {
    /// Mean over the area.
    pub mean: f64,
    /// 95 of 100 are at most this.
    pub p95: f64,
    /// 99 of 100.
    pub p99: f64,
    /// Greatest, vertices included.
    pub max: f64,
}

impl Distances {
    /// Of samples by area, ascending.
    pub(super) fn of(sorted: &[f64], max: f64) -> Distances {
        let n = sorted.len();
        let rank = |percent: usize| {
            let value = sorted.get((n * percent / 100).min(n.max(1) - 1));
            value.copied().unwrap_or(0.0)
        };
        Distances {
            mean: sorted.iter().sum::<f64>() / n.max(1) as f64,
            p95: rank(95),
            p99: rank(99),
            max,
        }
    }
}
