//! From files, or arrays in memory, to a checked part with its coping tags:
//! what the command and all that stands in its place begin with.
//!
//! * [`Input`]: the part, and what is worth knowing of where it came from.
//! * [`Reading`]: what is done to it as it is read.
//! * [`CopingSource`]: whence the tags.
//! * [`ControlInput`]: the control mesh of a subdivision surface.
//! * [`balls`]: what is said of surfaces with a thickness.
//! * [`IntakeError`]: why there is no part, with the file and the line.

pub mod balls;
mod control;
mod error;
mod reading;
mod tags;

use std::path::{Path, PathBuf};

pub use control::ControlInput;
pub use error::IntakeError;
pub use reading::Reading;
pub use tags::{CopingSource, facets, shown_ranges};

use crate::coping::{Coping, Detection, RuleResult, read_tags};
use crate::io::{FacetNames, LoadedMesh, ReadWarning, Unit, read_mesh};
use crate::mesh::{FaceId, Part, PartError, PartOptions};
use crate::settings::memory::{Bytes, available};
use crate::settings::quote::shown_path;
use crate::settings::warning::Warning;
use crate::surface::MidSurface;
use tags::{detection_warnings, sliver_words};

/// A checked part, and what is worth knowing of where it came from.
#[derive(Clone, Debug)]
pub struct Input {
    /// The mesh file; the name in messages of what came from memory.
    pub file: PathBuf,
    /// SHA-256 of the file's bytes, in hexadecimal; empty where there is no file.
    pub sha256: String,
    /// Checksum of the geometry alone.
    pub geometry: String,
    /// Facets of the file.
    pub facets: usize,
    /// Names of each facet.
    pub names: FacetNames,
    /// What each rule of the tag file selects.
    pub rules: Vec<RuleResult>,
    /// What the detector found, where it was asked.
    pub detection: Option<Detection>,
    /// Facet of the file that each triangle comes from.
    pub source: Vec<u32>,
    /// Unit of all lengths, where it is known.
    pub unit: Option<Unit>,
    /// The part.
    pub part: Part,
    /// What was odd but could be put right.
    pub warnings: Vec<Warning>,
}

/// Reads a mesh file that is no part: a surface.
///
/// # Errors
///
/// [`IntakeError`] for what cannot be read or would not fit into memory.
pub fn load(file: &Path) -> Result<(LoadedMesh, Vec<Warning>), IntakeError> {
    check_size(file)?;
    let loaded = read_mesh(file)?;
    let warnings = loaded.warnings.iter();
    let warnings = warnings.map(|warning| read_warning(file, warning));
    let warnings = warnings.collect();
    Ok((loaded, warnings))
}

/// What a reader met, with the file's name.
pub fn read_warning(file: &Path, warning: &ReadWarning) -> Warning {
    Warning::new(
        warning.code,
        format!("{}: {}", warning.place.within(file), warning.message),
    )
}

/// Bytes that reading and checking a file takes at the peak, over its size;
/// measured: 9 to 13 for a binary STL and an OBJ of 300,000 triangles.
const BYTES_PER_BYTE: f64 = 12.0;

/// Refuses a file that the memory left could not hold once read.
///
/// # Errors
///
/// [`IntakeError::Memory`].
pub fn check_size(file: &Path) -> Result<(), IntakeError> {
    // What cannot be asked for its size is told when it is read.
    let Ok(meta) = std::fs::metadata(file) else {
        return Ok(());
    };
    let needed = BYTES_PER_BYTE * meta.len() as f64;
    match available() {
        Some(left) if needed > left as f64 => Err(IntakeError::Memory {
            file: file.to_owned(),
            needed: Bytes(needed as u64),
            left: Bytes(left),
            fitting: Bytes((left as f64 / BYTES_PER_BYTE) as u64),
        }),
        _ => Ok(()),
    }
}

/// Reads a tag file for a mesh, or finds the tags.
///
/// # Errors
///
/// [`IntakeError::Tags`].
pub fn load_tags(
    tags: &CopingSource,
    loaded: &LoadedMesh,
    mesh_file: &Path,
) -> Result<(Coping, Vec<Warning>), IntakeError> {
    let coping = match tags {
        CopingSource::None => Coping::none(loaded),
        CopingSource::Auto => Coping::detected(loaded),
        CopingSource::File(file) => read_tags(file, loaded, mesh_file)?,
        CopingSource::Flags(flags) => Coping {
            flags: flags_of(flags, loaded, mesh_file)?,
            ..Coping::none(loaded)
        },
    };
    let place = shown_path(tags.file().unwrap_or(mesh_file));
    let empty = coping.warnings.iter();
    let empty = empty.map(|message| Warning::new("empty_rule", format!("{place}: {message}")));
    let scaled = coping.scaled.map(|factor| {
        Warning::new(
            "other_units",
            format!("{place}: no place that a rule names lies at the part, but all would if it were {factor} times as large: are part and tags in different units? --scale {factor} on the part"),
        )
    });
    let found = coping.detection.as_ref();
    let found = found.map(|detection| detection_warnings(detection, mesh_file));
    let slivers = coping.slivers.iter().map(|sliver| {
        let words = sliver_words(sliver, &loaded.source);
        Warning::new("sliver", format!("{}: {words}", shown_path(mesh_file)))
    });
    let warnings = empty.chain(scaled).chain(found.into_iter().flatten());
    let warnings = warnings.chain(slivers).collect();
    Ok((coping, warnings))
}

