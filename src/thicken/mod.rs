//! One-sided thickening of open or closed patches.

mod collar;
mod cut;
mod patch;
mod solid;

use std::time::Instant;

use glam::DVec3;
use serde::Serialize;
use thiserror::Error;

use crate::dual_contour::{self, Filters, Grid, Precision, Progress, Work};
use crate::mesh::{TriMesh, self_intersections, weld_exact};
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
            memory_limit: 8 << 30,
            filters: Filters::default(),
        }
    }
}

/// Why there is no solid.
#[derive(Debug, Error)]
pub enum ThickenError {
    /// The thickness is no positive number.
    #[error("thickness {0} is not a positive length")]
    BadThickness(f64),
    /// The cell size is not a positive number.
    #[error("cell size {0} is not a positive length")]
    BadCell(f64),
    /// The tolerance is not a positive number.
    #[error("tolerance {0} is not a positive length")]
    BadTolerance(f64),
    /// Remark 1.
    #[error(
        "cell size {cell} is too large for a thickness of {thickness}: it has to be less than half of it"
    )]
    CoarseCell {
        /// Cell asked for.
        cell: f64,
        /// Thickness asked for.
        thickness: f64,
    },
    /// No triangles.
    #[error("the patch has no triangles")]
    Empty,
    /// A corner that does not exist, or is no point.
    #[error("triangle {0} has a corner that does not exist or is no point")]
    BadCorner(usize),
    /// Triangles without area have no side.
    #[error("{count} triangles have no area, the first is triangle {triangle}")]
    NoArea {
        /// The first.
        triangle: usize,
        /// How many.
        count: usize,
    },
    /// More than two triangles at an edge.
    #[error("{triangles} triangles meet at the edge from {} to {}; a patch has two at most", between[0], between[1])]
    NotManifold {
        /// Triangles at the edge.
        triangles: usize,
        /// Its ends.
        between: [DVec3; 2],
    },
    /// The surface touches itself in a point.
    #[error("the patch touches itself at {0}: its triangles there form more than one fan")]
    PinchedVertex(DVec3),
    /// Neighbours that do not agree about the side.
    #[error("the two triangles at the edge from {} to {} do not agree about the side", .0[0], .0[1])]
    Sides([DVec3; 2]),
    /// The patch has one side.
    #[error("the patch has one side only, like a Moebius strip")]
    OneSided,
    /// The patch cuts through itself.
    #[error(
        "the patch cuts through itself: {pairs} pairs of triangles, the first {first} and {second}"
    )]
    SelfIntersecting {
        /// Pairs.
        pairs: usize,
        /// Triangle of the first pair.
        first: u32,
        /// Triangle of the first pair.
        second: u32,
    },
    /// The grid would not fit.
    #[error(
        "cell size {cell} needs about {gigabytes:.1} GB; the smallest cell that fits is about {smallest:.4}"
    )]
    TooFine {
        /// Cell asked for.
        cell: f64,
        /// Memory that it would take.
        gigabytes: f64,
        /// Smallest cell within the bound.
        smallest: f64,
    },
    /// More cells along an axis than the grid can count, or planes that the
    /// numbers allowed cannot tell apart.
    #[error("cell size {cell} is too small for a box of {size:.6} at {far:.6} from the origin")]
    NoGrid {
        /// Cell asked for.
        cell: f64,
        /// Longest side of the box around the solid.
        size: f64,
        /// Greatest coordinate.
        far: f64,
    },
    /// The contour could not be joined to the boundary.
    #[error(
        "cells of {cell} are too large here: the solid's surface does not follow each boundary curve"
    )]
    Unresolved {
        /// Cell asked for.
        cell: f64,
    },
}

/// A solid and what it took.
#[derive(Clone, Debug)]
pub struct Thickened {
    /// Closed and manifold; the patch's vertices and triangles come first.
    pub mesh: TriMesh,
    /// Pairs of triangles of the result that cut each other.
    pub self_intersections: usize,
    /// Checking the patch and building the tree.
    pub field_seconds: f64,
    /// Cutting and joining.
    pub join_seconds: f64,
    /// The grid's work.
    pub work: Work,
}

/// Heights at which the contour is cut, over the thickness, in the order tried.
const LEVELS: [f64; 5] = [0.4, 0.47, 0.33, 0.55, 0.26];

/// The solid of a thickness on one side of a patch.
///
/// # Errors
///
/// [`ThickenError`].
pub fn thicken(
    surface: &TriMesh,
    settings: &Settings,
    progress: &Progress,
) -> Result<Thickened, ThickenError> {
    let start = Instant::now();
    let mut mesh = weld_exact(&surface.positions).apply(surface);
    if settings.side == Side::Outer {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
    let patch = Patch::new(mesh)?;
    let field_seconds = start.elapsed().as_secs_f64();
    let r = settings.thickness;
    let solid = ThickSolid::new(&patch, r, settings.cell);
    let bounds = dual_contour::Implicit::bounds(&solid);
    let grid =
        Grid::around(&bounds, settings.cell, settings.precision).ok_or(ThickenError::NoGrid {
            cell: settings.cell,
            size: bounds.size().max_element(),
            far: bounds.min.abs().max(bounds.max.abs()).max_element(),
        })?;
    let contour = dual_contour::contour(
        &solid,
        &grid,
        &dual_contour::Settings {
            tolerance: settings.tolerance,
            filters: settings.filters,
        },
        progress,
    );
    let begin = Instant::now();
    progress("join", 0, 0);
    let distances = cut::distances(&patch, &contour.mesh);
    let mut best: Option<(usize, TriMesh)> = None;
    for share in LEVELS {
        let level = share * r;
        let mut cut = cut::cut(&contour.mesh, &distances, level);
        let places = collar::settle(&patch, &mut cut, level);
        let first = patch.mesh.positions.len() as u32;
        let Ok(collar) = collar::join(&patch, &cut, &places, first) else {
            if std::env::var("THICK_DEBUG").is_ok() {
                eprintln!(
                    "level {share}: {} curves for {}",
                    cut.curves.len(),
                    patch.rim.loops.len()
                );
            }
            continue;
        };
        let mut mesh = patch.mesh.clone();
        mesh.positions.extend(&cut.mesh.positions);
        let far = cut.mesh.triangles.iter().map(|t| t.map(|v| v + first));
        mesh.triangles.extend(far);
        mesh.triangles.extend(collar);
        let pairs = self_intersections(&mesh);
        if std::env::var("THICK_DEBUG").is_ok() {
            let (np, nf) = (patch.mesh.triangles.len(), cut.mesh.triangles.len());
            let kind = |f: crate::mesh::FaceId| {
                if f.index() < np {
                    'P'
                } else if f.index() < np + nf {
                    'C'
                } else {
                    'Z'
                }
            };
            let kinds: Vec<String> = pairs
                .iter()
                .take(8)
                .map(|&(a, b)| format!("{}{} at {:.3}", kind(a), kind(b), mesh.corners(b)[0]))
                .collect();
            eprintln!(
                "level {share}: {} pairs {kinds:?} {:?}",
                pairs.len(),
                mesh.edges().census()
            );
        }
        let pairs = pairs.len();
        if best.as_ref().is_none_or(|b| pairs < b.0) {
            best = Some((pairs, mesh));
        }
        if pairs == 0 {
            break;
        }
    }
    let (self_intersections, mesh) = best.ok_or(ThickenError::Unresolved {
        cell: settings.cell,
    })?;
    Ok(Thickened {
        mesh,
        self_intersections,
        field_seconds,
        join_seconds: begin.elapsed().as_secs_f64(),
        work: contour.work,
    })
}
