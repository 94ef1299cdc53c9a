//! From files, or arrays in memory, to a checked part with its coping tags:
//! what the command and all that stands in its place begin with.
//!
//! * [`Input`]: the part, and what is worth knowing of where it came from.
//! * [`CopingSource`]: whence the tags.
//! * [`IntakeError`]: why there is no part, with the file and the line.

mod error;
mod tags;

use std::path::{Path, PathBuf};

pub use error::IntakeError;
pub use tags::{CopingSource, facets, shown_ranges};

use crate::coping::{Coping, Detection, RuleResult, geometry_checksum, read_tags};
use crate::io::quote::shown_path;
use crate::io::{FacetNames, LoadedMesh, ReadWarning, read_mesh};
use crate::mesh::{FaceId, Part, PartError, PartOptions};
use crate::settings::memory::{Bytes, available};
use crate::settings::warning::Warning;
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
    /// The part.
    pub part: Part,
    /// What was odd but could be put right.
    pub warnings: Vec<Warning>,
}

/// Reads a mesh file.
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
    Warning {
        code: warning.code,
        message: format!("{}: {}", warning.place.within(file), warning.message),
    }
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
            flags: flags.clone(),
            ..Coping::none(loaded)
        },
    };
    let place = shown_path(tags.file().unwrap_or(mesh_file));
    let empty = coping.warnings.iter().map(|message| Warning {
        code: "empty_rule",
        message: format!("{place}: {message}"),
    });
    let found = coping.detection.as_ref();
    let found = found.map(|detection| detection_warnings(detection, mesh_file));
    let slivers = coping.slivers.iter().map(|sliver| Warning {
        code: "sliver",
        message: format!(
            "{}: {}",
            shown_path(mesh_file),
            sliver_words(sliver, &loaded.source)
        ),
    });
    let warnings = empty.chain(found.into_iter().flatten());
    let warnings = warnings.chain(slivers).collect();
    Ok((coping, warnings))
}

impl Input {
    /// Reads and checks a part with its tags.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn read(
        file: &Path,
        tags: &CopingSource,
        options: PartOptions,
    ) -> Result<Input, IntakeError> {
        let (loaded, warnings) = load(file)?;
        Input::of(loaded, warnings, file, tags, options)
    }

    /// Checks a mesh with its tags; `file` is its name in messages, `warnings`
    /// what was said of it so far.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn of(
        mut loaded: LoadedMesh,
        mut warnings: Vec<Warning>,
        file: &Path,
        tags: &CopingSource,
        options: PartOptions,
    ) -> Result<Input, IntakeError> {
        let (coping, more) = load_tags(tags, &loaded, file)?;
        warnings.extend(more);
        let geometry = geometry_checksum(&loaded.mesh);
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
        warnings.extend(more.iter().map(|warning| Warning {
            code: warning.code(),
            message: format!("{}: {warning}", shown_path(file)),
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
            part,
            warnings,
        })
    }

    /// First name that the file gives a triangle.
    pub fn name_of(&self, face: FaceId) -> Option<&str> {
        let facet = *self.source.get(face.index())?;
        self.names.of(facet).all().next()
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
        let options = PartOptions::default();
        Input::of(mesh(), Vec::new(), Path::new("part"), &tags, options)
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
