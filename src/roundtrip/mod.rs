//! The round trip: a part to its mid-surface, back to a solid, and the two
//! compared.
//!
//! What comes back is the part as far as the balls of the mid-surface reach.
//! Convex corners whose fins were pruned come back round; figures are given
//! with and without them, see [`Comparison::away`].

mod deviation;
mod overlap;
mod pruned;
mod samples;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::dual_contour::Progress;
use crate::extract::{self, ExtractError, Extraction, extract};
use crate::field::Field;
use crate::field::walls::{Separation, Walls};
use crate::mesh::{FaceId, Part, TriMesh, self_intersections};
use crate::rethicken::{self, BallSurface, RethickenError, Rethickened, rethicken};
use overlap::overlap;
use pruned::{Pruned, field_of};
use samples::spread;

pub use deviation::{DeviationMap, deviation_map};
pub use samples::Distances;

/// What to do and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Of the extraction.
    pub extract: extract::Settings,
    /// Cell of the solid's grid, part units; none for the default of
    /// [`rethicken::Settings::new`].
    pub solid_cell: Option<f64>,
    /// Most memory for either stage, bytes.
    pub memory_limit: u64,
}

/// Points on each surface at which distances are measured.
const SAMPLES: usize = 40_000;

/// Why there was no round trip.
#[derive(Debug, Error)]
pub enum RoundTripError {
    /// There.
    #[error(transparent)]
    Extract(#[from] ExtractError),
    /// And back.
    #[error(transparent)]
    Rethicken(#[from] RethickenError),
}

/// Distances both ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Symmetric {
    /// From points of the part to the solid.
    pub part_to_solid: Distances,
    /// From points of the solid to the part.
    pub solid_to_part: Distances,
    /// Mean of the two means, part units.
    pub mean: f64,
    /// Greater of the two greatest, part units.
    pub hausdorff: f64,
    /// Where that is.
    pub worst_at: DVec3,
}

/// The solid beside the part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Comparison {
    /// Median thickness of the mid-surface, part units: what to hold the
    /// distances against.
    pub thickness: f64,
    /// Volume of the solid over that of the part.
    pub volume_ratio: f64,
    /// The same of areas.
    pub area_ratio: f64,
    /// Volume in both over volume in either, along many parallel lines.
    pub iou: f64,
    /// Everywhere.
    pub all: Symmetric,
    /// Away from pruned convex corners: points of the part that are reached
    /// by no ball because the fin there was left out, and points of the solid
    /// nearest to such.
    pub away: Symmetric,
    /// Share of the part's area that was left out for that.
    pub pruned_area: f64,
    /// Pairs of the solid's triangles that meet elsewhere than in common
    /// vertices and edges.
    pub self_intersections: usize,
    /// Whether the solid is closed, every edge run once each way.
    pub closed: bool,
}

/// There and back.
#[derive(Clone, Debug)]
pub struct RoundTrip {
    /// The mid-surface.
    pub extraction: Extraction,
    /// The solid.
    pub solid: Rethickened,
    /// What the solid was made with.
    pub solid_settings: rethicken::Settings,
    /// How it compares.
    pub comparison: Comparison,
}

/// Extracts the mid-surface of a part, re-thickens it and compares.
///
/// # Errors
///
/// Those of the two stages.
pub fn roundtrip(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
) -> Result<RoundTrip, RoundTripError> {
    let extraction = extract(part, &settings.extract, progress)?;
    let surface = BallSurface::of(&extraction.surface)?;
    let mut solid_settings = rethicken::Settings::new(&surface);
    solid_settings.cell = settings.solid_cell.unwrap_or(solid_settings.cell);
    solid_settings.memory_limit = settings.memory_limit;
    let solid = rethicken(&surface, &solid_settings, progress)?;
    progress("compare", 0, 0);
    let separation = extract::separation(&settings.extract);
    let comparison = compare(part, &extraction, &solid.mesh, separation, surface.median_thickness());
    Ok(RoundTrip {
        extraction,
        solid,
        solid_settings,
        comparison,
    })
}

/// A point of one surface seen from the other.
#[derive(Clone, Copy)]
struct Seen {
    at: DVec3,
    distance: f64,
    pruned: bool,
}

fn compare(
    part: &Part,
    extraction: &Extraction,
    solid: &TriMesh,
    separation: Separation,
    thickness: f64,
) -> Comparison {
    let field = Field::new(part);
    let walls = Walls::new(part, &field, separation);
    let surface = TriMesh {
        positions: extraction.surface.vertices.iter().map(|v| v.position).collect(),
        triangles: extraction.surface.triangles.iter().map(|t| t.corners).collect(),
    };
    let pruned = Pruned::new(part, &walls, &surface, thickness);
    let part_field = field_of(part.mesh());
    let solid_field = field_of(solid);

    let of_part = |&(face, p): &(FaceId, DVec3)| Seen {
        at: p,
        distance: solid_field.footpoint(p).distance,
        pruned: pruned.is_pruned(face, p),
    };
    let of_solid = |p: DVec3| {
        let foot = part_field.footpoint(p);
        Seen {
            at: p,
            distance: foot.distance,
            pruned: pruned.is_pruned(foot.face, foot.point),
        }
    };
    let part_points = spread(part.mesh(), SAMPLES);
    let part_samples: Vec<Seen> = part_points.par_iter().map(of_part).collect();
    let corners: Vec<(FaceId, DVec3)> = (part.mesh().faces())
        .flat_map(|face| part.corners(face).map(|p| (face, p)))
        .collect();
    let part_corners: Vec<Seen> = corners.par_iter().map(of_part).collect();
    let solid_samples: Vec<Seen> = (spread(solid, SAMPLES).par_iter())
        .map(|&(_, p)| of_solid(p))
        .collect();
    let solid_corners: Vec<Seen> = solid.positions.par_iter().map(|&p| of_solid(p)).collect();

    let symmetric = |counts: fn(&Seen) -> bool| {
        let distances = |samples: &[Seen], corners: &[Seen]| {
            let of = |seen: &[Seen]| -> Vec<f64> {
                seen.iter().filter(|s| counts(s)).map(|s| s.distance).collect()
            };
            Distances::of(of(samples), of(corners).into_iter())
        };
        let all = [&part_samples, &part_corners, &solid_samples, &solid_corners];
        let worst = (all.into_iter().flatten().filter(|s| counts(s)))
            .reduce(|worst, seen| if seen.distance > worst.distance { seen } else { worst });
        let part_to_solid = distances(&part_samples, &part_corners);
        let solid_to_part = distances(&solid_samples, &solid_corners);
        Symmetric {
            part_to_solid,
            solid_to_part,
            mean: 0.5 * (part_to_solid.mean + solid_to_part.mean),
            hausdorff: part_to_solid.max.max(solid_to_part.max),
            worst_at: worst.map_or(DVec3::ZERO, |seen| seen.at),
        }
    };
    let lost = part_samples.iter().filter(|s| s.pruned).count();
    Comparison {
        thickness,
        volume_ratio: solid.volume() / part.volume(),
        area_ratio: solid.area() / part.area(),
        iou: overlap([part.mesh(), solid]),
        all: symmetric(|_| true),
        away: symmetric(|seen| !seen.pruned),
        pruned_area: lost as f64 / part_samples.len().max(1) as f64,
        self_intersections: self_intersections(solid).len(),
        closed: crate::mesh::EdgeUses::new(solid).census().is_closed(),
    }
}
