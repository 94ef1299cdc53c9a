//! Numbers that the vertices of a result may have.

use glam::DVec3;
use serde::Serialize;

/// Numbers that the vertices may have.
///
/// Contouring decides with the numbers that are written. A file format of
/// single precision rounds the others, which can push a thin triangle through
/// its neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// Any `f64`.
    #[default]
    Double,
    /// Those that `f32` holds too: for binary STL.
    Single,
}

impl Precision {
    /// The nearest number allowed.
    pub fn round(self, x: f64) -> f64 {
        match self {
            Precision::Double => x,
            Precision::Single => f64::from(x as f32),
        }
    }

    /// The nearest point allowed.
    pub fn round_point(self, p: DVec3) -> DVec3 {
        DVec3::from_array(p.to_array().map(|x| self.round(x)))
    }

    /// The next greater number allowed.
    pub(crate) fn above(self, x: f64) -> f64 {
        match self {
            Precision::Double => x.next_up(),
            Precision::Single => f64::from((x as f32).next_up()),
        }
    }

    /// The next smaller number allowed.
    pub(crate) fn below(self, x: f64) -> f64 {
        match self {
            Precision::Double => x.next_down(),
            Precision::Single => f64::from((x as f32).next_down()),
        }
    }
}
