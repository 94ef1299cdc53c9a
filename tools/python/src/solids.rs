//! The verbs that make solids.

use std::path::PathBuf;

use midsurf::extract;
use midsurf::intake::balls::{doubts, thickness_by_group};
use midsurf::intake::{CopingSource, read_warning};
use midsurf::io::read_surface;
use midsurf::io::write::{Shade, SolidFormat, stage_solid};
use midsurf::mesh::{Simplify, TriMesh};
use midsurf::offset::{Cut, Drain, OffsetError, Voids, hollowed, opened};
use midsurf::report::bodies::Bodies;
use midsurf::rethicken::{BallSurface, RethickenError};
use midsurf::roundtrip::RoundTripError;
use midsurf::settings::cell::Scale;
use midsurf::settings::precision::Precision;
use midsurf::settings::warning::Warning;
use midsurf::thicken::{Side, ThickenError};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::arrays::{Rows, mesh_in, mesh_out};
use crate::fault::{Fault, pairs};
use crate::given::{self, Preparing, Source, Tagged};
use crate::run::run;
use crate::surface::{Surface, commit, unwritten};

/// A solid before it goes out: its mesh, numbers at its vertices, figures,
/// warnings.
pub(crate) struct Made {
    pub(crate) mesh: TriMesh,
    pub(crate) thickness: Option<Vec<f64>>,
    pub(crate) figures: Value,
    pub(crate) warnings: Vec<Warning>,
}

/// The same in Python's hands.
pub(crate) type Solid<'py> = (
    Rows<'py, f64>,
    Rows<'py, u32>,
    Option<Bound<'py, PyArray1<f64>>>,
    String,
    Vec<(&'static str, String)>,
);

pub(crate) fn out(py: Python<'_>, made: Made) -> PyResult<Solid<'_>> {
    let (vertices, triangles) = mesh_out(py, made.mesh)?;
    let thickness = made.thickness.map(|all| PyArray1::from_vec(py, all));
    let (figures, warnings) = (made.figures.to_string(), pairs(&made.warnings));
    Ok((vertices, triangles, thickness, figures, warnings))
}

/// What `offset` and `hollow` are told alike: cell, tolerance, how to read,
/// whether to simplify, triangles wanted, whether to fill voids, single precision.
type Closed = (
    String,
    Option<f64>,
    Preparing,
    bool,
    Option<usize>,
    bool,
    bool,
);

/// Arguments of `offset` and `hollow` that remedies may name.
const CLOSED: [&str; 14] = [
    "distance",
    "thickness",
    "cell",
    "tolerance",
    "weld",
    "repair",
    "scale",
    "unit",
    "cad_sag",
    "solid",
    "simplify",
    "triangles",
    "voids",
    "memory_limit",
];

/// Grows or shrinks a closed part.
#[pyfunction]
pub(crate) fn offset<'py>(
    py: Python<'py>,
    part: Source,
    distance: f64,
    closed: Closed,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Solid<'py>> {
    closed_part(
        py,
        part,
        distance,
        closed,
        memory_limit,
        (threads, progress),
        None,
    )
}

/// Hollows a closed part out.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn hollow<'py>(
    py: Python<'py>,
    part: Source,
    thickness: f64,
    drains: Vec<String>,
    cuts: Vec<String>,
    closed: Closed,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Solid<'py>> {
    let openings = || -> Result<Openings, Fault> {
        given::positive("thickness", thickness)?;
        let drains: Result<_, Fault> = drains.iter().map(|d| given::parsed("drain", d)).collect();
        let cuts: Result<_, Fault> = cuts.iter().map(|c| given::parsed("open", c)).collect();
        Ok((drains?, cuts?))
    };
    let openings = openings().map_err(|fault| fault.raise(&CLOSED))?;
    let how = (threads, progress);
    closed_part(
        py,
        part,
        -thickness,
        closed,
        memory_limit,
        how,
        Some(openings),
    )
}

type Openings = (Vec<Drain>, Vec<Cut>);

