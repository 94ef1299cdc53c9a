//! Control meshes: polygons as their OBJ states them.

use std::path::Path;

use glam::DVec3;
use sha2::{Digest, Sha256};
use smallvec::SmallVec;

use super::{ControlTags, MeshFormat, ReadWarning, obj, read_bytes};
use crate::io::error::{Located, Place, Problem, ReadError};
use crate::io::names::FacetNames;
use crate::io::text::{self, hex};

/// Polygons of a file, unchecked; see [`crate::subdivide::Cage::new`] for that.
#[derive(Clone, Debug)]
pub struct ControlMesh {
    /// All vertices of the file, used or not.
    pub positions: Vec<DVec3>,
    /// Vertices of each face, in range.
    pub faces: Vec<SmallVec<[u32; 4]>>,
    /// Creases, corners, holes and boundary rule.
    pub tags: ControlTags,
    /// Groups, objects and materials of the faces.
    pub names: FacetNames,
    /// What was odd but could be read.
    pub warnings: Vec<ReadWarning>,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
    vertex_lines: Vec<u64>,
    face_lines: Vec<u64>,
}

impl ControlMesh {
    /// Where the file states a face.
    pub fn place_of_face(&self, face: usize) -> Place {
        self.face_lines
            .get(face)
            .map_or(Place::Whole, |&line| Place::Line(line))
    }

    /// Where the file states a vertex.
    pub fn place_of_vertex(&self, vertex: usize) -> Place {
        self.vertex_lines
            .get(vertex)
            .map_or(Place::Whole, |&line| Place::Line(line))
    }
}

/// Reads a control mesh; OBJ only, as other formats are for triangles.
///
/// # Errors
///
/// [`ReadError`] names the file, the line, and what to do.
pub fn read_control(file: impl AsRef<Path>) -> Result<ControlMesh, ReadError> {
    let file = file.as_ref();
    let fail = |problem| ReadError::new(file, (Place::Whole, problem));
    let meta = std::fs::metadata(file).map_err(|error| fail(Problem::Io(error)))?;
    if meta.is_dir() {
        return Err(fail(Problem::NotAFile));
    }
    if MeshFormat::of(file) != Some(MeshFormat::Obj) {
        return Err(fail(Problem::NoControlFormat));
    }
    let bytes = read_bytes(file).map_err(fail)?;
    read_control_bytes(&bytes, file)
}

/// Reads a control mesh from the bytes of an OBJ; `file` serves messages only.
///
/// # Errors
///
/// As [`read_control`].
pub fn read_control_bytes(bytes: &[u8], file: &Path) -> Result<ControlMesh, ReadError> {
    let raw = parse(bytes).map_err(|located| ReadError::new(file, located))?;
    Ok(ControlMesh {
        positions: raw.positions,
        faces: raw.faces,
        tags: raw.tags,
        names: raw.names,
        warnings: raw.warnings,
        sha256: hex(&Sha256::digest(bytes)),
        vertex_lines: raw.vertex_lines,
        face_lines: raw.face_lines,
    })
}

fn parse(bytes: &[u8]) -> Result<obj::Polygons, Located> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err((Place::Whole, Problem::Empty));
    }
    if let Some(what) = text::foreign(bytes) {
        return Err((Place::Whole, Problem::Foreign(what)));
    }
    obj::parse_polygons(bytes)
}
