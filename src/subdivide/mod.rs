//! Hollow solids from Catmull-Clark control meshes, after Jianzhong Wang and
//! Fuhua Cheng, "A Heuristic Offsetting Scheme for Catmull-Clark Subdivision
//! Surfaces". Numbers in brackets are the paper's equations.
//!
//! [`hollow_out`] is the table of contents:
//!
//! ```text
//! cage (sharp) -> refine -> limit (corner, dart, patch, ring) -> crust -> grid -> solid
//!                             └──────────── fold, closest ────────────┘
//! ```
//!
//! * [`Cage`]: the checked control mesh, with [`Tags`]: creases, corners, holes.
//! * [`refine()`]: one step (2.1).
//! * [`LimitSurface`]: point and derivatives at any (u, v), corners by (2.2)
//!   and (2.3).
//! * [`Crust`]: the offset (3.2), and the interpolating surface (2.5).
//! * [`Grid`]: samples, shared between faces. [`Hollow`]: the closed mesh.
//! * [`fold_free`], and [`Trial`]: what (4.2) and the Jacobian say of a level.
//!
//! # What holds of the paper
//!
//! Theorem 1 and (4.1) hold. The thickness is never more than asked for, but
//! on coarse meshes it is much less between the corners; it comes nearer with
//! every level. Folds go the other way: at level 0 or 1 the crust takes more
//! thickness than direct offsetting before it folds, at fine levels only 8/15
//! of it, as its weight rises with a slope of 15/8. So a thickness may have no
//! level that is both true and free of folds, and [`hollow_out`] then says so.

mod cage;
mod closest;
mod contour;
mod corner;
mod crust;
mod dart;
mod error;
mod fold;
mod grid;
mod limit;
mod outward;
mod patch;
mod refine;
mod ring;
mod sharp;
#[cfg(test)]
mod sharp_tests;
mod solid;
#[cfg(test)]
mod tests;
mod warning;

use glam::DVec3;

pub use cage::{Cage, Polygon};
pub use contour::{ContourError, ContourSettings, ContourSolid, contour, contour_until};
pub use crust::{Crust, Scheme};
pub use error::{CageError, SubdivideError};
pub use fold::{FoldFree, fold_free};
use grid::Laid;
pub use grid::{Grid, MOST_POINTS, Samples};
pub use limit::{Face, LimitSurface, MOST_SAMPLES};
pub use patch::Jet;
pub use refine::{Boundary, Quads, refine};
pub use sharp::{INFINITELY_SHARP, Tags};
pub use solid::{Hollow, folded};

use crate::mesh::{FaceId, Frame, TriMesh, self_intersections};

/// Samples of a shell up to which a level is tried for `--tolerance`.
const MOST_TRIED: usize = 2_000_000;

/// Most Catmull-Clark steps.
pub const MOST_LEVELS: u32 = 12;

/// On which level the crust lies. Levels count all steps before it, from the
/// control mesh as given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Level {
    /// This one; or 1 when a mesh with other polygons than quadrilaterals
    /// forces a first step.
    Fixed(u32),
    /// The first whose thickness is nowhere short by more than this length
    /// and that has no fold.
    Tolerance(f64),
}

/// What to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Wall thickness in units of the control mesh; [`Tags::shares`] may vary it.
    pub thickness: f64,
    /// Steps along a side of a face.
    pub samples: usize,
    /// Level of the crust.
    pub level: Level,
    /// Crust or direct.
    pub scheme: Scheme,
    /// Rule for open meshes.
    pub boundary: Boundary,
}

/// Figures of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Steps before the crust.
    pub level: u32,
    /// By how much the wall is thinner than asked for, at most: epsilon of
    /// (4.2), at the samples.
    pub epsilon: f64,
    /// Thickness without a local fold: crust, direct.
    pub fold_free: [FoldFree; 2],
}

impl Trial {
    /// The fold-free thickness of a scheme.
    pub fn fold_free(&self, scheme: Scheme) -> FoldFree {
        self.fold_free[match scheme {
            Scheme::Crust => 0,
            Scheme::Direct => 1,
        }]
    }

    fn leave(&mut self, frame: Frame) {
        frame.leave(self.fold_free.iter_mut().map(|free| &mut free.at));
    }
}

fn tried(trials: &[Trial], scheme: Scheme) -> String {
    let each = trials.iter().map(|trial| {
        let Trial { level, epsilon, .. } = trial;
        let free = trial.fold_free(scheme).thickness;
        format!("level {level} is short by {epsilon:.4} and folds beyond {free:.4}")
    });
    each.collect::<Vec<_>>().join("; ")
}

