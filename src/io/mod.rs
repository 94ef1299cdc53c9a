//! Files: mesh readers, mid-surface writers.
//!
//! Readers take what real programs write and refuse the rest with the file,
//! the line or byte, and what to do. Writers put a file in place only when it
//! is complete.

mod control;
mod error;
mod names;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod surface;
mod text;
pub mod write;

use std::path::Path;

use sha2::{Digest, Sha256};

pub use control::{ControlMesh, read_control, read_control_bytes};
pub use error::{Place, Problem, ReadError};
pub use names::{FacetNames, NameSet};
pub use surface::{LoadedSurface, RadiusSource, SurfaceReadError, read_surface};

use crate::mesh::{FaceId, TriMesh};
use error::Located;
pub(crate) use text::decode;

/// A mesh as its file states it, triangulated but otherwise unchecked for
/// closedness and the like; see [`crate::mesh::Part::new`] for that.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// The triangles, in the order of the file's facets.
    pub mesh: TriMesh,
    /// Facet of the file that each triangle comes from, ascending. Facets
    /// count from 0 in file order: `f` lines of an OBJ, facets of an STL,
    /// faces of a PLY or OFF. Coping indices mean facets.
    pub source: Vec<u32>,
    /// Names of each facet.
    pub names: FacetNames,
    /// What was odd but could be read.
    pub warnings: Vec<ReadWarning>,
    /// What the file says of vertices besides their place.
    pub values: PlyValues,
    /// SHA-256 of the file's bytes, in hexadecimal.
    pub sha256: String,
    places: FacetPlaces,
}

impl LoadedMesh {
    /// Number of facets in the file.
    pub fn facet_count(&self) -> usize {
        self.names.len()
    }

    /// Names of the facet that a triangle comes from.
    pub fn names_of(&self, triangle: FaceId) -> &NameSet {
        self.names.of(self.source[triangle.index()])
    }

    /// Where the file states the facet that a triangle comes from.
    pub fn place_of(&self, triangle: FaceId) -> Place {
        match (self.source.get(triangle.index()), &self.places) {
            (Some(&facet), FacetPlaces::Lines(lines)) => Place::Line(lines[facet as usize]),
            (Some(&facet), FacetPlaces::Bytes(bytes)) => Place::Byte(bytes[facet as usize]),
            (Some(&facet), FacetPlaces::Strided { start, stride }) => {
                Place::Byte(start + stride * u64::from(facet))
            }
            (None, _) => Place::Whole,
        }
    }
}

/// Numbers that a PLY file gives for its vertices, as many as vertices, or none
/// where the file has no such property, and for its edges. As read, so of any
/// value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyValues {
    /// Property `thickness`.
    pub thickness: Vec<f64>,
    /// Property `radius`.
    pub radius: Vec<f64>,
    /// Property `kind`; see [`write::vertex_code`].
    pub kind: Vec<f64>,
    /// Property `kind` of edges, by their vertices, which exist.
    pub edges: Vec<([u32; 2], f64)>,
}

/// Oddity met while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadWarning {
    /// Stable code for reports.
    pub code: &'static str,
    /// Where it occurred first.
    pub place: Place,
    /// What was met and what was done.
    pub message: String,
}

/// Where facets stand in their file.
#[derive(Clone, Debug)]
pub(crate) enum FacetPlaces {
    Lines(Vec<u64>),
    Bytes(Vec<u64>),
    Strided { start: u64, stride: u64 },
}

/// What the readers hand up.
pub(crate) struct RawMesh {
    pub(crate) mesh: TriMesh,
    pub(crate) source: Vec<u32>,
    pub(crate) names: FacetNames,
    pub(crate) places: FacetPlaces,
    pub(crate) warnings: Vec<ReadWarning>,
    pub(crate) values: PlyValues,
}

/// Mesh formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// STL, binary or ASCII.
    Stl,
    /// PLY, ASCII or binary of either byte order.
    Ply,
    /// OFF, ASCII.
    Off,
}

impl MeshFormat {
    /// The format that a file name's suffix stands for, in any case of letters.
    pub fn of(file: &Path) -> Option<MeshFormat> {
        let suffix = file.extension()?.to_str()?.to_ascii_lowercase();
        match suffix.as_str() {
            "obj" => Some(MeshFormat::Obj),
            "stl" => Some(MeshFormat::Stl),
            "ply" => Some(MeshFormat::Ply),
            "off" => Some(MeshFormat::Off),
            _ => None,
        }
    }
}

/// Reads a mesh file; the suffix of its name tells the format.
///
/// # Errors
///
/// [`ReadError`] names the file, the line or byte, and what to do.
pub fn read_mesh(file: impl AsRef<Path>) -> Result<LoadedMesh, ReadError> {
    let file = file.as_ref();
    let fail = |problem| ReadError::new(file, (Place::Whole, problem));
    let meta = std::fs::metadata(file).map_err(|error| fail(Problem::Io(error)))?;
    if meta.is_dir() {
        return Err(fail(Problem::NotAFile));
    }
    let format = MeshFormat::of(file).ok_or_else(|| fail(Problem::UnknownFormat))?;
    let bytes = std::fs::read(file).map_err(|error| fail(Problem::Io(error)))?;
    read_mesh_bytes(&bytes, format, file)
}

/// Reads a mesh from memory; `file` serves messages only.
///
/// # Errors
///
/// As [`read_mesh`].
pub fn read_mesh_bytes(
    bytes: &[u8],
    format: MeshFormat,
    file: &Path,
) -> Result<LoadedMesh, ReadError> {
    let raw = parse(bytes, format).map_err(|located| ReadError::new(file, located))?;
    Ok(LoadedMesh {
        mesh: raw.mesh,
        source: raw.source,
        names: raw.names,
        warnings: raw.warnings,
        values: raw.values,
        sha256: hex(&Sha256::digest(bytes)),
        places: raw.places,
    })
}

fn parse(bytes: &[u8], format: MeshFormat) -> Result<RawMesh, Located> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err((Place::Whole, Problem::Empty));
    }
    let binary_stl = format == MeshFormat::Stl && stl::is_binary(bytes);
    if !binary_stl && let Some(what) = text::foreign(bytes) {
        return Err((Place::Whole, Problem::Foreign(what)));
    }
    let raw = match format {
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Off => off::parse(bytes),
    }?;
    if raw.mesh.triangles.is_empty() {
        let vertices = raw.mesh.positions.len();
        return Err((Place::Whole, Problem::NoFaces { vertices }));
    }
    Ok(raw)
}

/// Lower-case hexadecimal digits of bytes.
pub(crate) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
