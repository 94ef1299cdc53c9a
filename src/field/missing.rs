//! What of a surface, known by points of it, a mesh does not have.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::Field;
use crate::mesh::TriMesh;
use crate::settings::quote::figure;
use crate::settings::warning::Warning;

/// One of so many points may be farther off than a cell: where the true surface
/// folds, its points bound slivers that no solid holds.
const TOLERATED: usize = 500;

/// One of so many may be farther off than a quarter of a cell: vertices lie on
/// the solid, and triangles between them cut its corners by less.
const TOLERATED_NEAR: usize = 20;

/// Triangles that are searched at a time: a tree over a whole solid would take
/// more memory than the solid, and few points are looked for.
const AT_A_TIME: usize = 1 << 15;

/// Points of the true surface that a solid meshed with cells does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Missing {
    /// Points looked for, evenly over the true surface.
    pub samples: usize,
    /// Those that are farther than a cell from the solid's surface; where many are
    /// farther than a quarter of a cell, those.
    pub lost: usize,
    /// Greatest distance of one, part units.
    pub max: f64,
    /// Mean distance, part units.
    pub mean: f64,
}

impl Missing {
    /// Looks for points of the true surface on a solid with cells of this length.
    pub(crate) fn of(points: &[DVec3], solid: &TriMesh, cell: f64) -> Missing {
        let distances = distances(points, solid);
        let farther = |than: f64| distances.iter().filter(|&&d| d > than).count();
        let (far, near) = (farther(cell), farther(0.25 * cell));
        let max = distances.iter().copied().fold(0.0, f64::max);
        Missing {
            samples: points.len(),
            lost: if near > points.len() / TOLERATED_NEAR {
                near
            } else {
                far
            },
            max,
            mean: distances.iter().sum::<f64>() / points.len().max(1) as f64,
        }
    }

    /// In words that some is missing at cells of this length.
    pub(crate) fn explained(&self, cell: f64) -> Warning {
        Warning::new(
            "missing",
            format!(
                "{} of {} points of the true solid's surface are off the result by up to {}, at cells of {}: what is narrower than a cell is lost; take a smaller --cell",
                self.lost,
                self.samples,
                figure(self.max),
                figure(cell),
            ),
        )
    }

    /// Whether less is missing than in another solid of the same points. Numbers of
    /// those lost at cells of other lengths cannot be compared.
    pub(crate) fn is_better_than(&self, other: &Missing) -> bool {
        match (self.is_none(), other.is_none()) {
            (true, true) => self.lost < other.lost,
            (false, false) => self.mean < other.mean,
            (better, _) => better,
        }
    }

    /// Whether all but odd points are there.
    pub fn is_none(&self) -> bool {
        self.lost <= self.samples / TOLERATED
    }
}

/// Distances of points from a mesh.
fn distances(points: &[DVec3], mesh: &TriMesh) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; points.len()];
    for triangles in mesh.triangles.chunks(AT_A_TIME) {
        let corners = triangles
            .iter()
            .map(|t| t.map(|v| mesh.positions[v as usize]));
        // Which of them share vertices only matters to signs.
        let apart = (0..triangles.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]);
        let field = Field::from_triangles(corners.collect(), apart.collect(), Vec::new());
        distances
            .par_iter_mut()
            .zip(points)
            .for_each(|(distance, &p)| *distance = distance.min(field.footpoint(p).distance));
    }
    distances
}
