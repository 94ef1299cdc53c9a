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
//! * [`crate::dual_contour`]: the solid's whole surface, free of
//!   self-intersections, with sharp edges between cross-section and shell.
//! * `cut`: what is near the patch is cut off.
//! * `collar`: the rest of the cross-section, up to the patch's own boundary.
//! * `make`: grids and cuts tried; what still cuts itself is cleared.
//! * `measure`: how far the solid is from the true one, both ways.
//! * `repair`: scans as they come made patches; `fill`: their small holes closed.
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
//! above the boundary. So there are no holes, and mostly no boundary triangle is
//! split and all of the patch is in the result bit for bit.
//!
//! # What is promised
//!
//! The result is closed and manifold, cuts itself nowhere, and is the solid of
//! Definition 2 as far as cells resolve it; what they do not resolve is measured.
//! It holds the patch bit for bit where a joined solid cuts itself nowhere; else
//! that is cleared of what lies inside it, and where none can be joined the
//! contour is taken whole ([`Way`]).

mod collar;
mod cut;
mod fill;
mod make;
mod measure;
mod patch;
mod repair;
mod sharpen;
mod solid;
#[cfg(test)]
mod tests;
mod warning;

use std::time::Instant;

use glam::DVec3;
use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use crate::dual_contour::{Deviation, Filters, GridError, Numbers, Work};
use crate::mesh::{Frame, TriMesh, self_intersections, weld_exact};
use crate::settings::cell::{self, BadCell};
use crate::settings::memory::MEMORY_LIMIT;
use crate::settings::precision::Precision;
use crate::settings::progress::{Progress, Stop, Stopped};
use make::Maker;
use patch::Patch;
use repair::repair;

pub use crate::field::Missing;
pub use repair::Repair;

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
    /// Boundary curves no longer than this, part units, are closed first; zero: none
    /// are.
    pub holes: f64,
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

    /// Least number of cells along the root of the surface's area, by
    /// [`Settings::fitted`].
    pub const CELLS_ALONG: f64 = cell::CELLS_ALONG;

    /// Default settings.
    pub fn new(thickness: f64, side: Side) -> Settings {
        Settings {
            thickness,
            side,
            cell: thickness / Settings::CELLS,
            tolerance: Settings::TOLERANCE * thickness,
            holes: 0.0,
            precision: Precision::Double,
            memory_limit: MEMORY_LIMIT,
            filters: Filters::default(),
        }
    }
}

impl Settings {
    /// With cells that are small against the surface too: one that is no larger
    /// than its thickness has features that are smaller.
    pub fn fitted(self, surface: &TriMesh) -> Settings {
        let corner = |&v: &u32| surface.positions.get(v as usize).copied();
        let areas = surface.triangles.iter().filter_map(|[a, b, c]| {
            let (a, b, c) = (corner(a)?, corner(b)?, corner(c)?);
            Some(0.5 * (b - a).cross(c - a).length())
        });
        let along = areas.sum::<f64>().sqrt() / Settings::CELLS_ALONG;
        Settings {
            cell: if along > 0.0 {
                self.cell.min(along)
            } else {
                self.cell
            },
            ..self
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
    /// It was asked to stop; see [`thicken_until`].
    #[error("stopped on request")]
    #[diagnostic(help("start again"))]
    Stopped,
}

impl From<Stopped> for ThickenError {
    fn from(_: Stopped) -> ThickenError {
        ThickenError::Stopped
    }
}

/// How a solid came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// The patch, triangle for triangle, joined to what lies behind it.
    Joined,
    /// The same, less what of its surface lay inside it: there triangles are
    /// pieces of what they were.
    Cleared,
    /// The contour of the solid on all sides. The patch's own triangles are not
    /// in it; it lies within the tolerance where cells resolve it.
    Contoured,
}

/// A solid and what it took.
#[derive(Clone, Debug)]
pub struct Thickened {
    /// Closed and manifold if `bad_edges` is zero. Of a joined solid the patch's
    /// vertices and triangles come first, in their order; with [`Side::Outer`] its triangles
    /// are turned, because the solid's inside is then in front of them.
    pub mesh: TriMesh,
    /// How it came about.
    pub way: Way,
    /// Triangles of the patch, or pieces of such; they come first.
    pub patch_triangles: usize,
    /// Boundary curves of the patch.
    pub boundaries: usize,
    /// What was done to the surface first.
    pub repairs: Vec<Repair>,
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
    /// What of the true shell and cross-section is not there.
    pub missing: Missing,
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
    /// Whether the result is closed, manifold, and cuts itself nowhere.
    pub fn is_sound(&self) -> bool {
        self.self_intersections == 0 && self.bad_edges == 0
    }
}

/// The solid of a thickness on one side of a patch.
///
/// Vertices of the patch at one place count as one, those that no triangle
/// uses go. Deterministic: the same patch and settings give the same result,
/// bit for bit, on any number of threads.
///
/// ```
/// use glam::DVec3;
/// use midsurf::mesh::TriMesh;
/// use midsurf::thicken::{Settings, Side, thicken};
///
/// let square = TriMesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
///     triangles: vec![[0, 1, 2], [0, 2, 3]],
/// };
/// let solid = thicken(&square, &Settings::new(0.1, Side::Inner), &|_, _, _| ())?;
/// assert!(solid.is_sound());
/// assert!((solid.mesh.volume() - 0.1).abs() < 1e-9);
/// # Ok::<(), midsurf::thicken::ThickenError>(())
/// ```
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
    thicken_until(surface, settings, progress, &Stop::default())
}

/// As [`thicken`], but ends early when asked to.
///
/// # Errors
///
/// As [`thicken`], and [`ThickenError::Stopped`].
pub fn thicken_until(
    surface: &TriMesh,
    settings: &Settings,
    progress: &Progress,
    stop: &Stop,
) -> Result<Thickened, ThickenError> {
    check(settings)?;
    let start = Instant::now();
    progress("field", 0, 0);
    let mut mesh = tidy(surface)?;
    let frame = Frame::around(&mesh.bounds().grown(settings.thickness));
    let repairs = repair(&mut mesh, settings.holes);
    if mesh.triangles.is_empty() {
        return Err(ThickenError::Empty);
    }
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
    stop.heed()?;

    let maker = Maker {
        patch: &patch,
        settings,
        numbers: Numbers::new(settings.precision, frame),
        progress,
        stop,
    };
    let mut solid = maker.make()?;
    frame.leave(&mut solid.mesh.positions);
    Ok(Thickened {
        repairs,
        field_seconds,
        ..solid
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
