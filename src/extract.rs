//! The extraction, stage by stage; this file is its table of contents.

use std::time::Instant;

use glam::DVec3;
use miette::Diagnostic;
use serde::Serialize;
use thiserror::Error;

use crate::check::closed_over::{ClosedOver, closed_over};
use crate::field::Field;
use crate::lattice::{Lattice, TetKey};
use crate::mesh::{FaceId, Frame, Part};
use crate::reshape::crease::mark_creases;
use crate::reshape::project::Projector;
use crate::reshape::remesh::{self, Meshed, remesh};
use crate::reshape::uncut::without_cuts;
use crate::reshape::{self, ElementSettings, TooManyElements, clean};
use crate::settings::cell::{BadCell, CellSize, Scale};
use crate::settings::memory::{MEMORY_LIMIT, TooFine};
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::surface::MidSurface;
use crate::surface::build::build;
use crate::surface::graph::SheetGraph;
use crate::surface::marked::MarkedMesh;
use crate::trace::feet;
use crate::trace::walk::{Counts, Tracer, block_bits};
use crate::walls::thickness::{ThicknessProfile, spread};
use crate::walls::{Separation, Walls};

/// What to extract and how finely.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Cell size; by default the median wall thickness.
    pub cell: CellSize,
    /// Smallest object angle of a sheet, degrees: weaker ones fade out.
    pub min_angle: f64,
    /// Keep the sheets that run into convex edges.
    pub keep_fins: bool,
    /// Most memory to take, bytes: blocks of the lattice are made as small as
    /// it asks, and a cell of which the result would not fit is refused.
    pub memory_limit: u64,
    /// Elements wanted; none for the mesh as it is traced.
    pub elements: Option<ElementSettings>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            cell: CellSize::Auto,
            min_angle: DEFAULT_ANGLE,
            keep_fins: false,
            memory_limit: MEMORY_LIMIT,
            elements: None,
        }
    }
}

/// Default of [`Settings::min_angle`]: below the object angle of a web a
/// quarter as thick as its flange (28 degrees), above what single-precision
/// input makes of a flat wall.
pub const DEFAULT_ANGLE: f64 = 15.0;

/// Bytes that an active cell of the result takes at the peak, which is in
/// cleaning: 2,000 measured for each further cell, between 24,000 and 378,000.
const BYTES_PER_CELL: f64 = 2_200.0;

/// Why nothing could be extracted.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum ExtractError {
    /// The cell size is no length.
    #[error(transparent)]
    #[diagnostic(transparent)]
    BadCell(BadCell),
    /// No wall of the part faces another.
    #[error(
        "no wall faces another wall: the wall thickness is unknown; give a cell size, and check the coping tags"
    )]
    #[diagnostic(help("`midsurf tags PART TAGS` shows what is tagged; --cell takes a length"))]
    NoThickness,
    /// The lattice would not fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    TooFine(#[from] TooFine),
    /// The elements would not fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    TooManyElements(#[from] TooManyElements),
    /// It was asked to stop; see [`extract_until`].
    #[error("stopped on request")]
    #[diagnostic(help("start again"))]
    Stopped,
}

impl From<Stopped> for ExtractError {
    fn from(_: Stopped) -> ExtractError {
        ExtractError::Stopped
    }
}

/// Seconds by stage and counts of work.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Work {
    /// Cell size used, part units.
    pub cell: f64,
    /// What the lattice walk took.
    #[serde(flatten)]
    pub counts: Counts,
    /// Building the field.
    pub field_seconds: f64,
    /// Following the mid-surface.
    pub trace_seconds: f64,
    /// Assembly, creases, clean-up and sheet graph.
    pub mesh_seconds: f64,
    /// Remeshing to an element size.
    pub remesh_seconds: f64,
    /// What remeshing did.
    pub edits: remesh::Edits,
}

/// The result of an extraction.
#[derive(Clone, Debug)]
pub struct Extraction {
    /// The mesh.
    pub surface: MidSurface,
    /// Sheets, seams, borders and junctions.
    pub graph: SheetGraph,
    /// Pairs of triangles that make quadrilaterals; see [`Meshed::quads`].
    pub quads: Vec<[u32; 2]>,
    /// Middles of edges of a remeshed surface; see [`Meshed::middles`].
    pub middles: Vec<([u32; 2], DVec3)>,
    /// The solid that was extracted from, where bodies of the part overlapped or
    /// touched and were made one first.
    pub solid: Option<Part>,
    /// Coping faces that no border reached: features closed over.
    pub closed_over: Vec<ClosedOver>,
    /// What it took.
    pub work: Work,
}

