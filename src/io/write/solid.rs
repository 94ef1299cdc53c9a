//! Plain triangle meshes: solids, in OBJ, binary PLY and binary STL.

use std::io::{self, Write};
use std::path::Path;

use super::{Staged, WriteError, stage};
use crate::mesh::TriMesh;

/// Formats of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidFormat {
    /// Wavefront OBJ.
    Obj,
    /// Binary little-endian PLY, double precision.
    Ply,
    /// Binary STL, single precision.
    Stl,
}

impl SolidFormat {
    /// The format that a file name's suffix stands for, in any case of letters.
    ///
    /// # Errors
    ///
    /// [`WriteError::UnknownFormat`].
    pub fn of(file: &Path) -> Result<SolidFormat, WriteError> {
        let suffix = file.extension().and_then(|suffix| suffix.to_str());
        match suffix.map(str::to_ascii_lowercase).as_deref() {
            Some("obj") => Ok(SolidFormat::Obj),
            Some("ply") => Ok(SolidFormat::Ply),
            Some("stl") => Ok(SolidFormat::Stl),
            _ => Err(WriteError::UnknownFormat {
                file: file.to_owned(),
                known: ".obj, .ply or .stl",
            }),
        }
    }

    /// Whether the format keeps every bit of an f64.
    pub fn is_double(self) -> bool {
        self != SolidFormat::Stl
    }
}

/// Writes a solid in the format of the file's suffix to a place beside its
/// target; nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_solid(mesh: &TriMesh, file: &Path) -> Result<Staged, WriteError> {
    let format = SolidFormat::of(file)?;
    stage(file, |out| write_solid(mesh, format, out))
}

/// Writes a solid to any sink.
///
/// # Errors
///
/// Those of the sink.
pub fn write_solid(mesh: &TriMesh, format: SolidFormat, out: &mut dyn Write) -> io::Result<()> {
    match format {
        SolidFormat::Obj => write_obj(mesh, out),
        SolidFormat::Ply => write_ply(mesh, out),
        SolidFormat::Stl => write_stl(mesh, out),
    }
}

fn write_obj(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    writeln!(out, "# solid: {vertices} vertices, {triangles} triangles")?;
    for p in &mesh.positions {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

fn write_ply(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment solid\n\
         element vertex {}\n\
         property double x\n\
         property double y\n\
         property double z\n\
         element face {}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for p in &mesh.positions {
        for value in p.to_array() {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

fn write_stl(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [b' '; 80];
    let title = b"closed mesh, binary STL";
    header[..title.len()].copy_from_slice(title);
    out.write_all(&header)?;
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| io::Error::other("too many triangles for STL"))?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for vector in [normal, a, b, c] {
            for value in vector.as_vec3().to_array() {
                out.write_all(&value.to_le_bytes())?;
            }
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}
