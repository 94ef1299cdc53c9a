//! What a part is, and which of its faces close a wall.

use std::io::Write;
use std::path::PathBuf;

use midsurf::coping::detect::{Detection, Options};
use midsurf::coping::{detect, detected_text, detected_toml};
use midsurf::inspect::Walls;
use midsurf::io::LoadedMesh;
use midsurf::io::write::stage;
use midsurf::report::detection::account;
use midsurf::report::info::Info;
use midsurf::settings::warning::Warning;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::fault::{Fault, pairs};
use crate::given::{self, Preparing, Source, Tagged};
use crate::run::run;
use crate::surface::{commit, unwritten};

/// Arguments of [`info`] that remedies may name.
const INFO: [&str; 8] = [
    "coping", "weld", "repair", "scale", "unit", "cad_sag", "solid", "min_wall",
];

/// What a part is, in JSON.
#[pyfunction]
pub(crate) fn info(
    py: Python<'_>,
    part: Source,
    coping: Tagged,
    preparing: Preparing,
    min_wall: Option<f64>,
    threads: Option<usize>,
) -> PyResult<String> {
    let told = || {
        min_wall.map_or(Ok(0.0), |length| given::positive("min_wall", length))?;
        given::reading(preparing)
    };
    let reading = told().map_err(|fault| fault.raise(&INFO))?;
    let told = run(py, threads, None, |_, _| {
        let mut input = part.part(&coping.0, &reading, true)?;
        input.keep_for_info(&coping.0);
        let thickness = Walls::of(&input.part).thickness(min_wall);
        Ok(serde_json::json!(Info::of(&input, thickness)).to_string())
    })?;
    told.map_err(|fault: Fault| fault.raise(&INFO))
}

/// The coping faces that were found on a mesh.
#[pyclass(frozen, module = "midsurf._midsurf")]
pub(crate) struct Tags {
    loaded: LoadedMesh,
    detection: Detection,
    warnings: Vec<Warning>,
}

/// Arguments of [`detect_coping`] that remedies may name.
const DETECT: [&str; 7] = [
    "samples", "weld", "repair", "scale", "unit", "cad_sag", "solid",
];

/// Finds the coping faces of a part.
#[pyfunction]
pub(crate) fn detect_coping(
    py: Python<'_>,
    part: Source,
    samples: Option<usize>,
    preparing: Preparing,
    threads: Option<usize>,
) -> PyResult<Tags> {
    let reading = given::reading(preparing).map_err(|fault| fault.raise(&DETECT))?;
    let found = run(py, threads, None, |_, _| {
        let (loaded, warnings) = part.mended(&reading)?;
        Ok(Tags {
            detection: detect(&loaded.mesh, &Options { samples }),
            loaded,
            warnings,
        })
    })?;
    found.map_err(|fault: Fault| fault.raise(&DETECT))
}

#[pymethods]
impl Tags {
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, &self.detection.flags)
    }

    /// Doubts as questions, gravest first.
    #[getter]
    fn questions(&self) -> Vec<String> {
        let questions = self.detection.questions();
        questions.iter().map(|q| q.text(&self.detection)).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<(&'static str, String)> {
        pairs(&self.warnings)
    }

    /// Faces, scores and reasons, as the command's report has them, in JSON.
    fn report(&self) -> String {
        account(&self.detection).to_string()
    }

    /// Writes a tag file, TOML or text.
    fn save(&self, py: Python<'_>, file: PathBuf) -> PyResult<()> {
        let suffix = file.extension();
        let text = if suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("toml")) {
            detected_toml(&self.detection, &self.loaded)
        } else {
            detected_text(&self.detection, &self.loaded)
        };
        let write = || {
            let write = |out: &mut dyn Write| out.write_all(text.as_bytes());
            commit(stage(&file, write).map_err(unwritten)?)
        };
        py.detach(write).map_err(|fault: Fault| fault.raise(&[]))
    }
}