/// Extracts the mid-surface of a part.
///
/// Deterministic: the same part and settings give the same result, bit for
/// bit, on any number of threads.
///
/// ```
/// use midsurf::intake::{CopingSource, Input, Reading};
/// use midsurf::{Settings, extract};
///
/// let tags = CopingSource::File("fixtures/tee.coping.txt".into());
/// let input = Input::read("fixtures/tee.obj".as_ref(), &tags, &Reading::default(), false)?;
/// let result = extract(&input.part, &Settings::default(), &|_stage, _done, _expected| ())?;
/// assert_eq!(result.surface.sheet_count(), 3);
/// assert!(result.graph.cracks().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn extract(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
) -> Result<Extraction, ExtractError> {
    extract_until(part, settings, progress, &Stop::default())
}

/// As [`extract`], but ends early when asked to.
pub fn extract_until(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
    stop: &Stop,
) -> Result<Extraction, ExtractError> {
    with_scene(part, settings, progress, |scene| {
        stop.heed()?;
        let start = Instant::now();
        let mut tracer = Tracer::new(
            scene.walls,
            scene.lattice,
            block_bits(settings.memory_limit),
        );
        tracer.run(progress, stop)?;
        let counts = tracer.counts();
        let mesh = tracer.assemble();
        tracing::info!(
            cells = counts.cells,
            queries = counts.queries,
            triangles = mesh.triangles.len(),
            lost = counts.lost,
            matched = counts.matched,
            torn = counts.torn,
            "traced"
        );
        let trace_seconds = start.elapsed().as_secs_f64();
        finish(&scene, mesh, counts, trace_seconds, progress, stop)
    })
}

/// A part with all that the stages after the field ask.
pub(crate) struct Scene<'s> {
    /// The solid that is extracted from, where it is not the part given.
    solid: Option<&'s Part>,
    /// The solid in the part's own coordinates.
    whole: &'s Part,
    /// The solid near the origin.
    part: &'s Part,
    frame: Frame,
    pub(crate) field: &'s Field,
    pub(crate) walls: &'s Walls<'s>,
    profile: &'s ThicknessProfile,
    /// Cells of the length asked for.
    pub(crate) lattice: Lattice,
    settings: &'s Settings,
    field_seconds: f64,
}

impl Scene<'_> {
    /// Tetrahedra at points spread over the walls.
    pub(crate) fn wall_points(&self) -> Vec<TetKey> {
        let spacing = (self.part.area() / WALL_POINTS).sqrt();
        let walls = (0..self.field.face_count() as u32).map(FaceId);
        (walls.filter(|&f| !self.field.is_coping(f)))
            .flat_map(|f| spread(self.field.corners(f), spacing, usize::MAX))
            .map(|p| self.lattice.locate(p))
            .collect()
    }
}

/// Points by which a part is cut in shards, about, besides one a triangle.
const WALL_POINTS: f64 = 100_000.0;

/// Sets a part up for the walk and what follows it.
pub(crate) fn with_scene<R, E: From<ExtractError>>(
    part: &Part,
    settings: &Settings,
    progress: &Progress,
    go: impl FnOnce(Scene) -> Result<R, E>,
) -> Result<R, E> {
    let start = Instant::now();
    progress("field", 0, 0);
    let solid = part.bodies_meet().then(|| part.united().ok()).flatten();
    let whole = solid.as_ref().unwrap_or(part);
    let frame = Frame::around(&whole.bounds());
    let part = &*whole.in_frame(frame);
    let field = Field::new(part);
    let profile = ThicknessProfile::measure(&field, 2000);
    let cell = cell_size(part, &profile, settings)?;
    let walls = Walls::new(part, &field, separation(settings));
    let lattice = lattice(part, &field, &profile, cell, settings)?;
    tracing::info!(cell, thickness = profile.percentile(50.0), "field built");
    go(Scene {
        solid: solid.as_ref(),
        whole,
        part,
        frame,
        field: &field,
        walls: &walls,
        profile: &profile,
        lattice,
        settings,
        field_seconds: start.elapsed().as_secs_f64(),
    })
}

