//! One-sided thickening: a solid behind a surface, the surface kept as it is.
//!
//! After Wang and Chen, "Thickening Freeform Surfaces for Solid Fabrication".
//! Stage by stage:
//!
//! ```text
//! patch -> solid -> (dual_contour) -> cut -> collar -> sharpen -> mesh
//! ```
//!
//! * `patch`: the checked surface, its boundary, and on which side of it a
//!   point lies (Definition 1).
//! * `solid`: the solid of Definition 2 as a function; its shell and
//!   cross-section have closed forms (Definitions 5a and 5b, Remark 4).
//! * [`dual_contour`]: the solid's whole surface, free of
//!   self-intersections, with sharp edges between cross-section and shell.
//! * `cut`: what is near the patch is cut off.
//! * `collar`: the rest of the cross-section, up to the patch's own boundary.
//! * `sharpen`: vertices moved to the edge between cross-section and shell
//!   where cells cut it off (section 4.3).
//!
//! # Deviations from the paper
//!
//! The paper lets the dual contouring reach for vertices of the boundary, found
//! or made in boundary-curve cells, leaves out faces on the patch (Remark 3),
//! fills the holes and moves vertices until edges are sharp (section 4.3).
//! Here the solid is contoured whole, with its sharp edges placed by their
//! closed forms at once, and cut where it is only cross-section, at one height
//! above the boundary. So there are no holes, no boundary triangle is split,
//! and all of the patch is in the result bit for bit.
//!
//! # What is promised
//!
//! The result is closed and manifold, holds the patch, and is the solid of
//! Definition 2 as far as cells resolve it; self-intersections are looked for,
//! and counted if some are left.

mod collar;
mod cut;
mod patch;
mod sharpen;
mod solid;
#[cfg(test)]
mod tests;

use std::time::Instant;

use glam::DVec3;
use miette::Diagnostic;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

use crate::dual_contour::{self, Deviation, Filters, Grid, GridError, Numbers, Work};
use crate::mesh::{Bounds, Frame, TriMesh, self_intersections, weld_exact};
use crate::settings::cell::{self, BadCell};
use crate::settings::memory::MEMORY_LIMIT;
use crate::settings::precision::Precision;
use crate::settings::progress::Progress;
use patch::Patch;
use solid::ThickSolid;

/// On which side of the patch the solid lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Against the normals: Definition 2 of the paper.
    Inner,
    /// Along the normals.
    Outer,
}

/// How to thicken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Thickness, part units.
    pub thickness: f64,
    /// Side of the solid.
    pub side: Side,
    /// Edge length of a grid cell, part units; less than half the thickness
    /// (Remark 1).
    pub cell: f64,
    /// Chords that stray by more than this, part units, get another vertex.
    pub tolerance: f64,
    /// Numbers that new vertices may have.
    pub precision: Precision,
    /// Most memory that the grid may take, bytes; a finer cell is refused.
    pub memory_limit: u64,
    /// Filters of the band.
    pub filters: Filters,
}

impl Settings {
    /// Default of [`Settings::tolerance`], over the thickness.
    pub const TOLERANCE: f64 = 2e-3;

    /// Default number of cells through the thickness.
    pub const CELLS: f64 = 4.0;

    /// Default settings.
    pub fn new(thickness: f64, side: Side) -> Settings {
        Settings {
            thickness,
            side,
            cell: thickness / Settings::CELLS,
            tolerance: Settings::TOLERANCE * thickness,
            precision: Precision::Double,
            memory_limit: MEMORY_LIMIT,
            filters: Filters::default(),
        }
    }
}