/// A hollow solid and what is to be said of it.
#[derive(Clone, Debug)]
pub struct HollowSolid {
    /// The closed mesh.
    pub hollow: Hollow,
    /// Its samples.
    pub samples: Samples,
    /// Distance of every inner sample to the limit surface.
    pub thickness: Vec<f64>,
    /// Figures of the level taken.
    pub trial: Trial,
    /// Figures of all levels looked at, the taken one last.
    pub trials: Vec<Trial>,
    /// Steps that polygons and semi-sharp edges or vertices ask for.
    pub forced: u32,
    /// Faces of the control mesh at that level.
    pub faces: usize,
    /// Faces there with several extraordinary vertices.
    pub crowded_faces: usize,
    /// Vertices there whose normal is an average of neighbours'.
    pub averaged_normals: usize,
    /// Least length of the crust against the thickness, over the samples: (4.1)
    /// bounds it from above by 1, nothing from below.
    pub crust_length: [f64; 2],
    /// Triangles of the inner shell that look the wrong way.
    pub folded: Vec<FaceId>,
    /// Pairs of triangles that cut or touch each other.
    pub intersections: Vec<(FaceId, FaceId)>,
}

impl HollowSolid {
    fn leave(&mut self, frame: Frame) {
        frame.leave(&mut self.hollow.mesh.positions);
        frame.leave(&mut self.samples.outer);
        frame.leave(&mut self.samples.inner);
        self.trial.leave(frame);
        self.trials.iter_mut().for_each(|trial| trial.leave(frame));
    }
}

/// A level with its surface.
struct Layer {
    surface: LimitSurface,
    laid: Laid,
    thickness: Vec<f64>,
    trial: Trial,
}