/// From the traced mesh to the result.
pub(crate) fn finish(
    scene: &Scene,
    mesh: MarkedMesh,
    counts: Counts,
    trace_seconds: f64,
    progress: &Progress,
    stop: &Stop,
) -> Result<Extraction, ExtractError> {
    let &Scene {
        part,
        frame,
        field,
        walls,
        profile,
        settings,
        ..
    } = scene;
    let cell = scene.lattice.cell();
    let start = Instant::now();
    stop.heed()?;
    progress("mesh", 0, 0);
    let projector = Projector::new(walls);
    // Creases last: to clean once more would let lines drift further.
    let traced = without_cuts(mesh, |mesh, kept| {
        let cleaned = clean::clean_on(mesh, cell, field, kept);
        mark_creases(cleaned, &projector, kept)
    });
    tracing::info!(
        triangles = traced.triangles.len(),
        "cleaned, creases marked"
    );
    stop.heed()?;
    let mesh_seconds = start.elapsed().as_secs_f64();

    let meshed = match element_settings(part, profile, settings)? {
        Some(wanted) => {
            progress("remesh", 0, 0);
            reshape::fits(traced.plain().area(), wanted.size, settings.memory_limit)?;
            let meshed = remesh(&traced, &projector, &wanted);
            tracing::info!(
                triangles = meshed.mesh.triangles.len(),
                quads = meshed.quads.len(),
                chords = meshed.edits.chords,
                "remeshed"
            );
            meshed
        }
        None => Meshed {
            mesh: traced,
            ..Meshed::default()
        },
    };
    stop.heed()?;
    let remesh_seconds = start.elapsed().as_secs_f64() - mesh_seconds;
    let Meshed {
        mesh,
        quads,
        mut middles,
        balls: carried,
        edits,
    } = meshed;
    let mut balls = feet::balls(&mesh, field);
    for (v, ball) in carried {
        balls[v as usize] = ball;
    }
    let mut surface = build(&mesh, balls);
    surface.leave(frame);
    frame.leave(middles.iter_mut().map(|m| &mut m.1));
    let graph = SheetGraph::of(&surface);
    let closed_over = closed_over(scene.whole, &surface, cell);

    let work = Work {
        cell,
        field_seconds: scene.field_seconds,
        trace_seconds,
        mesh_seconds: start.elapsed().as_secs_f64() - remesh_seconds,
        remesh_seconds,
        edits,
        counts,
    };
    Ok(Extraction {
        surface,
        graph,
        quads,
        middles,
        solid: scene.solid.cloned(),
        closed_over,
        work,
    })
}

pub(crate) fn separation(settings: &Settings) -> Separation {
    Separation::new(settings.min_angle, settings.keep_fins)
}

fn cell_size(
    part: &Part,
    profile: &ThicknessProfile,
    settings: &Settings,
) -> Result<f64, ExtractError> {
    let scale = scale(part, profile);
    settings.cell.resolve(&scale).map_err(bad_size)
}

fn element_settings(
    part: &Part,
    profile: &ThicknessProfile,
    settings: &Settings,
) -> Result<Option<remesh::Settings>, ExtractError> {
    let scale = scale(part, profile);
    let wanted = settings.elements.map(|e| e.resolve(&scale));
    wanted.transpose().map_err(bad_size)
}

fn scale(part: &Part, profile: &ThicknessProfile) -> Scale {
    let median = profile.percentile(50.0);
    Scale {
        auto: median,
        thickness: median,
        diagonal: part.bounds().diagonal(),
    }
}

fn bad_size(error: BadCell) -> ExtractError {
    match error {
        BadCell::NoThickness => ExtractError::NoThickness,
        error => ExtractError::BadCell(error),
    }
}

/// Cells that the mid-surface of a part will cross, about: it has half the area
/// of the walls, and crosses some 1.6 cells for each face of a cell that it covers.
pub fn expected_cells(part: &Part, thickness: f64, cell: f64) -> f64 {
    let area = (part.volume().abs() / thickness).min(part.area()).max(0.0);
    1.6 * area / (cell * cell)
}

/// Places the lattice, after an estimate of what it will take.
fn lattice(
    part: &Part,
    field: &Field,
    profile: &ThicknessProfile,
    cell: f64,
    settings: &Settings,
) -> Result<Lattice, ExtractError> {
    let thickness = profile.percentile(50.0).unwrap_or(part.bounds().diagonal());
    let cells = expected_cells(part, thickness, cell);
    let bytes = cells * BYTES_PER_CELL;
    let (low, high) = field.bounds();
    let fits = bytes <= settings.memory_limit as f64;
    match Lattice::covering(low, high, cell).filter(|_| fits) {
        Some(lattice) => Ok(lattice),
        None => {
            // Cells go with the inverse square of their size.
            let by_memory = cell * (bytes / settings.memory_limit as f64).sqrt();
            let by_keys =
                (high - low).max_element() / (crate::lattice::MAX_CELLS_PER_AXIS as f64 - 8.0);
            Err(ExtractError::TooFine(TooFine {
                cell,
                cells,
                gigabytes: bytes / 1e9,
                smallest: by_memory.max(by_keys) * 1.01,
            }))
        }
    }
}