/// A flag for every triangle from those of the facets that they come from.
fn flags_of(
    flags: &[bool],
    loaded: &LoadedMesh,
    mesh_file: &Path,
) -> Result<Vec<bool>, IntakeError> {
    let facets = loaded.facet_count();
    if flags.len() != facets {
        let problem = PartError::CopingLength {
            flags: flags.len(),
            triangles: facets,
        };
        return Err(IntakeError::in_mesh(mesh_file, loaded, problem));
    }
    let flag = |&facet: &u32| flags[facet as usize];
    Ok(loaded.source.iter().map(flag).collect())
}

/// Largest part of a mid-surface's box that may lie outside the part's, in
/// diagonals of the part, for the two to belong together.
const SAME_PLACE: f64 = 0.5;

impl Input {
    /// Reads and checks a part with its tags.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn read(
        file: &Path,
        tags: &CopingSource,
        reading: &Reading,
        allow_open: bool,
    ) -> Result<Input, IntakeError> {
        let (loaded, warnings) = reading.load(file)?;
        Input::of(loaded, warnings, file, tags, allow_open)
    }

    /// Checks a mesh that was [prepared](Reading::prepare) with its tags; `file`
    /// is its name in messages, `warnings` what was said of it so far.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn of(
        mut loaded: LoadedMesh,
        mut warnings: Vec<Warning>,
        file: &Path,
        tags: &CopingSource,
        allow_open: bool,
    ) -> Result<Input, IntakeError> {
        let (coping, more) = load_tags(tags, &loaded, file)?;
        warnings.extend(more);
        let geometry = loaded.geometry();
        // It is mended already.
        let options = PartOptions {
            allow_open,
            ..PartOptions::default()
        };
        let mesh = std::mem::take(&mut loaded.mesh);
        let (part, more) = Part::new(mesh, coping.flags, options).map_err(|error| {
            match (&error, tags.file()) {
                // Those two are the tags' fault.
                (PartError::AllCoping { .. } | PartError::NoWall { .. }, Some(tags)) => {
                    IntakeError::in_mesh(tags, &loaded, error)
                }
                _ => IntakeError::in_mesh(file, &loaded, error),
            }
        })?;
        tracing::info!(
            triangles = part.triangle_count(),
            coping = part.coping_count(),
            "part read"
        );
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

    /// Leaves out what does not concern who asks what a part is: where no tags
    /// were asked for none are missing, and nothing hangs on single faces.
    pub fn keep_for_info(&mut self, tags: &CopingSource) {
        let asked = *tags != CopingSource::None;
        self.warnings.retain(|warning| match warning.code {
            "no_coping" => asked,
            "coping_doubt" | "coping_doubts" => false,
            _ => true,
        });
    }

    /// First name that the file gives a triangle.
    pub fn name_of(&self, face: FaceId) -> Option<&str> {
        let facet = *self.source.get(face.index())?;
        self.names.of(facet).all().next()
    }

    /// Refuses a mid-surface that is elsewhere, or of another size: of another
    /// part or in another unit.
    ///
    /// # Errors
    ///
    /// [`IntakeError::Foreign`].
    pub fn owns(&self, file: &Path, surface: &MidSurface) -> Result<(), IntakeError> {
        let (part, model) = (self.part.bounds(), surface.mesh().bounds());
        let inside = part.grown(SAME_PLACE * part.diagonal());
        let apart = !inside.contains(model.min) || !inside.contains(model.max);
        if apart || model.diagonal() < 0.01 * part.diagonal() {
            return Err(IntakeError::Foreign {
                file: file.to_owned(),
                part: self.file.clone(),
                diagonal: model.diagonal(),
                whole: part.diagonal(),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::TriMesh;

    /// A tetrahedron.
    fn mesh() -> LoadedMesh {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = TriMesh {
            positions,
            triangles,
        };
        LoadedMesh::of(mesh).unwrap()
    }

    fn input(tags: CopingSource) -> Result<Input, IntakeError> {
        Input::of(mesh(), Vec::new(), Path::new("part"), &tags, false)
    }

    #[test]
    fn flags_are_taken_as_given() {
        let flags = vec![false, true, false, false];
        let input = input(CopingSource::Flags(flags.clone())).unwrap();
        assert_eq!(input.part.coping(), flags);
        assert_eq!(input.source, [0, 1, 2, 3]);
        assert_eq!(input.name_of(FaceId(1)), None);
    }

    #[test]
    fn flags_go_with_what_a_facet_became() {
        // A vertex on an edge of the neighbour, which is split there.
        let mut mesh = mesh().mesh;
        mesh.positions.push(DVec3::new(0.5, 0.0, 0.0));
        mesh.triangles[1] = [0, 4, 3];
        mesh.triangles.push([4, 1, 3]);
        let file = Path::new("part");
        let reading = Reading::default();
        let (loaded, warnings) =
            (reading.prepare(LoadedMesh::of(mesh).unwrap(), Vec::new(), file)).unwrap();
        assert_eq!(loaded.source.len(), 6);
        let tags = CopingSource::Flags(vec![true, false, false, false, false]);
        let input = Input::of(loaded, warnings, file, &tags, false).unwrap();
        assert_eq!(input.part.coping_count(), 2);
    }

    #[test]
    fn bad_arrays_are_refused_in_words() {
        let error = input(CopingSource::Flags(vec![true])).unwrap_err();
        assert_eq!(
            error.to_string(),
            "part: 1 coping flags were given for 4 triangles"
        );
        let mut bad = mesh().mesh;
        bad.triangles[2] = [0, 1, 9];
        let error = LoadedMesh::of(bad).unwrap_err();
        assert_eq!(error.triangle(), Some(FaceId(2)));
    }
}
