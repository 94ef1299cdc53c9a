//! What functions are told: read from Python while its lock is held, turned
//! into the library's own once it is not.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use midsurf::intake::{CopingSource, Input, IntakeError, Reading, load};
use midsurf::io::LoadedMesh;
use midsurf::mesh::TriMesh;
use midsurf::settings::cell::CellSize;
use midsurf::settings::memory::{Bytes, MEMORY_LIMIT, available};
use midsurf::settings::warning::Warning;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{are_triples, mesh_in};
use crate::fault::Fault;

/// Name in messages of a mesh that is no file.
const ARRAYS: &str = "the mesh given";

/// A mesh: a file, or arrays.
pub(crate) enum Source {
    /// A file to read.
    File(PathBuf),
    /// Vertices and triangles.
    Mesh(TriMesh),
}

impl<'py> FromPyObject<'_, 'py> for Source {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Source> {
        if let Ok(file) = given.extract::<PathBuf>() {
            return Ok(Source::File(file));
        }
        let (vertices, triangles): (PyReadonlyArray2<'_, f64>, PyReadonlyArray2<'_, u32>) =
            given.extract()?;
        if !are_triples(&vertices, &triangles) {
            let fault = Fault::argument("part", "vertices and triangles need three columns each");
            return Err(fault.raise(&[]));
        }
        Ok(Source::Mesh(mesh_in(&vertices, &triangles)))
    }
}

impl Source {
    /// Its name in messages.
    pub(crate) fn name(&self) -> PathBuf {
        match self {
            Source::File(file) => file.clone(),
            Source::Mesh(_) => PathBuf::from(ARRAYS),
        }
    }

    /// The mesh of a surface, read and with corners that exist, and what was said
    /// of it.
    pub(crate) fn loaded(self) -> Result<(LoadedMesh, Vec<Warning>), Fault> {
        match self {
            Source::File(file) => load(&file).map_err(intake),
            Source::Mesh(mesh) => {
                let loaded = LoadedMesh::of(mesh);
                let loaded = loaded.map_err(|error| Fault::refused(Path::new(ARRAYS), &error))?;
                Ok((loaded, Vec::new()))
            }
        }
    }

    /// The mesh of a part, mended as asked for.
    pub(crate) fn mended(self, reading: &Reading) -> Result<(LoadedMesh, Vec<Warning>), Fault> {
        if let Source::File(file) = &self {
            return reading.load(file).map_err(intake);
        }
        let name = self.name();
        if reading.cad_sag.is_some() {
            return Err(intake(IntakeError::NoCad(name)));
        }
        let (loaded, warnings) = self.loaded()?;
        reading.prepare(loaded, warnings, &name).map_err(intake)
    }

    /// The part that it makes with its tags.
    pub(crate) fn part(
        self,
        tags: &CopingSource,
        reading: &Reading,
        allow_open: bool,
    ) -> Result<Input, Fault> {
        let name = self.name();
        let (loaded, warnings) = self.mended(reading)?;
        Input::of(loaded, warnings, &name, tags, allow_open).map_err(intake)
    }
}

/// What went wrong with files.
pub(crate) fn intake(error: IntakeError) -> Fault {
    match error {
        IntakeError::Memory { ref file, .. } => Fault::fruitless(file, &error),
        error => Fault::input(&error),
    }
}

/// What is done to a part as it is read: weld, repair, scale, unit, sag of a CAD
/// model, solid.
pub(crate) type Preparing = (
    Option<f64>,
    bool,
    Option<f64>,
    Option<String>,
    Option<String>,
    Option<String>,
);

/// The same for the library.
pub(crate) fn reading(given: Preparing) -> Result<Reading, Fault> {
    let (weld, repair, scale, unit, sag, solid) = given;
    Ok(Reading {
        weld,
        repair,
        scale: scale.map(|factor| positive("scale", factor)).transpose()?,
        unit: unit.map(|name| parsed("unit", &name)).transpose()?,
        cad_sag: sag.map(|sag| cell("cad_sag", &sag)).transpose()?,
        solid,
    })
}

/// Coping tags: `auto`, `none`, a file, or a flag for every triangle.
pub(crate) struct Tagged(pub(crate) CopingSource);

impl<'py> FromPyObject<'_, 'py> for Tagged {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Tagged> {
        if let Ok(file) = given.extract::<PathBuf>() {
            return Ok(Tagged(file.into_os_string().into()));
        }
        let flags: PyReadonlyArray1<'_, bool> = given.extract()?;
        Ok(Tagged(CopingSource::Flags(
            flags.as_array().iter().copied().collect(),
        )))
    }
}

/// Reads an argument that is text.
pub(crate) fn parsed<T: FromStr<Err: std::fmt::Display>>(
    name: &str,
    text: &str,
) -> Result<T, Fault> {
    text.parse()
        .map_err(|problem| Fault::argument(name, problem))
}

/// A cell size.
pub(crate) fn cell(name: &str, text: &str) -> Result<CellSize, Fault> {
    parsed(name, text)
}

/// Refuses a length that is none.
pub(crate) fn positive(name: &str, length: f64) -> Result<f64, Fault> {
    if length > 0.0 && length.is_finite() {
        Ok(length)
    } else {
        Err(Fault::argument(name, "expected a positive length"))
    }
}

/// Refuses an angle beyond 180 degrees.
pub(crate) fn angle(degrees: f64) -> Result<f64, Fault> {
    if degrees > 0.0 && degrees < 180.0 {
        Ok(degrees)
    } else {
        Err(Fault::argument(
            "angle",
            "expected degrees between 0 and 180",
        ))
    }
}

/// The memory bound, or what the system still gives where that is less.
pub(crate) fn memory(limit: Option<&str>) -> Result<u64, Fault> {
    let limit = match limit {
        Some(text) => parsed::<Bytes>("memory_limit", text)?.0,
        None => MEMORY_LIMIT,
    };
    Ok(limit.min(available().unwrap_or(u64::MAX)))
}
