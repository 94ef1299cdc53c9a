//! What is done to a part as it is read.

use std::path::Path;

use serde::Serialize;

use super::{IntakeError, check_size, read_warning};
use crate::field::Field;
use crate::io::{LoadedMesh, Tessellation, Unit, is_cad, read_mesh_with};
use crate::mesh::{Part, PartOptions};
use crate::settings::cell::{CellSize, Scale};
use crate::settings::quote::shown_path;
use crate::settings::warning::Warning;
use crate::walls::thickness::ThicknessProfile;

/// Points at which walls are measured for a sag in wall thicknesses.
const SAMPLES: usize = 2000;

/// What is done to a part as it is read.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reading {
    /// Merge vertices within this distance; see [`PartOptions::weld`].
    pub weld: Option<f64>,
    /// Put right also what takes a guess; see [`PartOptions::repair`].
    pub repair: bool,
    /// Multiply the coordinates by this.
    pub scale: Option<f64>,
    /// Unit of the numbers, for reports; changes none.
    pub unit: Option<Unit>,
    /// How far chords of a CAD model may lie off its faces.
    pub cad_sag: Option<CellSize>,
    /// Of several solids take this one: its number, counted from 1, or its name.
    pub solid: Option<String>,
}

impl Reading {
    /// Reads a part and does to it what is asked for.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn load(&self, file: &Path) -> Result<(LoadedMesh, Vec<Warning>), IntakeError> {
        check_size(file)?;
        let read = |sag: Option<f64>| read_mesh_with(file, Tessellation { sag });
        let loaded = match self.cad_sag {
            Some(size) if is_cad(file) => {
                let sag = sag(size, || Ok(read(None)?)).map_err(|error| match error {
                    SagError::Size(problem) => IntakeError::Sag {
                        file: file.to_owned(),
                        problem,
                    },
                    SagError::Intake(error) => error,
                })?;
                read(Some(sag))?
            }
            Some(_) => return Err(IntakeError::NoCad(file.to_owned())),
            None => read(None)?,
        };
        let warnings = loaded.warnings.iter();
        let warnings = warnings.map(|w| read_warning(file, w)).collect();
        self.prepare(loaded, warnings, file)
    }

    /// Does to a mesh what is asked for; `file` is its name in messages,
    /// `warnings` what was said of it so far.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn prepare(
        &self,
        mut loaded: LoadedMesh,
        mut warnings: Vec<Warning>,
        file: &Path,
    ) -> Result<(LoadedMesh, Vec<Warning>), IntakeError> {
        if let (Some(told), Some(own)) = (self.unit, loaded.unit)
            && told != own
        {
            let factor = own.millimetres() / told.millimetres();
            let message = format!(
                "{}: the file's numbers are in {own}, --unit says {told}; they stay as they are, --scale {factor} would convert them",
                shown_path(file)
            );
            warnings.push(Warning::new("unit_differs", message));
        }
        loaded.unit = self.unit.or(loaded.unit);
        if let Some(solid) = &self.solid {
            let none = |problem| IntakeError::Solid {
                file: file.to_owned(),
                problem,
            };
            loaded.keep_solid(solid).map_err(none)?;
        }
        if let Some(factor) = self.scale {
            loaded.scale(factor);
        }
        let options = PartOptions {
            allow_open: true,
            weld: self.weld,
            repair: self.repair,
        };
        let mended = loaded.mend(options);
        let refuse = |error| IntakeError::in_mesh(file, &loaded, error);
        for repair in mended.map_err(refuse)? {
            let message = format!("{}: {}", shown_path(file), repair.what);
            warnings.push(Warning {
                places: repair.places,
                ..Warning::new(repair.what.code(), message)
            });
        }
        Ok((loaded, warnings))
    }
}

/// Why a sag is no length.
enum SagError {
    Size(crate::settings::cell::BadCell),
    Intake(IntakeError),
}

/// A sag as a length. What it is relative to is measured on the model as it is meshed
/// by default.
fn sag(
    size: CellSize,
    read: impl Fn() -> Result<LoadedMesh, IntakeError>,
) -> Result<f64, SagError> {
    let mut scale = Scale {
        auto: None,
        thickness: None,
        diagonal: 0.0,
    };
    if !matches!(size, CellSize::Length(_)) {
        let mesh = read().map_err(SagError::Intake)?.mesh;
        scale.diagonal = mesh.bounds().diagonal();
        let flags = vec![false; mesh.triangles.len()];
        let part = Part::new(mesh, flags, PartOptions::default());
        scale.thickness = part.ok().and_then(|(part, _)| {
            ThicknessProfile::measure(&Field::new(&part), SAMPLES).percentile(50.0)
        });
    }
    size.resolve(&scale).map_err(SagError::Size)
}
