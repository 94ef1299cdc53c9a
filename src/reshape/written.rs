//! A mid-surface that was written before, remeshed to an element size.
//!
//! With its part, footpoints are found again and every vertex goes onto the
//! exact mid-surface, as in the extraction itself. Without, vertices stay on the
//! triangles and lines written, and thickness is linear over them: what was cut
//! off by the chords of the first mesh is then not found again.

use std::time::Instant;

use glam::DVec3;
use miette::Diagnostic;
use rayon::prelude::*;
use smallvec::SmallVec;
use thiserror::Error;

use super::facets::Facets;
use super::project::Projector;
use super::remesh::{Edits, Junctions, Meshed, remesh};
use super::{ElementSettings, TooManyElements};
use crate::field::Field;
use crate::mesh::{FaceId, Frame, Part};
use crate::settings::cell::{BadCell, Scale};
use crate::surface::build::build;
use crate::surface::graph::SheetGraph;
use crate::surface::marked::{MarkedMesh, MarkedVertex};
use crate::surface::thickness::Thickness;
use crate::surface::{Ball, BorderKind, MidSurface};
use crate::trace::feet;
use crate::walls::thickness::ThicknessProfile;
use crate::walls::{Separation, Walls};

/// Walls farther than the nearest by more than this share of the distance do
/// not tie: single precision is off by less.
const TIE: f64 = 1e-4;

/// Feet closer than this share of the distance are one place.
const SAME_PLACE: f64 = 1e-3;

/// How far from a vertex that is not exact the mid-surface is looked for, in
/// distances from the wall.
const REACH: f64 = 0.5;

/// How far outside the part a vertex may lie, in distances from the wall: those
/// on coping faces do by rounding, and by chords.
const OUTSIDE: f64 = 0.1;

/// How a written mid-surface is remeshed.
#[derive(Clone, Copy, Debug)]
pub struct WrittenSettings {
    /// Elements wanted.
    pub elements: ElementSettings,
    /// Smallest object angle of a sheet, degrees, as when it was extracted.
    pub min_angle: f64,
    /// Whether the surface holds fins.
    pub keep_fins: bool,
    /// Most memory that elements may take, bytes.
    pub memory_limit: u64,
}

/// A mid-surface of new elements.
#[derive(Clone, Debug)]
pub struct Remeshed {
    /// The mesh.
    pub surface: MidSurface,
    /// Sheets, seams, borders and junctions.
    pub graph: SheetGraph,
    /// Pairs of triangles that make quadrilaterals; see [`Meshed::quads`].
    pub quads: Vec<[u32; 2]>,
    /// Middles of edges; see [`Meshed::middles`].
    pub middles: Vec<([u32; 2], DVec3)>,
    /// Element size, part units.
    pub size: f64,
    /// What was done.
    pub edits: Edits,
    /// Seconds that it took.
    pub seconds: f64,
}

/// Why a written mid-surface was not remeshed.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum RemeshError {
    /// The element size is no length.
    #[error(transparent)]
    #[diagnostic(transparent)]
    BadSize(#[from] BadCell),
    /// The elements would not fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    TooMany(#[from] TooManyElements),
    /// Walls are carried on to where they meet, and there are none.
    #[error("straight junctions need the walls of the part")]
    #[diagnostic(help(
        "give the part with --part; without it junctions stay as they were written"
    ))]
    NoPart,
    /// Few vertices are in the middle of walls.
    #[error("only {found} of {count} vertices lie in the middle of walls of the part")]
    #[diagnostic(help(
        "give the part that the mid-surface belongs to; leave --part away otherwise"
    ))]
    Stranger {
        /// Vertices with two walls that tie, or nearly so.
        found: usize,
        /// All vertices.
        count: usize,
    },
}

/// Remeshes a written mid-surface, onto the exact one where its part is given.
///
/// # Errors
///
/// [`RemeshError`].
pub fn remesh_written(
    written: &MidSurface,
    part: Option<&Part>,
    settings: &WrittenSettings,
) -> Result<Remeshed, RemeshError> {
    let start = Instant::now();
    match part {
        Some(part) => {
            let solid = part.bodies_meet().then(|| part.united().ok()).flatten();
            let part = solid.as_ref().unwrap_or(part);
            on_part(written, part, settings, start)
        }
        None => on_itself(written, settings, start),
    }
}