fn closed_part<'py>(
    py: Python<'py>,
    part: Source,
    distance: f64,
    (cell, tolerance, preparing, simplify, triangles, fill, single): Closed,
    memory_limit: Option<&str>,
    (threads, progress): (Option<usize>, Option<Py<PyAny>>),
    openings: Option<Openings>,
) -> PyResult<Solid<'py>> {
    let name = part.name();
    let told = || {
        tolerance.map_or(Ok(0.0), |length| given::positive("tolerance", length))?;
        let reading = given::reading(preparing)?;
        Ok((
            given::cell("cell", &cell)?,
            given::memory(memory_limit)?,
            reading,
        ))
    };
    let (cell, memory_limit, reading) = told().map_err(|fault: Fault| fault.raise(&CLOSED))?;
    let precision = precision(single);
    let made = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let mut input = part.part(&CopingSource::None, &reading, false)?;
        // Tags have no meaning here, so none are missing.
        input.warnings.retain(|warning| warning.code != "no_coping");
        let usual = midsurf::offset::Settings::new(&input.part, distance);
        let scale = Scale {
            auto: Some(usual.cell),
            thickness: None,
            diagonal: input.part.bounds().diagonal(),
        };
        let tolerance = tolerance.unwrap_or(usual.tolerance);
        let settings = midsurf::offset::Settings {
            cell: cell.resolve(&scale).map_err(|e| Fault::input(&e))?,
            tolerance,
            simplify: (simplify || triangles.is_some()).then_some(Simplify {
                tolerance,
                triangles,
            }),
            memory_limit,
            voids: if fill { Voids::Fill } else { Voids::Keep },
            precision,
            ..usual
        };
        let result = midsurf::offset::offset_until(&input.part, &settings, show, stop);
        let mut result = result.map_err(|error| match error {
            OffsetError::Empty(_) => Fault::fruitless(&name, &error),
            _ => Fault::refused(&name, &error),
        })?;
        let mut warnings = input.warnings;
        warnings.extend(result.warnings.iter().map(|w| w.explained(distance)));
        let solid = result.solid.as_ref().unwrap_or(&input.part);
        let contour = std::mem::take(&mut result.mesh);
        let mesh = match &openings {
            None => contour,
            Some((drains, cuts)) => {
                let hollow = hollowed(solid, &contour);
                if drains.is_empty() && cuts.is_empty() {
                    hollow
                } else {
                    opened(&hollow, [solid.mesh(), &contour], drains, cuts, precision)
                        .map_err(|error| Fault::fruitless(&name, &error))?
                }
            }
        };
        let bodies = Bodies::of(&mesh, openings.is_some());
        warnings.extend(bodies.warnings(&result.voids, solid));
        Ok(Made {
            figures: json!({
                "cell": settings.cell,
                "simplified_within": result.simplified,
                "pieces": bodies.pieces,
                "cavities": bodies.cavities,
                "self_intersections": bodies.self_intersections,
                "non_manifold_edges": bodies.non_manifold_edges,
                "corner_deviation": result.corner_deviation,
                "centre_deviation": result.centre_deviation,
            }),
            mesh,
            thickness: None,
            warnings,
        })
    })?;
    out(py, made.map_err(|fault: Fault| fault.raise(&CLOSED))?)
}

pub(crate) fn precision(single: bool) -> Precision {
    if single {
        Precision::Single
    } else {
        Precision::Double
    }
}

/// Arguments of `thicken` that remedies may name.
const THICKEN: [&str; 5] = ["thickness", "side", "cell", "tolerance", "memory_limit"];

/// Makes a solid behind a surface.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn thicken<'py>(
    py: Python<'py>,
    surface: Source,
    thickness: f64,
    outer: bool,
    cell: &str,
    tolerance: Option<f64>,
    single: bool,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Solid<'py>> {
    let name = surface.name();
    let told = || {
        tolerance.map_or(Ok(0.0), |length| given::positive("tolerance", length))?;
        Ok((given::cell("cell", cell)?, given::memory(memory_limit)?))
    };
    let (cell, memory_limit) = told().map_err(|fault: Fault| fault.raise(&THICKEN))?;
    let made = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let (loaded, mut warnings) = surface.loaded()?;
        let side = if outer { Side::Outer } else { Side::Inner };
        let usual = midsurf::thicken::Settings::new(thickness, side).fitted(&loaded.mesh);
        let scale = Scale {
            auto: Some(usual.cell),
            thickness: Some(thickness),
            diagonal: loaded.mesh.bounds().diagonal(),
        };
        let settings = midsurf::thicken::Settings {
            cell: cell.resolve(&scale).map_err(|e| Fault::input(&e))?,
            tolerance: tolerance.unwrap_or(usual.tolerance),
            memory_limit,
            precision: precision(single),
            ..usual
        };
        let result = midsurf::thicken::thicken_until(&loaded.mesh, &settings, show, stop);
        let result = result.map_err(|error| match error {
            ThickenError::Unresolved { .. } => Fault::fruitless(&name, &error),
            _ => Fault::refused(&name, &error),
        })?;
        warnings.extend(result.warnings(&loaded.mesh, &settings));
        Ok(Made {
            figures: json!({
                "cell": result.cell,
                "patch_triangles": result.patch_triangles,
                "way": result.way,
                "shell_deviation": result.deviation,
                "missing": result.missing,
                "self_intersections": result.self_intersections,
                "bad_edges": result.bad_edges,
            }),
            mesh: result.mesh,
            thickness: None,
            warnings,
        })
    })?;
    out(py, made.map_err(|fault: Fault| fault.raise(&THICKEN))?)
}