/// Makes a hollow solid of a control mesh.
///
/// `progress` gets the name of each stage.
///
/// ```
/// use midsurf::intake::ControlInput;
/// use midsurf::subdivide::{Boundary, Level, Scheme, Settings, hollow_out};
///
/// let control = ControlInput::read("fixtures/cages/cube.obj".as_ref(), None, &[])?;
/// let settings = Settings {
///     thickness: 0.01 * control.cage.diagonal(),
///     samples: 4,
///     level: Level::Fixed(1),
///     scheme: Scheme::Crust,
///     boundary: Boundary::EdgeAndCorner,
/// };
/// let solid = hollow_out(&control.cage, &settings, &|_stage| ())?;
/// assert!(solid.folded.is_empty() && solid.intersections.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`SubdivideError`].
pub fn hollow_out(
    cage: &Cage,
    settings: &Settings,
    progress: &dyn Fn(&'static str),
) -> Result<HollowSolid, SubdivideError> {
    check_thickness(cage, settings.thickness)?;
    let frame = cage.frame();
    match hollow_out_locally(&cage.in_frame(frame), settings, progress) {
        Ok(mut solid) => {
            solid.leave(frame);
            Ok(solid)
        }
        Err(SubdivideError::NoLevel {
            thickness,
            tolerance,
            scheme,
            mut trials,
        }) => {
            trials.iter_mut().for_each(|trial| trial.leave(frame));
            Err(SubdivideError::NoLevel {
                thickness,
                tolerance,
                scheme,
                trials,
            })
        }
        other => other,
    }
}

fn hollow_out_locally(
    cage: &Cage,
    settings: &Settings,
    progress: &dyn Fn(&'static str),
) -> Result<HollowSolid, SubdivideError> {
    let forced = least_level(cage);
    let (layer, trials) = match settings.level {
        Level::Fixed(level) => {
            fits(cage, level, settings.samples)?;
            let (mesh, level) = refined(cage, level, settings.boundary)?;
            let layer = lay(mesh, level, settings, progress)?;
            let trial = layer.trial;
            (layer, vec![trial])
        }
        Level::Tolerance(tolerance) => choose(cage, tolerance, settings, progress)?,
    };
    progress("joining");
    let Layer {
        surface,
        laid,
        thickness,
        trial,
    } = layer;
    let hollow = Hollow::new(&laid);
    let folded = hollow.folded(&laid.samples);
    progress("crossing");
    let intersections = self_intersections(&hollow.mesh);
    Ok(HollowSolid {
        hollow,
        folded,
        intersections,
        crust_length: crust_length(&laid.samples, settings.thickness),
        faces: surface.face_count(),
        crowded_faces: surface.crowded_faces(),
        averaged_normals: surface.averaged().len(),
        samples: laid.samples,
        thickness,
        trial,
        trials,
        forced,
    })
}

/// The limit surface alone as triangles, closed where the mesh is. Also the
/// level, at least the one asked for, whose faces the samples divide.
///
/// [`contour()`] lays its wall on it.
///
/// # Errors
///
/// [`SubdivideError`].
pub fn tessellate(
    cage: &Cage,
    level: u32,
    samples: usize,
    boundary: Boundary,
) -> Result<(TriMesh, u32), SubdivideError> {
    sheet(cage, level, samples, boundary, |surface, grid| {
        let laid = grid.lay(surface, &Crust::offset(surface, 0.0), Scheme::Crust);
        (laid.samples.outer, laid.triangles)
    })
}

/// The surface through the control vertices, (2.5): one sheet, closed where
/// the mesh is. Also the level it lies on.
///
/// # Errors
///
/// [`SubdivideError`].
pub fn interpolate(
    cage: &Cage,
    level: u32,
    samples: usize,
    boundary: Boundary,
) -> Result<(TriMesh, u32), SubdivideError> {
    sheet(cage, level, samples, boundary, |surface, grid| {
        let laid = grid.lay(surface, &Crust::interpolating(surface), Scheme::Crust);
        (laid.samples.inner, laid.triangles)
    })
}

/// One sheet of triangles over the limit surface after some steps, through the
/// points that `lay` gives for its samples; and how many steps those are.
fn sheet(
    cage: &Cage,
    level: u32,
    samples: usize,
    boundary: Boundary,
    lay: impl Fn(&LimitSurface, &Grid) -> (Vec<DVec3>, Vec<[u32; 3]>),
) -> Result<(TriMesh, u32), SubdivideError> {
    fits(cage, level, samples)?;
    let frame = cage.frame();
    let (mesh, level) = refined(&cage.in_frame(frame), level, boundary)?;
    let surface = LimitSurface::new(mesh, boundary)?;
    let grid = grid(&surface, samples)?;
    let (mut positions, triangles) = lay(&surface, &grid);
    frame.leave(&mut positions);
    let mesh = TriMesh {
        positions,
        triangles,
    };
    Ok((mesh, level))
}

/// The least steps that make a mesh quadrilaterals whose sharpness is gone or
/// endless.
fn least_level(cage: &Cage) -> u32 {
    cage.steps_to_sharp().max(u32::from(!cage.is_quads()))
}

/// The mesh after some steps, at least as many as are needed; and how many
/// those are.
fn refined(cage: &Cage, level: u32, boundary: Boundary) -> Result<(Quads, u32), SubdivideError> {
    let cage = match boundary {
        Boundary::None => cage.without_rim()?,
        _ => cage.clone(),
    };
    let level = level.max(least_level(&cage));
    let (mut mesh, mut done) = match Quads::new(cage.clone()) {
        Some(mesh) => (mesh, 0),
        None => (refine(&cage, boundary)?, 1),
    };
    while done < level {
        mesh = refine(mesh.cage(), boundary)?;
        done += 1;
    }
    Ok((mesh, done))
}

/// Most thickness, over the diagonal of the control mesh: far beyond any use,
/// and near enough that all figures stay finite.
const MOST_THICKNESS: f64 = 1e6;

fn check_thickness(cage: &Cage, thickness: f64) -> Result<(), SubdivideError> {
    if !(thickness > 0.0 && thickness.is_finite()) {
        return Err(SubdivideError::Thickness(thickness));
    }
    let diagonal = cage.diagonal();
    // A mesh without size has no normals, which is told where they are asked for.
    if diagonal > 0.0 && thickness > MOST_THICKNESS * diagonal {
        return Err(SubdivideError::Thick {
            thickness,
            diagonal,
        });
    }
    Ok(())
}

/// Bytes that a sample takes at the peak, measured; for memory bounds.
const BYTES_PER_POINT: f64 = 1300.0;

/// Bytes that a face of the subdivided mesh takes besides.
const BYTES_PER_FACE: f64 = 400.0;

/// Faces after so many steps, or those that are needed. A step makes a face of
/// every corner.
fn faces_at(cage: &Cage, level: u32) -> usize {
    match level.max(least_level(cage)) {
        0 => cage.face_count(),
        level => cage
            .corner_count()
            .saturating_mul(4_usize.saturating_pow(level - 1)),
    }
}

/// Level of the surface when one is asked for, and steps along a side of a face
/// there that are about as fine as `samples` at the level asked for.
pub fn level_and_samples(cage: &Cage, level: u32, samples: usize) -> (u32, usize) {
    let taken = level.max(least_level(cage));
    let finer = (taken - level).min(usize::BITS - 1);
    (taken, (samples >> finer).max(1))
}

/// Refuses samples that would take more than so many bytes. A tolerance looks at
/// finer levels only while those are small.
///
/// # Errors
///
/// [`SubdivideError::Memory`], with the samples that would fit.
pub fn check_memory(
    cage: &Cage,
    level: u32,
    samples: usize,
    allowed: u64,
) -> Result<(), SubdivideError> {
    let faces = faces_at(cage, level) as f64;
    let needed = faces * (BYTES_PER_FACE + BYTES_PER_POINT * (samples as f64).powi(2));
    let allowed = allowed as f64;
    if needed <= allowed {
        return Ok(());
    }
    let fits = ((allowed / faces - BYTES_PER_FACE) / BYTES_PER_POINT).max(0.0);
    Err(SubdivideError::Memory {
        samples,
        level,
        needed: needed / 1e9,
        allowed: allowed / 1e9,
        fit: fits.sqrt() as usize,
    })
}

/// Refuses what would be too many points before any memory is spent on them.
fn fits(cage: &Cage, level: u32, samples: usize) -> Result<(), SubdivideError> {
    if level > MOST_LEVELS {
        return Err(SubdivideError::Levels(level));
    }
    let faces = faces_at(cage, level);
    let points = faces.saturating_mul(samples.saturating_mul(samples));
    if points > MOST_POINTS {
        return Err(SubdivideError::Samples { samples, faces });
    }
    Ok(())
}

fn grid(surface: &LimitSurface, samples: usize) -> Result<Grid, SubdivideError> {
    let faces = surface.face_count();
    Grid::new(surface, samples).ok_or(SubdivideError::Samples { samples, faces })
}

/// Lays the crust on a mesh, and measures.
fn lay(
    mesh: Quads,
    level: u32,
    settings: &Settings,
    progress: &dyn Fn(&'static str),
) -> Result<Layer, SubdivideError> {
    progress("surface");
    let surface = LimitSurface::new(mesh, settings.boundary)?;
    if let Some(&vertex) = surface.without_normal().first() {
        let vertex = vertex as usize;
        return Err(SubdivideError::NoNormal { vertex, level });
    }
    let grid = grid(&surface, settings.samples)?;
    let crust = Crust::offset(&surface, settings.thickness);
    let laid = grid.lay(&surface, &crust, settings.scheme);
    progress("measuring");
    let thickness = closest::thickness(&surface, &grid, &laid);
    let shares = laid.shares.iter().copied().chain(std::iter::repeat(1.0));
    let short = |(&found, share): (&f64, f64)| settings.thickness * share - found;
    let epsilon = thickness.iter().zip(shares).map(short);
    let epsilon = epsilon.fold(f64::NEG_INFINITY, f64::max);
    progress("folds");
    let trial = Trial {
        level,
        epsilon,
        fold_free: fold_free(&surface),
    };
    Ok(Layer {
        surface,
        laid,
        thickness,
        trial,
    })
}

/// The first level within the tolerance and free of folds.
fn choose(
    cage: &Cage,
    tolerance: f64,
    settings: &Settings,
    progress: &dyn Fn(&'static str),
) -> Result<(Layer, Vec<Trial>), SubdivideError> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(SubdivideError::Tolerance(tolerance));
    }
    let mut trials = Vec::new();
    let (mut mesh, mut level) = refined(cage, 0, settings.boundary)?;
    loop {
        let layer = lay(mesh, level, settings, progress)?;
        trials.push(layer.trial);
        let free = layer.trial.fold_free(settings.scheme).thickness;
        if layer.trial.epsilon <= tolerance && settings.thickness < free {
            return Ok((layer, trials));
        }
        // Folds come earlier with every level, so once they are there and do
        // not recede they stay.
        let before = trials.iter().rev().nth(1);
        let stays = |before: &Trial| before.fold_free(settings.scheme).thickness >= free;
        let hopeless = settings.thickness >= free && before.is_some_and(stays);
        let finer = 4 * layer.surface.face_count();
        let points = finer.saturating_mul(settings.samples * settings.samples);
        if hopeless || points > MOST_TRIED || level == MOST_LEVELS {
            return Err(SubdivideError::NoLevel {
                thickness: settings.thickness,
                tolerance,
                scheme: settings.scheme,
                trials,
            });
        }
        mesh = refine(layer.surface.mesh().cage(), settings.boundary)?;
        level += 1;
    }
}

/// Least and greatest distance between paired samples, in thicknesses.
fn crust_length(samples: &Samples, thickness: f64) -> [f64; 2] {
    let lengths = samples.outer.iter().zip(&samples.inner);
    lengths.fold([f64::INFINITY, 0.0], |[least, most], (p, q)| {
        let length = p.distance(*q) / thickness;
        [least.min(length), f64::max(most, length)]
    })
}