/// Why there is no solid.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum ThickenError {
    /// The thickness is no positive number.
    #[error("thickness {0} is not a positive length")]
    #[diagnostic(help("give --thickness a positive length; --side says on which side"))]
    BadThickness(f64),
    /// The cell size is no length.
    #[error(transparent)]
    #[diagnostic(transparent)]
    BadCell(#[from] BadCell),
    /// The tolerance is not a positive number.
    #[error("tolerance {0} is not a positive length")]
    #[diagnostic(help(
        "give --tolerance a positive length; leave --tolerance away for the default"
    ))]
    BadTolerance(f64),
    /// Remark 1.
    #[error(
        "cell size {cell} is too large for a thickness of {thickness}: it has to be less than half of it"
    )]
    #[diagnostic(help("take a smaller --cell; without it the cell is a quarter of the thickness"))]
    CoarseCell {
        /// Cell asked for.
        cell: f64,
        /// Thickness asked for.
        thickness: f64,
    },
    /// No triangles.
    #[error("the patch has no triangles")]
    #[diagnostic(help("check that the export holds the surface's faces"))]
    Empty,
    /// A corner that does not exist, or is no point.
    #[error("triangle {0} has a corner that does not exist or is no point")]
    #[diagnostic(help("check that the export holds the surface's faces"))]
    BadCorner(usize),
    /// Triangles without area have no side.
    #[error("{count} triangles have no area, the first is triangle {triangle}")]
    #[diagnostic(help("remove triangles whose corners lie on one line"))]
    NoArea {
        /// The first.
        triangle: usize,
        /// How many.
        count: usize,
    },
    /// More than two triangles at an edge.
    #[error("{triangles} triangles meet at the edge from {} to {}; a patch has two at most", between[0], between[1])]
    #[diagnostic(help("part the sheets that meet there, and thicken them one by one"))]
    NotManifold {
        /// Triangles at the edge.
        triangles: usize,
        /// Its ends.
        between: [DVec3; 2],
    },
    /// The surface touches itself in a point.
    #[error("the patch touches itself at {0}: its triangles there form more than one fan")]
    #[diagnostic(help("part the sheets that meet there, and thicken them one by one"))]
    PinchedVertex(DVec3),
    /// Neighbours that do not agree about the side.
    #[error("the two triangles at the edge from {} to {} do not agree about the side", .0[0], .0[1])]
    #[diagnostic(help("turn the triangles so that their normals agree"))]
    Sides([DVec3; 2]),
    /// The patch has one side.
    #[error("the patch has one side only, like a Moebius strip")]
    #[diagnostic(help("cut it open, so that it has two sides"))]
    OneSided,
    /// The patch cuts through itself.
    #[error(
        "the patch cuts through itself: {pairs} pairs of triangles, the first {first} and {second}"
    )]
    #[diagnostic(help(
        "remove the triangles that cut each other; the side of a point means nothing there"
    ))]
    SelfIntersecting {
        /// Pairs.
        pairs: usize,
        /// Triangle of the first pair.
        first: u32,
        /// Triangle of the first pair.
        second: u32,
    },
    /// No grid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Grid(#[from] GridError),
    /// The contour could not be joined to the boundary.
    #[error(
        "cells of {cell} are too large here: the solid's surface does not follow each boundary curve"
    )]
    #[diagnostic(help("take a smaller --cell or a smaller thickness"))]
    Unresolved {
        /// Cell asked for.
        cell: f64,
    },
}

/// A solid and what it took.
#[derive(Clone, Debug)]
pub struct Thickened {
    /// Closed and manifold if `bad_edges` is zero. The patch's vertices and
    /// triangles come first, in their order; with [`Side::Outer`] its triangles
    /// are turned, because the solid's inside is then in front of them.
    pub mesh: TriMesh,
    /// Triangles of the patch.
    pub patch_triangles: usize,
    /// Boundary curves of the patch.
    pub boundaries: usize,
    /// Pairs of triangles of the result that cut or touch each other.
    pub self_intersections: usize,
    /// Edges of the result that do not have two triangles, and triangles
    /// without area.
    pub bad_edges: usize,
    /// Cell of the grid: smaller than the one asked for where that did not
    /// resolve the boundary.
    pub cell: f64,
    /// Distance of the inner shell from its true place, at centres of
    /// triangles.
    pub deviation: Deviation,
    /// Ways tried to lay the grid and the cut until nothing cut itself.
    pub attempts: usize,
    /// Vertices moved to the edge between cross-section and inner shell.
    pub sharpened: usize,
    /// Checking the patch and building the tree.
    pub field_seconds: f64,
    /// Cutting, joining and checking.
    pub join_seconds: f64,
    /// Moving vertices to sharp edges.
    pub sharpen_seconds: f64,
    /// The grid's work, of the last attempt.
    pub work: Work,
}

impl Thickened {
    /// Whether the result is what is promised.
    pub fn is_sound(&self) -> bool {
        self.self_intersections == 0 && self.bad_edges == 0
    }
}

/// Heights at which the contour is cut, over the thickness, in the order tried.
const LEVELS: [f64; 5] = [0.4, 0.47, 0.33, 0.55, 0.26];