fn on_part(
    written: &MidSurface,
    part: &Part,
    settings: &WrittenSettings,
    start: Instant,
) -> Result<Remeshed, RemeshError> {
    let frame = Frame::around(&part.bounds());
    let part = &*part.in_frame(frame);
    let field = Field::new(part);
    let walls = Walls::new(
        part,
        &field,
        Separation::new(settings.min_angle, settings.keep_fins),
    );
    let profile = ThicknessProfile::measure(&field, 2000);
    let wanted = wanted(
        written,
        settings,
        profile.percentile(50.0),
        part.bounds().diagonal(),
    )?;
    let projector = Projector::new(&walls);
    let mut mesh = MarkedMesh::of(written);
    frame.enter(mesh.vertices.iter_mut().map(|v| &mut v.at));
    let mut on_coping = vec![false; mesh.vertices.len()];
    for border in (written.borders().iter()).filter(|b| b.kind == BorderKind::Coping) {
        for &v in &border.path {
            on_coping[v as usize] = true;
        }
    }
    mesh.vertices = (mesh.vertices.into_par_iter().zip(on_coping))
        .map(|(vertex, coping)| tied(vertex.at, coping, &projector))
        .collect();
    let count = mesh.vertices.len();
    let found = (mesh.vertices.par_iter())
        .filter(|v| v.walls.len() > 1 && is_within(v.at, &field))
        .count();
    if 2 * found < count {
        return Err(RemeshError::Stranger { found, count });
    }
    let meshed = remesh(&mesh, &projector, &wanted);
    let balls = feet::balls(&meshed.mesh, &field);
    Ok(finish(meshed, balls, frame, wanted.size, start))
}

fn on_itself(
    written: &MidSurface,
    settings: &WrittenSettings,
    start: Instant,
) -> Result<Remeshed, RemeshError> {
    if settings.elements.junctions == Junctions::Straight {
        return Err(RemeshError::NoPart);
    }
    let thickness = Thickness::of(written).map(|t| t.p50);
    let diagonal = written.mesh().bounds().diagonal();
    let wanted = wanted(written, settings, thickness, diagonal)?;
    let facets = Facets::new(written);
    let mut mesh = MarkedMesh::of(written);
    mesh.vertices = facets.vertices();
    let meshed = remesh(&mesh, &facets, &wanted);
    let balls = (meshed.mesh.vertices.par_iter())
        .map(|v| facets.ball(v))
        .collect();
    Ok(finish(meshed, balls, Frame::default(), wanted.size, start))
}

/// The settings as lengths, if their elements fit.
fn wanted(
    written: &MidSurface,
    settings: &WrittenSettings,
    thickness: Option<f64>,
    diagonal: f64,
) -> Result<super::remesh::Settings, RemeshError> {
    let thickness = thickness.filter(|t| *t > 0.0);
    let wanted = settings.elements.resolve(&Scale {
        auto: thickness,
        thickness,
        diagonal,
    })?;
    super::fits(written.mesh().area(), wanted.size, settings.memory_limit)?;
    Ok(wanted)
}

/// A vertex with the walls that tie there. Where fewer than two do, it is not
/// exact, and goes to the point of the mid-surface near by.
fn tied(at: DVec3, on_coping: bool, projector: &Projector) -> MarkedVertex {
    let walls = projector.walls();
    let field = walls.field();
    let coping = on_coping
        .then(|| field.nearest_coping(at, f64::INFINITY))
        .flatten();
    let coping = coping.map(|foot| foot.face);
    let nearest = field.footpoint(at);
    let reach = (1.0 + TIE) * nearest.distance + walls.tolerances().tie;
    let mut feet = Vec::new();
    field.footpoints_within(at, reach, &mut feet);
    feet.sort_by(|p, q| p.distance.total_cmp(&q.distance).then(p.face.cmp(&q.face)));
    let mut places: SmallVec<[DVec3; 4]> = SmallVec::new();
    let mut tied: SmallVec<[FaceId; 4]> = SmallVec::new();
    for foot in feet {
        let apart = |p: &DVec3| p.distance(foot.point) > SAME_PLACE * nearest.distance;
        if places.iter().all(apart) {
            places.push(foot.point);
            tied.push(foot.face);
        }
    }
    if tied.len() < 2 {
        let found = projector.on_sheet(at, &[nearest.face], REACH * nearest.distance);
        if let Some(found) = found {
            return MarkedVertex { coping, ..found };
        }
    }
    MarkedVertex {
        at,
        walls: tied,
        coping,
    }
}

/// Whether a point lies inside the part, or hardly outside.
fn is_within(at: DVec3, field: &Field) -> bool {
    field.signed_clearance(at) >= -OUTSIDE * field.footpoint(at).distance
}

fn finish(
    meshed: Meshed,
    mut balls: Vec<Ball>,
    frame: Frame,
    size: f64,
    start: Instant,
) -> Remeshed {
    let Meshed {
        mesh,
        quads,
        mut middles,
        balls: carried,
        edits,
    } = meshed;
    for (v, ball) in carried {
        balls[v as usize] = ball;
    }
    let mut surface = build(&mesh, balls);
    surface.leave(frame);
    frame.leave(middles.iter_mut().map(|m| &mut m.1));
    let graph = SheetGraph::of(&surface);
    Remeshed {
        surface,
        graph,
        quads,
        middles,
        size,
        edits,
        seconds: start.elapsed().as_secs_f64(),
    }
}
