//! What is wrong or odd about a thickened solid.

use super::{Repair, Settings, Thickened, Way};
use crate::mesh::TriMesh;
use crate::settings::precision::Precision;
use crate::settings::quote::figure;
use crate::settings::warning::Warning;

impl Thickened {
    /// What is wrong or odd about it, and about the surface that it was made of
    /// with such settings.
    pub fn warnings(&self, surface: &TriMesh, settings: &Settings) -> Vec<Warning> {
        let single = settings.precision == Precision::Single;
        let rounded = single.then(|| rounded(surface)).flatten();
        let mut warnings: Vec<Warning> = rounded.into_iter().collect();
        warnings.extend(refined(self, settings.cell));
        warnings.extend(self.repairs.iter().map(|&repair| repaired(repair)));
        warnings.extend(made(self));
        warnings.extend(missing(self));
        warnings.extend(unsound(self));
        warnings
    }
}

/// The surface's own numbers do not fit into an .stl.
fn rounded(surface: &TriMesh) -> Option<Warning> {
    let count = surface
        .positions
        .iter()
        .filter(|&&p| Precision::Single.round_point(p) != p)
        .count();
    (count > 0).then(|| Warning::new("rounded", format!(
            "{count} vertices of the surface have more digits than an .stl holds and are rounded; .obj and .ply keep them"
        )))
}

/// Another cell than the one asked for.
fn refined(result: &Thickened, asked: f64) -> Option<Warning> {
    (result.cell < asked).then(|| {
        Warning::new(
            "refined",
            format!(
                "cells of {} do not resolve the surface's boundary; cells of {} were taken",
                figure(asked),
                figure(result.cell)
            ),
        )
    })
}

fn repaired(repair: Repair) -> Warning {
    let (code, message) = match repair {
        Repair::Dropped { triangles } => (
            "dropped",
            format!("{triangles} triangles have a corner twice and were left out"),
        ),
        Repair::Turned { triangles } => (
            "turned",
            format!(
                "{triangles} triangles looked the other way than their neighbours and were turned"
            ),
        ),
        Repair::Stitched { edges } => (
            "stitched",
            format!(
                "{edges} edges have vertices of other triangles on them: their triangles were split there"
            ),
        ),
        Repair::Filled { holes } => ("filled", format!("{holes} holes were closed")),
        Repair::Parted { vertices } => (
            "parted",
            format!(
                "the surface touches itself in single points: there {vertices} vertices were doubled"
            ),
        ),
    };
    Warning::new(code, message)
}

/// A solid that is not the surface and what was joined to it.
fn made(result: &Thickened) -> Option<Warning> {
    let (code, message) = match result.way {
        Way::Joined => return None,
        Way::Cleared => (
            "cleared",
            "near its boundary the solid would have cut itself: what lay inside it was cut away, and triangles of the surface there are in pieces",
        ),
        Way::Contoured => (
            "contoured",
            "no cut follows the surface's boundary: the solid was meshed on all sides, and does not have the surface's own triangles",
        ),
    };
    let message = message.to_owned();
    Some(Warning::new(code, message))
}

fn missing(result: &Thickened) -> Option<Warning> {
    let missing = &result.missing;
    (!missing.is_none()).then(|| missing.explained(result.cell))
}

fn unsound(result: &Thickened) -> Option<Warning> {
    (!result.is_sound()).then(|| Warning::new("unsound", format!(
            "the solid has {} pairs of triangles that cut each other and {} edges without two triangles; a smaller --cell may help",
            result.self_intersections, result.bad_edges
        )))
}