/// Grids in the order tried: cell, over the one asked for, and shift in cells.
const GRIDS: [(f64, f64); 5] = [
    (1.0, 0.0),
    (1.0, 0.29),
    (1.0, 0.61),
    (0.6, 0.0),
    (0.36, 0.0),
];

/// The solid of a thickness on one side of a patch.
///
/// Vertices of the patch at one place count as one, those that no triangle
/// uses go. Deterministic: the same patch and settings give the same result,
/// bit for bit, on any number of threads.
///
/// # Errors
///
/// [`ThickenError`] for settings without sense, for a surface that is no
/// oriented manifold or cuts through itself, and where cells are too large to
/// tell what runs along which boundary.
pub fn thicken(
    surface: &TriMesh,
    settings: &Settings,
    progress: &Progress,
) -> Result<Thickened, ThickenError> {
    check(settings)?;
    let start = Instant::now();
    progress("field", 0, 0);
    let mut mesh = tidy(surface)?;
    let frame = Frame::around(&mesh.bounds().grown(settings.thickness));
    frame.enter(&mut mesh.positions);
    if settings.side == Side::Outer {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let patch = Patch::new(mesh)?;
    let crossings = self_intersections(&patch.mesh);
    if let [(first, second), ..] = crossings[..] {
        return Err(ThickenError::SelfIntersecting {
            pairs: crossings.len(),
            first: first.0,
            second: second.0,
        });
    }
    let field_seconds = start.elapsed().as_secs_f64();
    let numbers = Numbers::new(settings.precision, frame);

    let mut best: Option<Thickened> = None;
    let mut attempts = 0;
    let mut join_seconds = 0.0;
    for (finer, shift) in GRIDS {
        let cell = finer * settings.cell;
        let solid = ThickSolid::new(&patch, settings.thickness, cell);
        let grid = match grid(&patch, &solid.bounds(), settings, numbers, cell, shift) {
            Ok(grid) => grid,
            Err(error) if attempts == 0 => return Err(error.into()),
            Err(_) => break,
        };
        let how = dual_contour::Settings {
            tolerance: settings.tolerance,
            filters: settings.filters,
        };
        let contour = dual_contour::contour(&solid, &grid, &how, progress);
        progress("join", 0, 0);
        let distances = cut::distances(&patch, &contour.mesh);
        for share in LEVELS {
            let begin = Instant::now();
            attempts += 1;
            let level = share * settings.thickness;
            let joined = join(&patch, &contour.mesh, &distances, level, numbers);
            join_seconds += begin.elapsed().as_secs_f64();
            let Some((mut mesh, pairs, bad_edges)) = joined else {
                continue;
            };
            let problems = |t: &Thickened| t.self_intersections + t.bad_edges;
            if best
                .as_ref()
                .is_none_or(|b| pairs + bad_edges < problems(b))
            {
                let begin = Instant::now();
                let mut sharpened = 0;
                if pairs == 0 {
                    let thickness = settings.thickness;
                    sharpened = sharpen::sharpen(&patch, &mut mesh, thickness, cell, numbers);
                }
                let sharpen_seconds = begin.elapsed().as_secs_f64();
                best = Some(Thickened {
                    patch_triangles: patch.mesh.triangles.len(),
                    boundaries: patch.rim.loops.len(),
                    self_intersections: pairs,
                    bad_edges,
                    cell,
                    deviation: deviation(&patch, &mesh, settings.thickness),
                    mesh,
                    attempts,
                    sharpened,
                    field_seconds,
                    join_seconds,
                    sharpen_seconds,
                    work: contour.work,
                });
            }
            if let Some(mut sound) = best.take_if(|best| best.is_sound()) {
                frame.leave(&mut sound.mesh.positions);
                return Ok(sound);
            }
            if patch.rim.loops.is_empty() {
                // Another cut would change nothing.
                break;
            }
        }
    }
    best.map(|mut best| {
        frame.leave(&mut best.mesh.positions);
        Thickened {
            attempts,
            join_seconds,
            ..best
        }
    })
    .ok_or(ThickenError::Unresolved {
        cell: settings.cell,
    })
}

fn check(settings: &Settings) -> Result<(), ThickenError> {
    let Settings {
        thickness,
        cell,
        tolerance,
        ..
    } = *settings;
    if !(thickness > 0.0 && thickness.is_finite()) {
        return Err(ThickenError::BadThickness(thickness));
    }
    cell::check(cell)?;
    if tolerance.is_nan() || tolerance <= 0.0 {
        return Err(ThickenError::BadTolerance(tolerance));
    }
    if cell >= 0.5 * thickness {
        return Err(ThickenError::CoarseCell { cell, thickness });
    }
    Ok(())
}

/// The surface with one vertex a place, and none without triangles.
fn tidy(surface: &TriMesh) -> Result<TriMesh, ThickenError> {
    if surface.triangles.is_empty() {
        return Err(ThickenError::Empty);
    }
    let sound = |&v: &u32| {
        let p = surface.positions.get(v as usize);
        p.is_some_and(|p| p.is_finite())
    };
    if let Some(bad) = surface.triangles.iter().position(|t| !t.iter().all(sound)) {
        return Err(ThickenError::BadCorner(bad));
    }
    let place = weld_exact(&surface.positions);
    let mut number = vec![u32::MAX; place.kept.len()];
    surface
        .triangles
        .iter()
        .flatten()
        .for_each(|&v| number[place.new_index[v as usize] as usize] = 0);
    let mut positions = Vec::new();
    for (slot, &old) in number.iter_mut().zip(&place.kept) {
        if *slot == 0 {
            *slot = positions.len() as u32;
            positions.push(surface.positions[old as usize]);
        }
    }
    let name = |v: u32| number[place.new_index[v as usize] as usize];
    Ok(TriMesh {
        positions,
        triangles: surface.triangles.iter().map(|t| t.map(name)).collect(),
    })
}

/// A grid for both shells, and for the nodes within reach of either side.
fn grid(
    patch: &Patch,
    bounds: &Bounds,
    settings: &Settings,
    numbers: Numbers,
    cell: f64,
    shift: f64,
) -> Result<Grid, GridError> {
    let area = 2.0 * patch.mesh.area();
    let volume = area * (settings.thickness + cell);
    let bounds = Bounds {
        min: bounds.min - shift * cell,
        max: bounds.max,
    };
    let limit = settings.memory_limit;
    Grid::within_filled(&bounds, area, volume, cell, numbers, limit)
}

/// The solid from its contour, with pairs of triangles that cut each other, and
/// edges without two triangles or triangles without area; none if the cut does not follow the boundary.
fn join(
    patch: &Patch,
    contour: &TriMesh,
    distances: &[f64],
    level: f64,
    numbers: Numbers,
) -> Option<(TriMesh, usize, usize)> {
    let mut cut = cut::cut(contour, distances, level);
    let places = collar::settle(patch, &mut cut, level, numbers);
    let first = patch.mesh.positions.len() as u32;
    let collar = collar::join(patch, &cut, &places, first)?;
    let mut mesh = patch.mesh.clone();
    mesh.positions.extend(&cut.mesh.positions);
    let far = cut.mesh.triangles.iter().map(|t| t.map(|v| v + first));
    mesh.triangles.extend(far);
    mesh.triangles.extend(collar);
    let census = mesh.edges().census();
    // The search for pairs passes over triangles without area.
    let flat = mesh.faces().filter(|&f| mesh.triangle_area(f) == 0.0);
    let bad = census.open + census.misoriented + census.balanced + census.unbalanced + flat.count();
    let pairs = self_intersections(&mesh);
    Some((mesh, pairs.len(), bad))
}

/// Distance from the true inner shell, at the centres of triangles that belong
/// to it.
fn deviation(patch: &Patch, mesh: &TriMesh, thickness: f64) -> Deviation {
    let own = patch.mesh.triangles.len();
    let errors: Vec<f64> = mesh.triangles[own..]
        .par_iter()
        .filter_map(|t| {
            let corners = t.map(|v| mesh.positions[v as usize]);
            let shell = |p: DVec3| {
                let foot = patch.foot(p, 0);
                let error = (foot.distance - thickness).abs();
                (error < 0.1 * thickness).then_some(error)
            };
            let [a, b, c] = corners.map(shell);
            (a?.max(b?).max(c?) < 0.01 * thickness)
                .then(|| shell((corners[0] + corners[1] + corners[2]) / 3.0))
                .flatten()
        })
        .collect();
    Deviation::of(errors)
}
