//! Plain triangle meshes: solids, in OBJ, binary PLY and binary STL.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::ply::{self, Paint};
use super::{Staged, WriteError, check_finite, stage, stl};
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

/// A number at every vertex, to look at, and normals to look at it by.
#[derive(Clone, Copy, Debug)]
pub struct Shade<'a> {
    /// Name of the PLY property.
    pub name: &'static str,
    /// By vertex; shown if there are as many as vertices.
    pub values: &'a [f64],
    /// Unit normals by vertex; written if there are as many as vertices.
    pub normals: &'a [DVec3],
}

/// Writes a solid in the format of the file's suffix to a place beside its
/// target; nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_solid(
    mesh: &TriMesh,
    shade: Option<Shade>,
    file: &Path,
) -> Result<Staged, WriteError> {
    let format = SolidFormat::of(file)?;
    check_finite(&mesh.positions, !format.is_double(), file)?;
    stage(file, |out| write_solid(mesh, shade, format, out))
}

/// Writes a solid to any sink. Only PLY shows the shade, as a property and as
/// colours from red at the least over yellow and green to blue at the most.
///
/// # Errors
///
/// Those of the sink.
pub fn write_solid(
    mesh: &TriMesh,
    shade: Option<Shade>,
    format: SolidFormat,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        SolidFormat::Obj => write_obj(mesh, out),
        SolidFormat::Ply => write_ply(mesh, shade, out),
        SolidFormat::Stl => {
            let corners = mesh.faces().map(|face| mesh.corners(face));
            stl::write(corners, "closed mesh, binary STL", out)
        }
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

fn write_ply(mesh: &TriMesh, shade: Option<Shade>, out: &mut dyn Write) -> io::Result<()> {
    let shade = shade.filter(|s| s.values.len() == mesh.positions.len());
    let values = shade.map_or(&[][..], |s| s.values);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let colour = |value: f64| {
        let share = (value - low) / (high - low);
        colour(if share.is_finite() { share } else { 1.0 })
    };
    let paint = shade.map(|Shade { name, values, .. }| Paint {
        name,
        values,
        colour: &colour,
    });
    let normals = shade.map_or(&[][..], |s| s.normals);
    ply::write_mesh(mesh, "solid", normals, paint, out)
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
