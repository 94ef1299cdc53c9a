//! The round trip: a part to its mid-surface, back to a solid, and the two
//! compared.
//!
//! What comes back is the part as far as the balls of the mid-surface reach.
//! Convex corners whose fins were pruned come back round; figures are given
//! with and without them, see [`Comparison::away`].

mod deviation;
mod distances;
mod overlap;
mod pruned;

use glam::DVec3;
use miette::Diagnostic;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::extract::{self, ExtractError, Extraction, extract};
use crate::field::Field;
use crate::mesh::samples::spread;
use crate::mesh::{FaceId, Frame, Part, TriMesh, self_intersections};
use crate::rethicken::{self, BallSurface, RethickenError, Rethickened, rethicken};
use crate::settings::cell::{CellSize, Scale};
use crate::settings::progress::Progress;
use crate::walls::{Separation, Walls};
use overlap::overlap;
use pruned::Pruned;

pub use deviation::{DeviationMap, deviation_map};
pub use distances::Distances;

/// What to do and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Of the extraction.
    pub extract: extract::Settings,
    /// Cell of the solid's grid; by default that of
    /// [`rethicken::Settings::new`], and a thickness is the median one of the
    /// mid-surface.
    pub solid_cell: CellSize,
    /// Most memory for either stage, bytes.
    pub memory_limit: u64,
}

/// Points on each surface at which distances are measured.
const SAMPLES: usize = 40_000;

/// Why there was no round trip.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum RoundTripError {
    /// There.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Extract(#[from] ExtractError),
    /// And back.
    #[error(transparent)]
    #[diagnostic(transparent)]
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
    let scale = Scale {
        auto: Some(solid_settings.cell),
        thickness: Some(surface.median_thickness()),
        diagonal: surface.diagonal(),
    };
    solid_settings.cell = (settings.solid_cell.resolve(&scale)).map_err(RethickenError::from)?;
    solid_settings.memory_limit = settings.memory_limit;
    let solid = rethicken(&surface, &solid_settings, progress)?;
    progress("compare", 0, 0);
    let separation = extract::separation(&settings.extract);
    let part = extraction.solid.as_ref().unwrap_or(part);
    let frame = Frame::around(&part.bounds());
    let mut comparison = compare(
        &part.in_frame(frame),
        &extraction.surface.mesh().in_frame(frame),
        &solid.mesh.in_frame(frame),
        separation,
        surface.median_thickness(),
    );
    frame.leave([&mut comparison.all, &mut comparison.away].map(|s| &mut s.worst_at));
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
    /// The point itself or the nearest one: what the part has there.
    on_part: (FaceId, DVec3),
}

/// The two surfaces from each other's points.
struct Views<'a> {
    part: Field,
    solid: Field,
    pruned: Pruned<'a>,
}

impl Views<'_> {
    fn seen_from_part(&self, points: &[(FaceId, DVec3)]) -> Vec<Seen> {
        let see = |&(face, at): &(FaceId, DVec3)| Seen {
            at,
            distance: self.solid.footpoint(at).distance,
            on_part: (face, at),
        };
        points.par_iter().map(see).collect()
    }

    fn seen_from_solid(&self, points: &[DVec3]) -> Vec<Seen> {
        let see = |&at: &DVec3| {
            let foot = self.part.footpoint(at);
            Seen {
                at,
                distance: foot.distance,
                on_part: (foot.face, foot.point),
            }
        };
        points.par_iter().map(see).collect()
    }

    fn is_pruned(&self, seen: &Seen) -> bool {
        self.pruned.is_pruned(seen.on_part.0, seen.on_part.1)
    }

    /// The farthest point; with `away`, of those that are not pruned. Few are
    /// asked whether they are.
    fn farthest(&self, seen: &mut [Seen], away: bool) -> Option<Seen> {
        seen.par_sort_by(|a, b| b.distance.total_cmp(&a.distance));
        let counts = |s: &&Seen| !away || !self.is_pruned(s);
        seen.iter().find(counts).copied()
    }
}

fn compare(
    part: &Part,
    surface: &TriMesh,
    solid: &TriMesh,
    separation: Separation,
    thickness: f64,
) -> Comparison {
    let field = Field::new(part);
    let walls = Walls::new(part, &field, separation);
    let (solid_field, pruned) = rayon::join(
        || Field::of_mesh(solid),
        || Pruned::new(part, &walls, surface, thickness),
    );
    let views = Views {
        part: Field::of_mesh(part.mesh()),
        solid: solid_field,
        pruned,
    };
    let corners: Vec<(FaceId, DVec3)> = (part.mesh().faces())
        .filter(|&face| field.normal(face) != DVec3::ZERO)
        .flat_map(|face| part.corners(face).map(|p| (face, p)))
        .collect();
    let even: Vec<DVec3> = spread(solid, SAMPLES).into_iter().map(|(_, p)| p).collect();
    let samples = [
        views.seen_from_part(&spread(part.mesh(), SAMPLES)),
        views.seen_from_solid(&even),
    ];
    let mut corners = [
        views.seen_from_part(&corners),
        views.seen_from_solid(&solid.positions),
    ];
    let lost: [Vec<bool>; 2] = [0, 1].map(|i| {
        let samples = samples[i].par_iter();
        samples.map(|seen| views.is_pruned(seen)).collect()
    });

    let mut symmetric = |away: bool| {
        let [(part_to_solid, a), (solid_to_part, b)] = [0, 1].map(|i| {
            let counted = samples[i]
                .iter()
                .zip(&lost[i])
                .filter(|(_, lost)| !(away && **lost));
            let mut counted: Vec<Seen> = counted.map(|(seen, _)| *seen).collect();
            let farthest = [
                views.farthest(&mut counted, false),
                views.farthest(&mut corners[i], away),
            ];
            let farthest = farthest.into_iter().flatten();
            let farthest = farthest.max_by(|a, b| a.distance.total_cmp(&b.distance));
            let max = farthest.map_or(0.0, |seen| seen.distance);
            counted.reverse();
            let sorted: Vec<f64> = counted.into_iter().map(|seen| seen.distance).collect();
            (Distances::of(&sorted, max), farthest)
        });
        let both = [a, b].into_iter().flatten();
        let worst = both.max_by(|a, b| a.distance.total_cmp(&b.distance));
        Symmetric {
            part_to_solid,
            solid_to_part,
            mean: 0.5 * (part_to_solid.mean + solid_to_part.mean),
            hausdorff: part_to_solid.max.max(solid_to_part.max),
            worst_at: worst.map_or(DVec3::ZERO, |seen| seen.at),
        }
    };
    let (all, away) = (symmetric(false), symmetric(true));
    let pruned = lost[0].iter().filter(|&&lost| lost).count();
    Comparison {
        thickness,
        volume_ratio: solid.volume() / part.volume(),
        area_ratio: solid.area() / part.area(),
        iou: overlap([part.mesh(), solid]),
        all,
        away,
        pruned_area: pruned as f64 / lost[0].len().max(1) as f64,
        self_intersections: self_intersections(solid).len(),
        closed: crate::mesh::EdgeUses::new(solid).census().is_closed(),
    }
}
