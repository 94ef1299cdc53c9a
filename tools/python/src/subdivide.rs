//! The verb that makes hollow solids of control meshes.

use std::path::{Path, PathBuf};

use glam::DVec3;
use midsurf::intake::ControlInput;
use midsurf::offset::OffsetError;
use midsurf::settings::cell::CellSize;
use midsurf::subdivide::{
    Boundary, Cage, ContourError, ContourSettings, Level, Polygon, Scheme, SubdivideError,
    check_memory, contour_until, hollow_out, level_and_samples,
};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::points_in;
use crate::fault::Fault;
use crate::given;
use crate::run::run;
use crate::solids::{Made, Solid, out, precision};

/// A control mesh: a file, or vertices and the corners of every face.
#[derive(FromPyObject)]
pub(crate) enum Control<'py> {
    /// A file.
    File(PathBuf),
    /// Vertices, and the corners of every face.
    Faces(PyReadonlyArray2<'py, f64>, Vec<Vec<u32>>),
}

/// Arguments of `subdivide` that remedies may name.
const SUBDIVIDE: [&str; 9] = [
    "thickness",
    "groups",
    "samples",
    "levels",
    "tolerance",
    "scheme",
    "boundary",
    "cell",
    "memory_limit",
];

/// A scheme, or none for the contour.
fn scheme(name: &str) -> Result<Option<Scheme>, Fault> {
    match name {
        "crust" => Ok(Some(Scheme::Crust)),
        "direct" => Ok(Some(Scheme::Direct)),
        "contour" => Ok(None),
        _ => {
            let words = "expected \"crust\", \"direct\" or \"contour\"";
            Err(Fault::argument("scheme", words))
        }
    }
}

/// A rule for boundaries.
fn rule(name: &str) -> Result<Boundary, Fault> {
    match name {
        "corner" => Ok(Boundary::EdgeAndCorner),
        "edge" => Ok(Boundary::EdgeOnly),
        "none" => Ok(Boundary::None),
        _ => {
            let words = "expected \"corner\", \"edge\" or \"none\"";
            Err(Fault::argument("boundary", words))
        }
    }
}

/// Steps along a side of a face where none are asked for.
const SAMPLES: usize = 8;

/// Makes a hollow solid of a control mesh.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn subdivide<'py>(
    py: Python<'py>,
    control: Control<'py>,
    thickness: f64,
    samples: Option<usize>,
    levels: Option<u32>,
    tolerance: Option<f64>,
    named: &str,
    boundary: Option<&str>,
    groups: Vec<(String, f64)>,
    cell: &str,
    single: bool,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Solid<'py>> {
    let (name, control) = match control {
        Control::File(file) => (file.clone(), Origin::File(file)),
        Control::Faces(vertices, faces) => {
            let name = PathBuf::from("the control mesh given");
            (name, Origin::Faces(points_in(&vertices), faces))
        }
    };
    let told = || {
        let cell: CellSize = given::cell("cell", cell)?;
        let rule = boundary.map(rule).transpose()?;
        Ok((scheme(named)?, rule, cell, given::memory(memory_limit)?))
    };
    let (scheme, rule, cell, allowed) = told().map_err(|fault: Fault| fault.raise(&SUBDIVIDE))?;
    let level = levels.unwrap_or(1);
    let made = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let ControlInput {
            cage,
            boundary,
            mut warnings,
            ..
        } = control.input(&name, thickness, &groups)?;
        let boundary = rule.unwrap_or(boundary);
        let samples = samples.unwrap_or_else(|| level_and_samples(&cage, level, SAMPLES).1);
        let refused = |error: SubdivideError| match error {
            SubdivideError::NoLevel { .. } => Fault::fruitless(&name, &error),
            error => Fault::refused(&name, &error),
        };
        check_memory(&cage, level, samples, allowed).map_err(refused)?;
        let Some(scheme) = scheme else {
            let settings = ContourSettings {
                thickness,
                samples,
                level,
                boundary,
                cell,
                precision: precision(single),
            };
            let solid =
                contour_until(&cage, &settings, show, stop).map_err(|error| match error {
                    ContourError::Surface(error) => refused(error),
                    ContourError::Offset(OffsetError::Empty(_)) => Fault::fruitless(&name, &error),
                    error => Fault::refused(&name, &error),
                })?;
            return Ok(Made {
                figures: json!({
                    "levels": solid.level,
                    "shell_triangles": solid.outer,
                    "intersections": solid.intersections.len(),
                }),
                mesh: solid.mesh,
                thickness: Some(solid.thickness),
                warnings,
            });
        };
        let settings = midsurf::subdivide::Settings {
            thickness,
            samples,
            level: tolerance.map_or(Level::Fixed(level), Level::Tolerance),
            scheme,
            boundary,
        };
        let stage = |stage| show(stage, 0, 0);
        let solid = hollow_out(&cage, &settings, &stage).map_err(refused)?;
        warnings.extend(solid.warnings(&settings));
        Ok(Made {
            figures: json!({
                "levels": solid.trial.level,
                "epsilon": solid.trial.epsilon,
                "shell_triangles": solid.hollow.shell,
                "folded_triangles": solid.folded.len(),
                "intersections": solid.intersections.len(),
            }),
            mesh: solid.hollow.mesh,
            thickness: Some([solid.thickness.as_slice(), &solid.thickness].concat()),
            warnings,
        })
    })?;
    out(py, made.map_err(|fault: Fault| fault.raise(&SUBDIVIDE))?)
}

/// A control mesh outside the interpreter's lock.
enum Origin {
    File(PathBuf),
    Faces(Vec<DVec3>, Vec<Vec<u32>>),
}

impl Origin {
    fn input(
        self,
        name: &Path,
        thickness: f64,
        groups: &[(String, f64)],
    ) -> Result<ControlInput, Fault> {
        match self {
            Origin::File(file) => {
                given::positive("thickness", thickness)?;
                ControlInput::read(&file, Some(thickness), groups).map_err(given::intake)
            }
            Origin::Faces(positions, faces) => {
                let faces: Vec<Polygon> = faces.into_iter().map(Polygon::from_vec).collect();
                let cage = Cage::new(positions, &faces);
                let cage = cage.map_err(|error| Fault::refused(name, &error))?;
                Ok(ControlInput::of(cage, name, Vec::new()))
            }
        }
    }
}