/// What `rethicken` is given: a mid-surface, or a mesh with a thickness.
#[derive(FromPyObject)]
pub(crate) enum Shell<'py> {
    /// A mid-surface in memory.
    Mid(Bound<'py, Surface>),
    /// Arrays, and the thickness of every triangle.
    Arrays(
        PyReadonlyArray2<'py, f64>,
        PyReadonlyArray2<'py, u32>,
        PyReadonlyArray1<'py, f64>,
    ),
    /// A mesh file, one thickness, and those of groups.
    Mesh(PathBuf, f64, Vec<(String, f64)>),
    /// A file of a mid-surface, and a table of thickness instead of its own.
    File(PathBuf, Option<PathBuf>),
}

/// The same outside the interpreter's lock.
enum Thick {
    Surface(BallSurface),
    Arrays(TriMesh, Vec<f64>),
    Mesh(PathBuf, f64, Vec<(String, f64)>),
    File(PathBuf, Option<PathBuf>),
}

impl Thick {
    /// The surface with its balls, and what is said of it.
    fn balls(self, rounded: bool) -> Result<(BallSurface, Vec<Warning>), Fault> {
        let refused = |file: &PathBuf| {
            let file = file.clone();
            move |error: RethickenError| Fault::refused(&file, &error)
        };
        let (surface, warnings) = match self {
            Thick::Surface(surface) => (surface, Vec::new()),
            Thick::Arrays(mesh, thickness) => {
                let name = PathBuf::from("the mesh given");
                let surface = BallSurface::of_shell(&mesh, &thickness).map_err(refused(&name))?;
                (surface, Vec::new())
            }
            Thick::Mesh(file, length, groups) => {
                let (loaded, warnings) = Source::File(file.clone()).loaded()?;
                let thickness = thickness_by_group(&loaded, length, &groups)
                    .map_err(|error| Fault::refused(&file, &error))?;
                let surface = BallSurface::of_shell(&loaded.mesh, &thickness);
                (surface.map_err(refused(&file))?, warnings)
            }
            Thick::File(file, table) => {
                let loaded = read_surface(&file, table.as_deref()).map_err(|e| Fault::input(&e))?;
                let surface = BallSurface::of(&loaded.surface).map_err(refused(&file))?;
                let mut warnings: Vec<Warning> = (loaded.warnings.iter())
                    .map(|w| read_warning(&file, w))
                    .collect();
                warnings.extend(doubts(&file, &loaded, &surface, rounded));
                (surface, warnings)
            }
        };
        let surface = if rounded { surface.rounded() } else { surface };
        Ok((surface, warnings))
    }
}

/// Arguments of `rethicken` that remedies may name.
const RETHICKEN: [&str; 5] = ["thickness", "groups", "cell", "tolerance", "memory_limit"];

