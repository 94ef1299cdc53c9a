//! How a part is read from its file: flags that all commands share which take one.

use std::path::Path;

use midsurf::internals::field::Field;
use midsurf::internals::walls::thickness::ThicknessProfile;
use midsurf::io::quote::shown_path;
use midsurf::io::{LoadedMesh, Tessellation, Unit, is_cad, read_mesh_with};
use midsurf::mesh::{Part, PartOptions};
use midsurf::settings::cell::{CellSize, Scale};
use serde_json::{Value, json};

use super::failure::{Failure, place_of};
use super::input::read_warning;
use super::memory::check_input;
use super::numbers::positive;
use super::warning::Warning;

/// Points at which walls are measured for a sag in wall thicknesses.
const SAMPLES: usize = 2000;

/// What is done to a part as it is read.
#[derive(clap::Args, Clone, Debug, Default)]
pub(crate) struct ReadingArgs {
    /// Merge vertices of the part within this distance
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    weld: Option<f64>,
    /// Put right also what takes a guess: gaps a little wider than noise, doubled
    /// triangles, small flat holes, pinched vertices; all is told and listed
    #[arg(long)]
    repair: bool,
    /// Multiply the part's coordinates by this
    #[arg(long, value_name = "FACTOR", value_parser = positive, allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Unit of the part's numbers, for reports; changes no number
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// How far chords of a CAD model may lie off its faces: a length in mm, a share of
    /// the wall thickness (`0.05t`) or of the diagonal (`0.1%`) [default: 32 chords a full turn]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    cad_sag: Option<CellSize>,
}

/// Which of several solids.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct SelectArgs {
    /// Of several solids in the file take this one: its number, counted from 1, its
    /// name, or `all`
    #[arg(long, value_name = "SOLID", default_value = "all")]
    solid: String,
}

impl ReadingArgs {
    /// These flags beside a command's own settings.
    pub(crate) fn beside(&self, select: Option<&SelectArgs>, mut settings: Value) -> Value {
        settings["weld"] = json!(self.weld);
        settings["repair"] = json!(self.repair);
        settings["scale"] = json!(self.scale);
        settings["unit"] = json!(self.unit);
        settings["cad_sag"] = json!(self.cad_sag);
        settings["solid"] = json!(select.map_or("all", |select| &select.solid));
        settings
    }

    /// Reads a part and does to it what the flags say.
    pub(crate) fn load(
        &self,
        file: &Path,
        select: Option<&SelectArgs>,
    ) -> Result<(LoadedMesh, Vec<Warning>), Failure> {
        check_input(file)?;
        let read =
            |sag: Option<f64>| read_mesh_with(file, Tessellation { sag }).map_err(Failure::input);
        let mut loaded = match self.cad_sag {
            Some(size) if is_cad(file) => read(Some(sag(size, file, || read(None))?))?,
            Some(_) => {
                return Err(Failure::usage(
                    format!("{}: --cad-sag is for CAD models", shown_path(file)),
                    "leave --cad-sag away: a mesh has its chords already",
                ));
            }
            None => read(None)?,
        };
        let mut warnings: Vec<Warning> = (loaded.warnings.iter())
            .map(|w| read_warning(file, w))
            .collect();
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
        if let Some(select) = select.filter(|select| select.solid != "all") {
            let none = |error| Failure::refused(file, &error);
            loaded.keep_solid(&select.solid).map_err(none)?;
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
        let refuse = |error| Failure::at(place_of(&error, &loaded), file, &error);
        for repair in mended.map_err(refuse)? {
            warnings.push(Warning {
                places: repair.places,
                ..Warning::new(
                    repair.what.code(),
                    format!("{}: {}", shown_path(file), repair.what),
                )
            });
        }
        Ok((loaded, warnings))
    }
}

/// A sag as a length. What it is relative to is measured on the model as it is meshed
/// by default.
fn sag(
    size: CellSize,
    file: &Path,
    read: impl Fn() -> Result<LoadedMesh, Failure>,
) -> Result<f64, Failure> {
    let mut scale = Scale {
        auto: None,
        thickness: None,
        diagonal: 0.0,
    };
    if !matches!(size, CellSize::Length(_)) {
        let mesh = read()?.mesh;
        scale.diagonal = mesh.bounds().diagonal();
        let flags = vec![false; mesh.triangles.len()];
        let part = Part::new(mesh, flags, PartOptions::default());
        scale.thickness = part.ok().and_then(|(part, _)| {
            ThicknessProfile::measure(&Field::new(&part), SAMPLES).percentile(50.0)
        });
    }
    size.resolve(&scale)
        .map_err(|error| Failure::refused(file, &error).calling("--cell", "--cad-sag"))
}
