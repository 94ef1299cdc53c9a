//! An inner wall that never folds, at any thickness: the offset of the finely
//! tessellated limit surface.
//!
//! The paper leaves loops and self-intersections of the crust to future work.
//! Beyond the fold-free thickness no wall that follows the surface point by
//! point avoids them; the set of points deeper than the thickness does, and
//! the offset engine makes its surface. Of an open surface it is the thickened
//! solid that has the same wall, and flat rims.

use miette::Diagnostic;
use rayon::prelude::*;
use thiserror::Error;

use super::cage::Cage;
use super::{Boundary, SubdivideError, check_thickness, tessellate};
use crate::field::Field;
use crate::mesh::{FaceId, Part, PartError, PartOptions, TriMesh, self_intersections};
use crate::offset::{self, OffsetError, hollowed, offset};
use crate::settings::cell::{CellSize, Scale};
use crate::settings::precision::Precision;
use crate::settings::progress::Progress;
use crate::thicken::{self, Side, ThickenError, thicken};

/// What to contour, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourSettings {
    /// Wall thickness, part units.
    pub thickness: f64,
    /// Steps along each side of a face.
    pub samples: usize,
    /// Subdivision steps before.
    pub level: u32,
    /// Rule at the boundary.
    pub boundary: Boundary,
    /// Edge length of a grid cell; by default so that 256 go along a closed
    /// surface, four through the wall of an open one. A thickness is that of the
    /// wall.
    pub cell: CellSize,
    /// Numbers that vertices of the inner wall may have.
    pub precision: Precision,
}

/// Why there is no contoured wall.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum ContourError {
    /// The control mesh gives no surface.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Surface(#[from] SubdivideError),
    /// The inner wall has one distance.
    #[error("a contoured wall has one thickness all over")]
    #[diagnostic(help("leave --group away, or take --scheme crust or direct"))]
    Shares,
    /// The tessellated surface makes no part.
    #[error("the limit surface: {0}")]
    #[diagnostic(help("check the control mesh"))]
    Part(#[from] PartError),
    /// The surface has no offset at this thickness.
    #[error("the inner wall: {0}")]
    #[diagnostic(transparent)]
    Offset(#[from] OffsetError),
    /// The open surface could not be thickened.
    #[error("the inner wall: {0}")]
    #[diagnostic(transparent)]
    Thicken(#[from] ThickenError),
}

/// A hollow solid whose inner wall was contoured.
#[derive(Clone, Debug)]
pub struct ContourSolid {
    /// The limit surface, then the wall turned inside out.
    pub mesh: TriMesh,
    /// Triangles of the limit surface, which come first.
    pub outer: usize,
    /// Distance of each vertex to the other wall.
    pub thickness: Vec<f64>,
    /// Level that the samples divide.
    pub level: u32,
    /// Pairs of triangles that cut each other: only where the limit surface
    /// cuts itself.
    pub intersections: Vec<(FaceId, FaceId)>,
}

/// Hollows the limit surface out with an inner wall free of intersections.
///
/// # Errors
///
/// [`ContourError`]; nothing is left inside a solid thinner than two walls.
pub fn contour(
    cage: &Cage,
    settings: &ContourSettings,
    progress: &Progress,
) -> Result<ContourSolid, ContourError> {
    check_thickness(cage, settings.thickness)?;
    if cage.has_shares() {
        return Err(ContourError::Shares);
    }
    progress("surface", 0, 0);
    let (outer, level) = tessellate(cage, settings.level, settings.samples, settings.boundary)?;
    if outer.edges().census().is_closed() {
        hollow(outer, level, settings, progress)
    } else {
        thickened(&outer, level, settings, progress)
    }
}

/// Share of the thickness from which on a triangle belongs to the inner wall.
const NEARLY: f64 = 0.9;

/// The wall of an open surface.
fn thickened(
    outer: &TriMesh,
    level: u32,
    settings: &ContourSettings,
    progress: &Progress,
) -> Result<ContourSolid, ContourError> {
    let automatic = thicken::Settings::new(settings.thickness, Side::Inner).fitted(outer);
    let scale = Scale {
        auto: Some(automatic.cell),
        thickness: Some(settings.thickness),
        diagonal: outer.bounds().diagonal(),
    };
    let wall_settings = thicken::Settings {
        cell: settings.cell.resolve(&scale).map_err(ThickenError::from)?,
        precision: settings.precision,
        ..automatic
    };
    let solid = thicken(outer, &wall_settings, progress)?;
    progress("thickness", 0, 0);
    // Behind the surface, the rims left out.
    let behind = distances(&solid.mesh, outer);
    let is_far = |&v: &u32| behind[v as usize] > NEARLY * settings.thickness;
    let all = solid.mesh.triangles.iter().copied();
    let wall = TriMesh {
        positions: solid.mesh.positions.clone(),
        triangles: all.filter(|t| t.iter().all(is_far)).collect(),
    };
    let ahead = distances(&solid.mesh, &wall);
    let thickness = behind
        .into_iter()
        .zip(ahead)
        .map(|(a, b)| a.max(b))
        .collect();
    Ok(ContourSolid {
        intersections: self_intersections(&solid.mesh),
        outer: solid.patch_triangles,
        mesh: solid.mesh,
        thickness,
        level,
    })
}

/// The wall of a closed surface.
fn hollow(
    outer: TriMesh,
    level: u32,
    settings: &ContourSettings,
    progress: &Progress,
) -> Result<ContourSolid, ContourError> {
    let flags = vec![false; outer.triangles.len()];
    let (part, _) = Part::new(outer, flags, PartOptions::default())?;
    let automatic = offset::Settings::new(&part, -settings.thickness);
    let scale = Scale {
        auto: Some(automatic.cell),
        thickness: Some(settings.thickness),
        diagonal: part.bounds().diagonal(),
    };
    let wall_settings = offset::Settings {
        cell: settings.cell.resolve(&scale).map_err(OffsetError::from)?,
        precision: settings.precision,
        ..automatic
    };
    let wall = offset(&part, &wall_settings, progress)?;
    progress("thickness", 0, 0);
    let mesh = hollowed(&part, &wall.mesh);
    let thickness = [(part.mesh(), &wall.mesh), (&wall.mesh, part.mesh())]
        .map(|(from, to)| distances(from, to))
        .concat();
    progress("crossing", 0, 0);
    Ok(ContourSolid {
        intersections: self_intersections(&mesh),
        outer: part.triangle_count(),
        mesh,
        thickness,
        level,
    })
}

/// Distance of each vertex of a mesh to another mesh.
fn distances(from: &TriMesh, to: &TriMesh) -> Vec<f64> {
    if to.triangles.is_empty() {
        return vec![0.0; from.positions.len()];
    }
    let field = Field::of_mesh(to);
    let far = |p: &glam::DVec3| field.footpoint(*p).distance;
    from.positions.par_iter().map(far).collect()
}