/// Thickens a mid-surface by its own thickness.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn rethicken<'py>(
    py: Python<'py>,
    shell: Shell<'py>,
    rounded: bool,
    cell: &str,
    tolerance: Option<f64>,
    single: bool,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Solid<'py>> {
    let name = PathBuf::from("the mid-surface");
    let thick = || {
        Ok(match shell {
            Shell::Mid(surface) => {
                let balls = BallSurface::of(surface.get().surface());
                Thick::Surface(balls.map_err(|error| Fault::refused(&name, &error))?)
            }
            Shell::Arrays(vertices, triangles, thickness) => Thick::Arrays(
                mesh_in(&vertices, &triangles),
                thickness.as_array().to_vec(),
            ),
            Shell::Mesh(file, length, groups) => {
                Thick::Mesh(file, given::positive("thickness", length)?, groups)
            }
            Shell::File(file, table) => Thick::File(file, table),
        })
    };
    let told = || {
        tolerance.map_or(Ok(0.0), |length| given::positive("tolerance", length))?;
        let memory = given::memory(memory_limit)?;
        Ok((thick()?, given::cell("cell", cell)?, memory))
    };
    let (thick, cell, memory_limit) = told().map_err(|fault: Fault| fault.raise(&RETHICKEN))?;
    let made = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let (surface, mut warnings) = thick.balls(rounded)?;
        let usual = midsurf::rethicken::Settings::new(&surface);
        let scale = Scale {
            auto: Some(usual.cell),
            thickness: Some(surface.median_thickness()),
            diagonal: surface.diagonal(),
        };
        let settings = midsurf::rethicken::Settings {
            cell: cell.resolve(&scale).map_err(|e| Fault::input(&e))?,
            tolerance: tolerance.unwrap_or(usual.tolerance),
            memory_limit,
            precision: precision(single),
        };
        let result = midsurf::rethicken::rethicken_until(&surface, &settings, show, stop);
        let result = result.map_err(|error| match error {
            RethickenError::Empty(_) => Fault::fruitless(&name, &error),
            _ => Fault::refused(&name, &error),
        })?;
        warnings.extend(result.warnings.iter().map(|w| w.explained()));
        Ok(Made {
            figures: json!({ "cell": settings.cell }),
            mesh: result.mesh,
            thickness: None,
            warnings,
        })
    })?;
    out(py, made.map_err(|fault: Fault| fault.raise(&RETHICKEN))?)
}

/// Arguments of `roundtrip` that remedies may name.
const ROUNDTRIP: [&str; 11] = [
    "coping",
    "cell",
    "angle",
    "solid_cell",
    "weld",
    "repair",
    "scale",
    "unit",
    "cad_sag",
    "solid",
    "memory_limit",
];

/// Extracts, thickens again, compares.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn roundtrip<'py>(
    py: Python<'py>,
    part: Source,
    coping: Tagged,
    cell: &str,
    angle: f64,
    solid_cell: &str,
    preparing: Preparing,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Surface, Solid<'py>, String)> {
    let name = part.name();
    let told = || {
        let memory_limit = given::memory(memory_limit)?;
        let settings = midsurf::roundtrip::Settings {
            extract: extract::Settings {
                cell: given::cell("cell", cell)?,
                min_angle: given::angle(angle)?,
                memory_limit,
                ..extract::Settings::default()
            },
            solid_cell: given::cell("solid_cell", solid_cell)?,
            memory_limit,
        };
        Ok((settings, given::reading(preparing)?))
    };
    let (settings, reading) = told().map_err(|fault: Fault| fault.raise(&ROUNDTRIP))?;
    let made = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let input = part.part(&coping.0, &reading, false)?;
        let result = midsurf::roundtrip::roundtrip_until(&input.part, &settings, show, stop);
        let result = result.map_err(|error| match error {
            RoundTripError::Rethicken(RethickenError::Empty(_)) => Fault::fruitless(&name, &error),
            _ => Fault::refused(&name, &error),
        })?;
        let solid = Made {
            figures: json!({ "cell": result.solid_settings.cell }),
            mesh: result.solid.mesh,
            thickness: None,
            warnings: result
                .solid
                .warnings
                .iter()
                .map(|w| w.explained())
                .collect(),
        };
        let comparison = json!(result.comparison).to_string();
        Ok((Surface::of(result.extraction, input), solid, comparison))
    })?;
    let (surface, solid, comparison) = made.map_err(|fault: Fault| fault.raise(&ROUNDTRIP))?;
    Ok((surface, out(py, solid)?, comparison))
}

/// Writes a mesh in the format of the file's suffix, with a number at every
/// vertex where the format holds one.
#[pyfunction]
pub(crate) fn save_solid(
    py: Python<'_>,
    file: PathBuf,
    vertices: PyReadonlyArray2<'_, f64>,
    triangles: PyReadonlyArray2<'_, u32>,
    thickness: Option<PyReadonlyArray1<'_, f64>>,
) -> PyResult<()> {
    let mesh = mesh_in(&vertices, &triangles);
    let values = thickness.map(|all| all.as_array().to_vec());
    let write = || {
        let shade = values.as_deref().map(|values| Shade {
            name: "thickness",
            values,
            normals: &[],
        });
        SolidFormat::of(&file).map_err(unwritten)?;
        commit(stage_solid(&mesh, shade, &file).map_err(unwritten)?)
    };
    py.detach(write).map_err(|fault: Fault| fault.raise(&[]))
}
