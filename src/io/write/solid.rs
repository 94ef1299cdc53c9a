//! Closed triangle meshes: STL, OBJ and PLY.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::WriteError;
use crate::mesh::TriMesh;

/// Formats of a solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolidFormat {
    /// Binary STL, single precision.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// Binary PLY; with thickness and a colour at every vertex if it is given.
    Ply,
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
            Some("stl") => Ok(SolidFormat::Stl),
            Some("obj") => Ok(SolidFormat::Obj),
            Some("ply") => Ok(SolidFormat::Ply),
            _ => Err(WriteError::UnknownFormat {
                file: file.to_owned(),
                known: ".stl, .obj or .ply",
            }),
        }
    }
}

/// Writes a mesh. `thickness` has a value a vertex, or none; only PLY shows it,
/// with colours from red at the thinnest over yellow and green to blue at the
/// thickest.
///
/// # Errors
///
/// Those of the sink.
pub fn write_solid(
    mesh: &TriMesh,
    thickness: &[f64],
    format: SolidFormat,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        SolidFormat::Stl => stl(mesh, out),
        SolidFormat::Obj => obj(mesh, out),
        SolidFormat::Ply => ply(mesh, thickness, out),
    }
}

fn stl(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [b' '; 80];
    let title = b"midsurf, binary STL";
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

fn obj(mesh: &TriMesh, out: &mut dyn Write) -> io::Result<()> {
    for DVec3 { x, y, z } in &mesh.positions {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| u64::from(v) + 1)) {
        writeln!(out, "f {a} {b} {c}")?;
    }
    Ok(())
}

fn ply(mesh: &TriMesh, thickness: &[f64], out: &mut dyn Write) -> io::Result<()> {
    let coloured = thickness.len() == mesh.positions.len();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n",
        mesh.positions.len()
    )?;
    if coloured {
        out.write_all(
            b"property double thickness\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n",
        )?;
    }
    write!(
        out,
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.triangles.len()
    )?;
    let low = thickness.iter().copied().fold(f64::INFINITY, f64::min);
    let high = thickness.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for (k, position) in mesh.positions.iter().enumerate() {
        for value in position.to_array() {
            out.write_all(&value.to_le_bytes())?;
        }
        if coloured {
            out.write_all(&thickness[k].to_le_bytes())?;
            let share = (thickness[k] - low) / (high - low);
            out.write_all(&colour(if share.is_finite() { share } else { 1.0 }))?;
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

/// Red, yellow, green, cyan, blue, for 0 to 1.
fn colour(share: f64) -> [u8; 3] {
    let ramp = |middle: f64| {
        let level = 2.0 - (4.0 * share - middle).abs();
        (level.clamp(0.0, 1.0) * 255.0).round() as u8
    };
    // Red falls from 1 to 2 quarters, green holds from 1 to 3, blue rises.
    [ramp(0.0), ramp(2.0), ramp(4.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_from_red_to_blue() {
        let expected = [
            (0.0, [255, 0, 0]),
            (0.25, [255, 255, 0]),
            (0.5, [0, 255, 0]),
            (0.75, [0, 255, 255]),
            (1.0, [0, 0, 255]),
        ];
        for (share, rgb) in expected {
            assert_eq!(colour(share), rgb, "{share}");
        }
    }
}
