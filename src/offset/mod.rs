//! Offsets of closed meshes, free of self-intersections.
//!
//! After Liu and Wang, "Fast Intersection-free Offset Surface Generation from
//! Freeform Models with Triangular Meshes". The part becomes a function
//! (`solid`: signed distance less offset, with closed forms along grid edges),
//! and [`dual_contour`] makes the mesh.
//!
//! Bodies that overlap or touch are made one solid first (`bodies`): surface
//! inside it would keep its distance too.
//!
//! Deviations from the paper, each explained where it is made: distances and
//! tolerances in f64, an 8-wide tree in place of swept sphere volumes, edges
//! split where the closed form says instead of in the middle, vertices moved on
//! from the quadratic error function to the exact surface, chords that stray
//! split once, and sheets in one cell parted.

mod bodies;
mod openings;
mod solid;
#[cfg(test)]
mod tests;

use std::time::Instant;

use glam::DVec3;
use miette::Diagnostic;
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

pub use crate::dual_contour::{Deviation, Filters, GridError, Work};

use crate::dual_contour::{self, Grid, Implicit, Numbers};
use crate::field::Field;
use crate::mesh::{Bounds, Frame, Part, Simplify, TriMesh, simplify};
use crate::settings::cell::{self, BadCell};
use crate::settings::memory::MEMORY_LIMIT;
use crate::settings::precision::Precision;
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::settings::warning::Warning;
use bodies::one_solid;
use solid::OffsetSolid;

pub use bodies::{Void, Voids};
pub use openings::{Cut, Drain, OpeningError, OpeningSyntax, opened};

/// What to offset by, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Offset distance, part units: positive grows, negative shrinks.
    pub distance: f64,
    /// Edge length of a grid cell, part units.
    pub cell: f64,
    /// Chords that stray from the offset by more than this, part units, get
    /// another vertex. Infinite: none do.
    pub tolerance: f64,
    /// Numbers that vertices may have.
    pub precision: Precision,
    /// Most memory that the grid may take, bytes; a finer cell is refused.
    pub memory_limit: u64,
    /// Filters of the narrow band.
    pub filters: Filters,
    /// What becomes of cavities that the part has.
    pub voids: Voids,
    /// Whether flat and ruled regions get fewer triangles.
    pub simplify: Option<Simplify>,
}

impl Settings {
    /// Default of [`Settings::tolerance`], over the distance.
    pub const TOLERANCE: f64 = 2e-3;

    /// Default number of cells along the box around the offset.
    pub const CELLS: f64 = 256.0;

    /// Default settings for a part.
    pub fn new(part: &Part, distance: f64) -> Settings {
        let size = part.bounds().size() + 2.0 * distance.max(0.0);
        Settings {
            distance,
            cell: size.max_element() / Settings::CELLS,
            tolerance: Settings::TOLERANCE * distance.abs(),
            precision: Precision::Double,
            memory_limit: MEMORY_LIMIT,
            filters: Filters::default(),
            voids: Voids::Keep,
            simplify: None,
        }
    }
}

/// Why there is no offset.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum OffsetError {
    /// The distance is zero or no number.
    #[error("offset distance {0} is not a length other than zero")]
    #[diagnostic(help(
        "give --distance a positive length to grow, a negative one (--distance=-2) to shrink"
    ))]
    BadDistance(f64),
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
    /// The part is open: it has no inside.
    #[error(
        "the part is open, so it has no inside to grow or shrink; close its gaps, or thicken it as a surface"
    )]
    #[diagnostic(help("`midsurf info PART` counts the open edges"))]
    Open,
    /// No grid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Grid(#[from] GridError),
    /// Nothing is left.
    #[error(
        "nothing is left: no point of the part is farther than {0} from its surface (or what is left is thinner than a cell)"
    )]
    #[diagnostic(help("take a smaller distance or thickness, or smaller cells"))]
    Empty(f64),
    /// It was asked to stop; see [`offset_until`].
    #[error("stopped on request")]
    #[diagnostic(help("start again"))]
    Stopped,
}

impl From<Stopped> for OffsetError {
    fn from(_: Stopped) -> OffsetError {
        OffsetError::Stopped
    }
}

