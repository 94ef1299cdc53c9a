//! The verbs that make mid-surfaces: of a part, a shard of one, all shards.

use std::path::Path;

use midsurf::extract::{Settings, extract_until};
use midsurf::reshape::ElementSettings;
use midsurf::reshape::remesh::Junctions;
use midsurf::shard::{Shard, ShardFileError, ShardOf};
use miette::Diagnostic;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::fault::Fault;
use crate::given::{self, Preparing, Source, Tagged};
use crate::run::run;
use crate::surface::Surface;

/// Arguments of [`extract`] that remedies may name.
const ARGUMENTS: [&str; 13] = [
    "cell",
    "coping",
    "allow_open",
    "weld",
    "repair",
    "scale",
    "unit",
    "cad_sag",
    "solid",
    "memory_limit",
    "angle",
    "keep_fins",
    "element_size",
];

/// Wanted elements: size, sag, grading, quads, and whether sheets run straight.
type Elements = (String, Option<String>, Option<f64>, bool, bool);

fn elements(wanted: Option<Elements>) -> Result<Option<ElementSettings>, Fault> {
    let Some((size, sag, grading, quads, straight)) = wanted else {
        return Ok(None);
    };
    let usual = ElementSettings::of_size(given::cell("element_size", &size)?);
    Ok(Some(ElementSettings {
        sag: match sag {
            Some(sag) => given::cell("sag", &sag)?,
            None => usual.sag,
        },
        grading: match grading {
            Some(grading) => given::positive("grading", grading)?,
            None => usual.grading,
        },
        quads,
        junctions: if straight {
            Junctions::Straight
        } else {
            Junctions::Medial
        },
        ..usual
    }))
}

/// What an extraction and each of its shards are told alike.
fn settings(
    cell: &str,
    angle: f64,
    keep_fins: bool,
    memory_limit: Option<&str>,
    elements: Option<ElementSettings>,
) -> Result<Settings, Fault> {
    Ok(Settings {
        cell: given::cell("cell", cell)?,
        min_angle: given::angle(angle)?,
        keep_fins,
        memory_limit: given::memory(memory_limit)?,
        elements,
    })
}

/// Extracts the mid-surface of a part.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn extract(
    py: Python<'_>,
    part: Source,
    coping: Tagged,
    cell: &str,
    angle: f64,
    keep_fins: bool,
    allow_open: bool,
    preparing: Preparing,
    wanted: Option<Elements>,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Surface> {
    let settings = || {
        let elements = elements(wanted)?;
        let settings = settings(cell, angle, keep_fins, memory_limit, elements)?;
        Ok((settings, given::reading(preparing)?))
    };
    let (settings, reading) = settings().map_err(|fault: Fault| fault.raise(&ARGUMENTS))?;
    run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let input = part.part(&coping.0, &reading, allow_open)?;
        let result = extract_until(&input.part, &settings, show, stop)
            .map_err(|error| Fault::refused(&input.file, &error))?;
        if result.surface.triangles().is_empty() {
            return Err(Fault::fruitless(&input.file, &NoSurface));
        }
        Ok(Surface::of(result, input))
    })?
    .map_err(|fault: Fault| fault.raise(&ARGUMENTS))
}

/// Computes one shard of an extraction: which, of how many, counted from 1; its
/// bytes.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn shard<'py>(
    py: Python<'py>,
    part: Source,
    which: (u32, u32),
    coping: Tagged,
    cell: &str,
    angle: f64,
    keep_fins: bool,
    allow_open: bool,
    preparing: Preparing,
    memory_limit: Option<&str>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let settings = || {
        let (index, count) = which;
        let which = ShardOf::new(index, count).ok_or_else(|| {
            let problem = format!("there is no shard {index} of {count}");
            Fault::argument("which", problem)
        })?;
        let settings = settings(cell, angle, keep_fins, memory_limit, None)?;
        Ok((which, settings, given::reading(preparing)?))
    };
    let (which, settings, reading) = settings().map_err(|fault: Fault| fault.raise(&ARGUMENTS))?;
    let bytes = run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let input = part.part(&coping.0, &reading, allow_open)?;
        let refused = |error: &dyn Diagnostic| Fault::refused(&input.file, error);
        let made = midsurf::shard::shard(&input.part, &settings, which, show, stop);
        let made = made.map_err(|error| refused(&error))?;
        let mut bytes = Vec::new();
        let written = made.write(&mut bytes).map_err(ShardFileError::from);
        written.map_err(|error| refused(&error))?;
        Ok(bytes)
    })?;
    let bytes = bytes.map_err(|fault: Fault| fault.raise(&ARGUMENTS))?;
    Ok(PyBytes::new(py, &bytes))
}

/// Joins all shards of an extraction.
#[pyfunction]
pub(crate) fn merge(
    py: Python<'_>,
    shards: Vec<PyBackedBytes>,
    wanted: Option<Elements>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Surface> {
    let arguments = ["element_size"];
    let wanted = elements(wanted).map_err(|fault| fault.raise(&arguments))?;
    run(py, threads, progress, |show, stop| {
        show("reading", 0, 0);
        let read = |bytes: &PyBackedBytes| Shard::read(bytes);
        let shards: Result<Vec<Shard>, ShardFileError> = shards.iter().map(read).collect();
        let shards = shards.map_err(|error| Fault::input(&error))?;
        let result = midsurf::shard::merge(shards, wanted, show, stop);
        let result = result.map_err(|error| Fault::input(&error))?;
        if result.surface.triangles().is_empty() {
            return Err(Fault::fruitless(Path::new("all shards"), &NoSurface));
        }
        Ok(Surface::merged(result))
    })?
    .map_err(|fault: Fault| fault.raise(&arguments))
}

/// Nothing came out.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("no mid-surface was found")]
#[diagnostic(help(
    "check the coping tags with `midsurf tags PART TAGS`, and take a smaller --cell"
))]
struct NoSurface;
