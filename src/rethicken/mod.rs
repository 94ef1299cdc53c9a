//! Re-thickening: a mid-surface with its balls back to a solid.
//!
//! The solid is the union of balls around all points of the surface, their
//! radius linear over each triangle: one *slab* a triangle, the hull of three
//! balls. Of a mid-surface with its maximal balls that is the part again, less
//! the convex edges and corners that no ball reaches, whose sheets the
//! extraction leaves out. At coping borders the solid ends flat, as the
//! thickened solid of Wang and Chen, "Thickening Freeform Surfaces for Solid
//! Fabrication", does without its set B(S); at fading borders it keeps the
//! round of the balls.
//!
//! * [`BallSurface`]: the checked input.
//! * `slab`: the closed form of one slab.
//! * `tree`: the nearest of many.
//! * `ends`: planes at coping borders.
//! * `solid`: the function, which [`dual_contour`] meshes.
//! * `measure`: what of its surface the mesh does not have; then cells get finer.
//!
//! # What is promised
//!
//! The mesh is that of the contouring: closed, manifold, outward, without
//! self-intersections; same input, same bytes. Flat ends and the creases
//! between slabs are exact, as far as the contouring finds them.
//!
//! # What is not
//!
//! Between vertices the surface is flat and the radius linear: bent walls come
//! back as the sagitta leaves them. A flat end stands on the triangles at the
//! border, not on the coping face that was there; where that was slanted
//! against the sheet, the end differs from it.

mod ends;
mod measure;
mod slab;
mod solid;
mod surface;
#[cfg(test)]
mod tests;
mod tree;

use std::time::Instant;

use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use crate::dual_contour::{self, Contour, Filters, Grid, GridError, Numbers, Work};
use crate::field::Missing;
use crate::mesh::{Frame, TriMesh};
use crate::settings::cell::{self, BadCell};
use crate::settings::memory::MEMORY_LIMIT;
use crate::settings::precision::Precision;
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::settings::warning::Warning;
use measure::missing;
use solid::SlabSolid;

pub use surface::BallSurface;

/// Cells in the order tried while some of the solid is missing, over those
/// asked for.
const FINER: [f64; 4] = [1.0, 0.6, 0.36, 0.2];

/// A contour of more triangles than this is not tried again with finer cells.
const MOST_REFINED: usize = 1_000_000;

/// How finely to mesh the solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Edge length of a grid cell, part units. Finer ones are tried where the
    /// solid has features that these miss.
    pub cell: f64,
    /// Chords that stray from the solid by more than this, part units, get
    /// another vertex. Infinite: none do.
    pub tolerance: f64,
    /// Numbers that vertices may have.
    pub precision: Precision,
    /// Most memory that the grid may take, bytes; a finer cell is refused.
    pub memory_limit: u64,
}

impl Settings {
    /// Default cells across the least thickness.
    pub const CELLS: f64 = 4.0;

    /// Default of [`Settings::tolerance`], over the median thickness.
    pub const TOLERANCE: f64 = 1e-3;

    /// Default settings for a surface: a quarter of the least thickness a
    /// cell, but not finer than an eighth of the median, nor larger than the
    /// surface is small, nor finer than a quarter of the memory bound.
    pub fn new(surface: &BallSurface) -> Settings {
        let (least, median) = (surface.least_thickness(), surface.median_thickness());
        let memory_limit = MEMORY_LIMIT;
        let area = surface.area();
        let through = (least / Settings::CELLS).max(median / 8.0);
        let along = area.sqrt() / cell::CELLS_ALONG;
        let cell = if along > 0.0 {
            through.min(along)
        } else {
            through
        };
        let cell = cell.max(dual_contour::smallest_cell(2.2 * area, memory_limit / 4));
        Settings {
            cell,
            tolerance: Settings::TOLERANCE * median.max(least),
            precision: Precision::Double,
            memory_limit,
        }
    }
}

/// Why there is no solid.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum RethickenError {
    /// There is nothing to thicken.
    #[error("the surface has no triangles")]
    #[diagnostic(help("extract the mid-surface again"))]
    NoTriangles,
    /// A vertex has no radius, or a radius no vertex.
    #[error("{radii} radii for {vertices} vertices")]
    #[diagnostic(help("extract the mid-surface again"))]
    RadiusCount {
        /// Radii given.
        radii: usize,
        /// Vertices given.
        vertices: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("the triangle {corners:?} names a vertex that does not exist")]
    #[diagnostic(help("extract the mid-surface again"))]
    BadIndex {
        /// Its corners.
        corners: [u32; 3],
    },
    /// A position is no point.
    #[error("the position of vertex {vertex} is not finite")]
    #[diagnostic(help("extract the mid-surface again"))]
    BadPosition {
        /// The first such vertex, counted from 0.
        vertex: usize,
    },
    /// A radius is negative or no number.
    #[error("the radius {radius} of vertex {vertex} is not a length ({count} such in all)")]
    #[diagnostic(help("extract the mid-surface again"))]
    BadRadius {
        /// The first such vertex, counted from 0.
        vertex: usize,
        /// Its radius.
        radius: f64,
        /// How many there are.
        count: usize,
    },
    /// All radii are zero.
    #[error("the thickness is zero everywhere")]
    #[diagnostic(help("extract the mid-surface again"))]
    NoThickness,
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
    /// No grid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Grid(#[from] GridError),
    /// Every node of the grid missed the solid.
    #[error("the solid is thinner than a cell everywhere; take a cell smaller than {0}")]
    #[diagnostic(help("take a smaller --cell"))]
    Empty(f64),
    /// It was asked to stop; see [`rethicken_until`].
    #[error("stopped on request")]
    #[diagnostic(help("start again"))]
    Stopped,
}

