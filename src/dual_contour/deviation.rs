//! How far a mesh is from the surface that it stands for.

use serde::Serialize;

/// Distances of points of a mesh from the true surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Deviation {
    /// Mean, part units.
    pub mean: f64,
    /// Greatest, part units.
    pub max: f64,
}

impl Deviation {
    /// The figures of unsigned distances; zero without any.
    pub fn of(distances: impl IntoIterator<Item = f64>) -> Deviation {
        let (mut count, mut sum, mut max) = (0_usize, 0.0, 0.0_f64);
        for distance in distances {
            count += 1;
            sum += distance;
            max = max.max(distance);
        }
        Deviation {
            mean: sum / count.max(1) as f64,
            max,
        }
    }
}