/// What is wrong with the part, but not so that nothing could be done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OffsetWarning {
    /// The part's bodies overlap or touch, or it cuts through itself; they were
    /// made one solid first.
    United {
        /// Pairs of triangles that cut or touched.
        pairs: usize,
    },
    /// The part cuts through itself and could not be made one solid;
    /// insidedness is by winding number.
    SelfIntersecting {
        /// Pairs of triangles that do.
        pairs: usize,
    },
    /// The part's triangles form no closed manifold; insidedness is by winding
    /// number.
    NotManifold,
    /// The distance is smaller than a cell: both sides of walls and gaps
    /// thinner than a cell may be missed.
    CoarseCell,
}

impl OffsetWarning {
    /// The same in words, of an offset by this distance.
    pub fn explained(self, distance: f64) -> Warning {
        let (code, message) = match self {
            OffsetWarning::United { pairs } => (
                "united",
                format!(
                    "bodies of the part overlap or touch, or it cuts through itself ({pairs} pairs of triangles): they were made one solid"
                ),
            ),
            OffsetWarning::SelfIntersecting { pairs } => (
                "self_intersecting",
                format!(
                    "the part cuts through itself ({pairs} pairs of triangles) and could not be made one solid: inside is told by winding number{}",
                    if distance < 0.0 {
                        ", and surface that lies inside keeps its distance too"
                    } else {
                        ""
                    }
                ),
            ),
            OffsetWarning::NotManifold => (
                "not_manifold",
                "the part is no clean closed surface: inside is told by winding number".to_owned(),
            ),
            OffsetWarning::CoarseCell => (
                "coarse_cell",
                "the cell is larger than the distance: walls and gaps thinner than a cell may be missed"
                    .to_owned(),
            ),
        };
        Warning::new(code, message)
    }
}

/// An offset and what it took.
#[derive(Clone, Debug)]
pub struct Offset {
    /// Closed, manifold, outward, without self-intersections, not empty.
    pub mesh: TriMesh,
    /// The solid that was offset, where it is not the part as given: its bodies
    /// in one, or its cavities filled.
    pub solid: Option<Part>,
    /// Cavities of that solid.
    pub voids: Vec<Void>,
    /// What the user should know.
    pub warnings: Vec<OffsetWarning>,
    /// How far the contour was simplified, part units.
    pub simplified: Option<f64>,
    /// Distance from the true offset at corners of triangles, sampled evenly
    /// over their list.
    pub corner_deviation: Deviation,
    /// The same at centres of triangles.
    pub centre_deviation: Deviation,
    /// Checking the part and building the tree: T_s of the paper's Table I.
    pub field_seconds: f64,
    /// The grid's work; T_d and T_c of Table I.
    pub work: Work,
}

/// Triangles at which the deviation is sampled.
const SAMPLES: usize = 5_000;

/// The offset surface of a part; coping tags do not matter.
///
/// Deterministic: the same part and settings give the same result, bit for
/// bit, on any number of threads.
///
/// ```
/// use midsurf::intake::{CopingSource, Input, Reading};
/// use midsurf::offset::{Settings, offset};
///
/// let plate = "fixtures/plate.obj".as_ref();
/// let part = Input::read(plate, &CopingSource::None, &Reading::default(), false)?.part;
/// let settings = Settings {
///     cell: 0.5,
///     ..Settings::new(&part, 1.0)
/// };
/// let grown = offset(&part, &settings, &|_, _, _| ())?;
/// assert!(grown.mesh.volume() > part.volume() + 0.9 * part.area());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`OffsetError`] for settings without sense, an open part, a grid past the
/// memory bound, and an empty result.
pub fn offset(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
) -> Result<Offset, OffsetError> {
    offset_until(part, settings, progress, &Stop::default())
}

