//! Mesh readers: one file a format.

mod bdf;
mod bytes;
mod cad;
mod control;
mod elements;
mod inp;
mod loaded;
mod msh;
mod obj;
mod obj_tags;
mod off;
mod ply;
mod polygon;
mod stl;
mod surface;
mod threemf;

use std::path::Path;

use sha2::{Digest, Sha256};

pub(crate) use bytes::read_bytes;
pub use bytes::{MAX_INPUT, limit_input};
pub use control::{ControlMesh, read_control, read_control_bytes};
pub use loaded::{LoadedMesh, PlyValues, ReadWarning};
pub use obj_tags::{BoundaryTag, ControlTags, TagKind};
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
    /// Gmsh MSH 2.2 or 4.1, ASCII.
    Msh,
    /// Abaqus or CalculiX input deck.
    Inp,
    /// Nastran bulk data.
    Bdf,
    /// 3MF.
    ThreeMf,
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
    let file = file.as_ref();
    let fail = |problem| ReadError::new(file, (Place::Whole, problem));
    let meta = std::fs::metadata(file).map_err(|error| fail(Problem::Io(error)))?;
    if meta.is_dir() {
        return Err(fail(Problem::NotAFile));
    }
    if cad::is_cad(file) {
        let bytes = read_bytes(file).map_err(fail)?;
        let made = cad::mesh(file).map_err(|located| ReadError::new(file, located))?;
        let mut loaded = read_mesh_bytes(&made, MeshFormat::Msh, file)?;
        // Lines of the mesh in between mean nothing to the user.
        loaded.places = loaded::FacetPlaces::None;
        loaded.sha256 = hex(&Sha256::digest(bytes));
        return Ok(loaded);
    }
    let format = MeshFormat::of(file).ok_or_else(|| fail(Problem::UnknownFormat))?;
    let bytes = read_bytes(file).map_err(fail)?;
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
    let archive = format == MeshFormat::ThreeMf;
    if !binary_stl
        && !archive
        && let Some(what) = text::foreign(bytes)
    {
        return Err((Place::Whole, Problem::Foreign(what)));
    }
    let raw = match format {
        MeshFormat::Obj => obj::parse(bytes),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Ply => ply::parse(bytes),
        MeshFormat::Off => off::parse(bytes),
        MeshFormat::Msh => msh::parse(bytes),
        MeshFormat::Inp => inp::parse(bytes),
        MeshFormat::Bdf => bdf::parse(bytes),
        MeshFormat::ThreeMf => threemf::parse(bytes),
    }?;
    if raw.mesh.triangles.is_empty() {
        let vertices = raw.mesh.positions.len();
        return Err((Place::Whole, Problem::NoFaces { vertices }));
    }
    Ok(raw)
}