impl From<Stopped> for RethickenError {
    fn from(_: Stopped) -> RethickenError {
        RethickenError::Stopped
    }
}

/// A solid and what it took.
#[derive(Clone, Debug)]
pub struct Rethickened {
    /// Closed, manifold, outward, without self-intersections, not empty.
    pub mesh: TriMesh,
    /// What the user should know.
    pub warnings: Vec<RethickenWarning>,
    /// Edge length of the cells that were used, part units.
    pub cell: f64,
    /// What of the true solid's surface is not there.
    pub missing: Missing,
    /// Building slabs, tree and ends.
    pub solid_seconds: f64,
    /// The grid's work.
    pub work: Work,
}

/// What may have been lost, or was.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RethickenWarning {
    /// The mesh does not have all of the true solid's surface.
    Missing {
        /// What it lacks.
        missing: Missing,
        /// Edge length of the cells, part units.
        cell: f64,
    },
    /// The solid is thinner than two cells somewhere: it may have holes there.
    CoarseCell,
}

impl RethickenWarning {
    /// The same in words.
    pub fn explained(self) -> Warning {
        match self {
            RethickenWarning::Missing { missing, cell } => missing.explained(cell),
            RethickenWarning::CoarseCell => Warning::new(
                "coarse_cell",
                "the cell is larger than half the least thickness: thin places may be missed",
            ),
        }
    }
}

/// The solid of a surface with its balls.
///
/// Deterministic: the same surface and settings give the same result, bit for
/// bit, on any number of threads.
///
/// ```
/// use glam::DVec3;
/// use midsurf::mesh::TriMesh;
/// use midsurf::rethicken::{BallSurface, Settings, rethicken};
///
/// let square = TriMesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
///     triangles: vec![[0, 1, 2], [0, 2, 3]],
/// };
/// let shell = BallSurface::of_shell(&square, &[0.2, 0.2])?;
/// let solid = rethicken(&shell, &Settings::new(&shell), &|_, _, _| ())?;
/// // Half of the thickness to either side, flat ends.
/// assert!((solid.mesh.volume() - 0.2).abs() < 1e-9);
/// # Ok::<(), midsurf::rethicken::RethickenError>(())
/// ```
///
/// # Errors
///
/// [`RethickenError`] for settings without sense, a grid past the memory
/// bound, and an empty result.
pub fn rethicken(
    surface: &BallSurface,
    settings: &Settings,
    progress: &Progress,
) -> Result<Rethickened, RethickenError> {
    rethicken_until(surface, settings, progress, &Stop::default())
}

/// As [`rethicken`], but ends early when asked to.
///
/// # Errors
///
/// As [`rethicken`], and [`RethickenError::Stopped`].
pub fn rethicken_until(
    surface: &BallSurface,
    settings: &Settings,
    progress: &Progress,
    stop: &Stop,
) -> Result<Rethickened, RethickenError> {
    let Settings {
        cell, tolerance, ..
    } = *settings;
    cell::check(cell)?;
    if tolerance.is_nan() || tolerance <= 0.0 {
        return Err(RethickenError::BadTolerance(tolerance));
    }
    let start = Instant::now();
    progress("field", 0, 0);
    let frame = surface.frame();
    let surface = &*surface.in_frame(frame);
    let solid = SlabSolid::new(surface);
    let solid_seconds = start.elapsed().as_secs_f64();
    let mut best: Option<(Missing, f64, Contour)> = None;
    for finer in FINER {
        let cell = finer * settings.cell;
        let contour = match contour(&solid, surface, settings, cell, frame, progress, stop) {
            Err(RethickenError::Grid(_)) if best.is_some() => break,
            contour => contour?,
        };
        progress("check", 0, 0);
        let lacks = missing(&solid, surface, &contour.mesh, cell);
        let triangles = contour.mesh.triangles.len();
        if best
            .as_ref()
            .is_none_or(|(least, ..)| lacks.is_better_than(least))
        {
            best = Some((lacks, cell, contour));
        }
        if lacks.is_none() || triangles > MOST_REFINED {
            break;
        }
    }
    let least = surface.least_thickness();
    let (missing, cell, mut contour) = best
        .filter(|(.., contour)| !contour.mesh.triangles.is_empty())
        .ok_or(RethickenError::Empty(0.5 * least))?;
    frame.leave(&mut contour.mesh.positions);
    let lost = (!missing.is_none()).then_some(RethickenWarning::Missing { missing, cell });
    let coarse = (cell > 0.5 * least).then_some(RethickenWarning::CoarseCell);
    Ok(Rethickened {
        mesh: contour.mesh,
        warnings: lost.into_iter().chain(coarse).collect(),
        cell,
        missing,
        solid_seconds,
        work: contour.work,
    })
}

/// The solid meshed with cells of this length; perhaps nothing.
fn contour(
    solid: &SlabSolid,
    surface: &BallSurface,
    settings: &Settings,
    cell: f64,
    frame: Frame,
    progress: &Progress,
    stop: &Stop,
) -> Result<Contour, RethickenError> {
    let grid = Grid::within(
        &solid.bounds(),
        // Both sides, and some for the ends.
        2.2 * surface.area(),
        cell,
        Numbers::new(settings.precision, frame),
        settings.memory_limit,
    )?;
    let how = dual_contour::Settings {
        tolerance: settings.tolerance,
        filters: Filters::default(),
    };
    Ok(dual_contour::contour(solid, &grid, &how, progress, stop)?)
}