/// As [`offset()`], but ends early when asked to.
///
/// # Errors
///
/// As [`offset()`], and [`OffsetError::Stopped`].
pub fn offset_until(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
    stop: &Stop,
) -> Result<Offset, OffsetError> {
    check(part, settings)?;
    let distance = settings.distance;
    let start = Instant::now();
    progress("field", 0, 0);
    let bodies = one_solid(part, settings.voids);
    let part = bodies.solid.as_ref().unwrap_or(part);
    let frame = Frame::around(&part.bounds().grown(distance.max(0.0)));
    let part = &*part.in_frame(frame);
    let (field, warnings) = field(part, settings, bodies.warning);
    stop.heed()?;
    let field_seconds = start.elapsed().as_secs_f64();

    let solid = OffsetSolid::new(&field, distance);
    let grid = grid(&solid.bounds(), part, settings, frame)?;
    let contour_settings = dual_contour::Settings {
        tolerance: settings.tolerance,
        filters: settings.filters,
    };
    let mut contour = dual_contour::contour(&solid, &grid, &contour_settings, progress, stop)?;
    if contour.mesh.triangles.is_empty() {
        return Err(OffsetError::Empty(distance.abs()));
    }
    let simplified = settings.simplify.map(|how| {
        progress("simplify", 0, 0);
        let fewer = simplify(&contour.mesh, &how);
        contour.mesh = fewer.mesh;
        fewer.tolerance
    });
    progress("check", 0, 0);
    let [corner_deviation, centre_deviation] = deviations(&solid, &contour.mesh);
    frame.leave(&mut contour.mesh.positions);
    Ok(Offset {
        mesh: contour.mesh,
        solid: bodies.solid,
        simplified,
        voids: bodies.voids,
        warnings,
        corner_deviation,
        centre_deviation,
        field_seconds,
        work: contour.work,
    })
}

/// A part with a cavity that leaves walls of the same thickness everywhere:
/// the part's own triangles, and its shrunk offset turned inside out after
/// them. Where the offset was made of another solid than the part as given
/// ([`Offset::solid`]), that is the part to hollow.
pub fn hollowed(part: &Part, shrunk: &TriMesh) -> TriMesh {
    let mut mesh = part.mesh().clone();
    let first = mesh.positions.len() as u32;
    mesh.positions.extend(&shrunk.positions);
    let inner = shrunk
        .triangles
        .iter()
        .map(|&[a, b, c]| [a + first, c + first, b + first]);
    mesh.triangles.extend(inner);
    mesh
}

fn check(part: &Part, settings: &Settings) -> Result<(), OffsetError> {
    let Settings {
        distance,
        cell,
        tolerance,
        ..
    } = *settings;
    if !distance.is_finite() || distance == 0.0 {
        return Err(OffsetError::BadDistance(distance));
    }
    cell::check(cell)?;
    if tolerance.is_nan() || tolerance <= 0.0 {
        return Err(OffsetError::BadTolerance(tolerance));
    }
    if !part.is_closed() {
        return Err(OffsetError::Open);
    }
    Ok(())
}

fn field(
    part: &Part,
    settings: &Settings,
    bodies: Option<OffsetWarning>,
) -> (Field, Vec<OffsetWarning>) {
    let mut field = Field::of_mesh(part.mesh());
    let mut warnings: Vec<OffsetWarning> = bodies.into_iter().collect();
    if let Some(OffsetWarning::SelfIntersecting { .. }) = bodies {
        field = field.by_winding();
    } else if !field.is_closed_manifold() {
        warnings.push(OffsetWarning::NotManifold);
    }
    if settings.distance.abs() < settings.cell {
        warnings.push(OffsetWarning::CoarseCell);
    }
    (field, warnings)
}

fn grid(
    bounds: &Bounds,
    part: &Part,
    settings: &Settings,
    frame: Frame,
) -> Result<Grid, OffsetError> {
    let Settings { distance, cell, .. } = *settings;
    if bounds.is_empty() {
        return Err(OffsetError::Empty(distance.abs()));
    }
    let round = 4.0 * std::f64::consts::PI * distance.max(0.0).powi(2);
    let area = part.area() + round;
    let numbers = Numbers::new(settings.precision, frame);
    let limit = settings.memory_limit;
    Ok(Grid::within(bounds, area, cell, numbers, limit)?)
}

/// Deviations at corners and at centres.
fn deviations(solid: &impl Implicit, mesh: &TriMesh) -> [Deviation; 2] {
    let step = mesh.triangles.len().div_ceil(SAMPLES).max(1);
    let samples: Vec<[f64; 2]> = mesh
        .triangles
        .par_iter()
        .step_by(step)
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            [a, (a + b + c) / 3.0].map(|p: DVec3| solid.sample(p, 0).value.abs())
        })
        .collect();
    [0, 1].map(|i| Deviation::of(samples.iter().map(|s| s[i])))
}
