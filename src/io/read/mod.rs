//! Mesh readers: one file a format.

mod bdf;
mod bytes;
mod cad;
mod control;
mod elements;
mod gltf;
mod inp;
mod loaded;
mod msh;
mod msh_binary;
mod obj;
mod obj_tags;
mod off;
mod ply;
mod polygon;
mod prepare;
mod stl;
mod surface;
mod threemf;

use std::path::Path;

use sha2::{Digest, Sha256};

pub(crate) use bytes::read_bytes;
pub use bytes::{MAX_INPUT, limit_input};
pub use cad::{Tessellation, is_cad};
pub use control::{ControlMesh, read_control, read_control_bytes};
pub use loaded::{LoadedMesh, PlyValues, ReadWarning};
pub use obj_tags::{BoundaryTag, ControlTags, TagKind};
pub use prepare::NoSolid;
pub use surface::{LoadedSurface, RadiusSource, SurfaceReadError, read_any_surface, read_surface};

use super::error::{Located, Place, Problem, ReadError};
use super::text::{self, hex};
use loaded::RawMesh;

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
    /// Gmsh MSH 2.2 or 4.1, ASCII or binary.
    Msh,
    /// Abaqus or CalculiX input deck.
    Inp,
    /// Nastran bulk data.
    Bdf,
    /// 3MF.
    ThreeMf,
    /// glTF 2.0, as text with its buffers inside or beside it, or binary.
    Gltf,
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
            "msh" => Some(MeshFormat::Msh),
            "inp" => Some(MeshFormat::Inp),
            "3mf" => Some(MeshFormat::ThreeMf),
            "gltf" | "glb" => Some(MeshFormat::Gltf),
            "bdf" | "nas" | "dat" => Some(MeshFormat::Bdf),
            _ => None,
        }
    }
}

/// Reads a mesh file; the suffix of its name tells the format. A CAD model (.step,
/// .stp, .iges, .igs, .brep) is meshed by Gmsh, if that is installed.
///
/// # Errors
///
/// [`ReadError`] names the file, the line or byte, and what to do.
pub fn read_mesh(file: impl AsRef<Path>) -> Result<LoadedMesh, ReadError> {
    read_mesh_with(file.as_ref(), Tessellation::default())
}

/// As [`read_mesh`], with a say in how finely a CAD model is meshed.
///
/// # Errors
///
/// As [`read_mesh`].
pub fn read_mesh_with(file: &Path, tessellation: Tessellation) -> Result<LoadedMesh, ReadError> {
    let fail = |problem| ReadError::new(file, (Place::Whole, problem));
    let meta = std::fs::metadata(file).map_err(|error| fail(Problem::Io(error)))?;
    if meta.is_dir() {
        return Err(fail(Problem::NotAFile));
    }
    if cad::is_cad(file) {
        let bytes = read_bytes(file).map_err(fail)?;
        let made =
            cad::mesh(file, tessellation).map_err(|located| ReadError::new(file, located))?;
        let mut loaded = read_mesh_bytes(&made, MeshFormat::Msh, file)?;
        // Lines of the mesh in between mean nothing to the user.
        loaded.places = loaded::FacetPlaces::None;
        loaded.sha256 = hex(&Sha256::digest(bytes));
        loaded.unit = cad::unit(file);
        return Ok(loaded);
    }
    let format = MeshFormat::of(file).ok_or_else(|| fail(Problem::UnknownFormat))?;
    let bytes = read_bytes(file).map_err(fail)?;
    let raw = match format {
        MeshFormat::Gltf => gltf::parse(&bytes, file.parent()),
        format => parse(&bytes, format),
    };
    loaded(raw, &bytes, file)
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
    loaded(parse(bytes, format), bytes, file)
}

fn loaded(
    raw: Result<RawMesh, Located>,
    bytes: &[u8],
    file: &Path,
) -> Result<LoadedMesh, ReadError> {
    let raw = raw.map_err(|located| ReadError::new(file, located))?;
    if raw.mesh.triangles.is_empty() {
        let vertices = raw.mesh.positions.len();
        let problem = Problem::NoFaces { vertices };
        return Err(ReadError::new(file, (Place::Whole, problem)));
    }
    Ok(LoadedMesh {
        mesh: raw.mesh,
        source: raw.source,
        names: raw.names,
        warnings: raw.warnings,
        values: raw.values,
        sha256: hex(&Sha256::digest(bytes)),
        unit: raw.unit,
        places: raw.places,
        as_read: None,
    })
}

fn parse(bytes: &[u8], format: MeshFormat) -> Result<RawMesh, Located> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err((Place::Whole, Problem::Empty));
    }
    let binary = match format {
        MeshFormat::Stl => stl::is_binary(bytes),
        MeshFormat::ThreeMf => true,
        _ => false,
    };
    if !binary && let Some(what) = text::foreign(bytes) {
        return Err((Place::Whole, Problem::Foreign(what)));
    }
    match format {
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Off => off::parse(bytes),
        MeshFormat::Msh => msh::parse(bytes),
        MeshFormat::Inp => inp::parse(bytes),
        MeshFormat::Bdf => bdf::parse(bytes),
        MeshFormat::ThreeMf => threemf::parse(bytes),
        // Nothing lies beside what is in memory.
        MeshFormat::Gltf => gltf::parse(bytes, None),
    }
}
