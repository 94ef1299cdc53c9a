//! Part and tags from files to a checked part: shared by the commands.

use std::path::{Path, PathBuf};

use midsurf::coping::{Coping, Detection, RuleResult, read_tags};
use midsurf::io::{FacetNames, LoadedMesh, ReadWarning, Unit, read_mesh};
use midsurf::mesh::{FaceId, Part, PartError, PartOptions};
use midsurf::surface::MidSurface;

use super::console::say;
use super::coping::{CopingSource, detection_warnings, sliver_words};
use super::failure::{Failure, place_of};
use super::memory::check_input;
use super::numbers::figure;
use super::reading::{ReadingArgs, SelectArgs};
pub(crate) use super::warning::Warning;
use midsurf::io::quote::shown_path;

/// A checked part, and what is worth knowing of its files.
pub(crate) struct Input {
    pub(crate) file: PathBuf,
    pub(crate) sha256: String,
    pub(crate) geometry: String,
    pub(crate) facets: usize,
    pub(crate) names: FacetNames,
    pub(crate) rules: Vec<RuleResult>,
    pub(crate) detection: Option<Detection>,
    /// Facet of the file that each triangle comes from.
    pub(crate) source: Vec<u32>,
    /// Unit of all lengths, where it is known.
    pub(crate) unit: Option<Unit>,
    pub(crate) part: Part,
    pub(crate) warnings: Vec<Warning>,
}

/// Reads a mesh file that is no part: a surface.
pub(crate) fn load(file: &Path) -> Result<(LoadedMesh, Vec<Warning>), Failure> {
    check_input(file)?;
    let loaded = read_mesh(file).map_err(Failure::input)?;
    let warnings = loaded
        .warnings
        .iter()
        .map(|warning| read_warning(file, warning))
        .collect();
    Ok((loaded, warnings))
}

pub(crate) fn read_warning(file: &Path, warning: &ReadWarning) -> Warning {
    Warning::new(
        warning.code,
        format!("{}: {}", warning.place.within(file), warning.message),
    )
}

/// Reads a tag file for a mesh, or finds the tags.
pub(crate) fn load_tags(
    tags: &CopingSource,
    loaded: &LoadedMesh,
    mesh_file: &Path,
) -> Result<(Coping, Vec<Warning>), Failure> {
    let coping = match tags {
        CopingSource::None => Coping::none(loaded),
        CopingSource::Auto => Coping::detected(loaded),
        CopingSource::File(file) => read_tags(file, loaded, mesh_file).map_err(Failure::input)?,
    };
    let place = shown_path(tags.file().unwrap_or(mesh_file));
    let empty = coping
        .warnings
        .iter()
        .map(|message| Warning::new("empty_rule", format!("{place}: {message}")));
    let scaled = coping.scaled.map(|factor| {
        Warning::new(
            "other_units",
            format!("{place}: no place that a rule names lies at the part, but all would if it were {factor} times as large: are part and tags in different units? --scale {factor} on the part"),
        )
    });
    let found = coping.detection.as_ref();
    let found = found.map(|detection| detection_warnings(detection, mesh_file));
    let slivers = coping.slivers.iter().map(|sliver| {
        Warning::new(
            "sliver",
            format!(
                "{}: {}",
                shown_path(mesh_file),
                sliver_words(sliver, &loaded.source)
            ),
        )
    });
    let warnings = empty.chain(scaled).chain(found.into_iter().flatten());
    let warnings = warnings.chain(slivers).collect();
    Ok((coping, warnings))
}

impl Input {
    /// Reads and checks a part with its tags.
    pub(crate) fn read(
        file: &Path,
        tags: &CopingSource,
        reading: (&ReadingArgs, Option<&SelectArgs>),
        allow_open: bool,
    ) -> Result<Input, Failure> {
        let (reading, select) = reading;
        let (mut loaded, mut warnings) = reading.load(file, select)?;
        let (coping, more) = load_tags(tags, &loaded, file)?;
        warnings.extend(more);
        let geometry = loaded.geometry();
        // It is mended already.
        let options = PartOptions {
            allow_open,
            ..PartOptions::default()
        };
        let mesh = std::mem::take(&mut loaded.mesh);
        let flags = coping.flags;
        let (part, more) =
            Part::new(mesh, flags, options).map_err(|error| match (&error, tags.file()) {
                // Those two are the tags' fault.
                (PartError::AllCoping { .. } | PartError::NoWall { .. }, Some(tags)) => {
                    Failure::refused(tags, &error)
                }
                _ => {
                    let place = place_of(&error, &loaded);
                    Failure::at(place, file, &error)
                }
            })?;
        warnings.extend(more.iter().map(|warning| {
            Warning::new(warning.code(), format!("{}: {warning}", shown_path(file)))
        }));
        Ok(Input {
            file: file.to_owned(),
            sha256: loaded.sha256,
            geometry,
            facets: loaded.names.len(),
            names: loaded.names,
            rules: coping.rules,
            detection: coping.detection,
            source: loaded.source,
            unit: loaded.unit,
            part,
            warnings,
        })
    }
}

/// Largest part of a mid-surface's box that may lie outside the part's, in
/// diagonals of the part, for the two to belong together.
const SAME_PLACE: f64 = 0.5;

impl Input {
    /// Refuses a mid-surface that is elsewhere, or of another size: of another
    /// part or in another unit.
    pub(crate) fn owns(&self, file: &Path, surface: &MidSurface) -> Result<(), Failure> {
        let (part, model) = (self.part.bounds(), surface.mesh().bounds());
        let inside = part.grown(SAME_PLACE * part.diagonal());
        let apart = !inside.contains(model.min) || !inside.contains(model.max);
        if apart || model.diagonal() < 0.01 * part.diagonal() {
            return Err(Failure::usage(
                format!(
                    "{}: does not belong to {}: its box is {} by its diagonal, that of the part {}",
                    shown_path(file),
                    shown_path(&self.file),
                    figure(model.diagonal()),
                    figure(part.diagonal())
                ),
                "check that both are of one part, in one unit and one place",
            ));
        }
        Ok(())
    }

    /// First name that the file gives a triangle.
    pub(crate) fn name_of(&self, face: FaceId) -> Option<&str> {
        let facet = *self.source.get(face.index())?;
        self.names.of(facet).all().next()
    }
}

/// Prints warnings to stderr.
pub(crate) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        say(format_args!("warning: {}", warning.message));
    }
}
