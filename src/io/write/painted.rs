//! A mesh painted with a value: PLY with a scalar and a colour a vertex.

use std::io::{self, Write};
use std::path::Path;

use super::{Staged, WriteError, stage};
use crate::mesh::TriMesh;

/// Writes a mesh with a deviation at every vertex, to a place beside its
/// target; nothing shows under its name before [`Staged::commit`].
///
/// Colours run from blue at `-full` over green at zero to red at `full`.
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_deviation(
    mesh: &TriMesh,
    deviation: &[f64],
    full: f64,
    file: &Path,
) -> Result<Staged, WriteError> {
    let suffix = file.extension().and_then(|suffix| suffix.to_str());
    if !suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("ply")) {
        return Err(WriteError::UnknownFormat {
            file: file.to_owned(),
            known: ".ply",
        });
    }
    stage(file, |out| write(mesh, deviation, full, out))
}

fn write(mesh: &TriMesh, deviation: &[f64], full: f64, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment deviation; colours: blue -{full}, green 0, red {full}\n\
         element vertex {}\n\
         property double x\n\
         property double y\n\
         property double z\n\
         property double deviation\n\
         property uchar red\n\
         property uchar green\n\
         property uchar blue\n\
         element face {}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )?;
    for (p, &deviation) in mesh.positions.iter().zip(deviation) {
        for value in p.to_array().into_iter().chain([deviation]) {
            out.write_all(&value.to_le_bytes())?;
        }
        out.write_all(&colour(deviation / full))?;
    }
    for triangle in &mesh.triangles {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}

/// Colour of a value between -1 and 1; what is beyond has the colour there.
fn colour(value: f64) -> [u8; 3] {
    let value = if value.is_finite() {
        value.clamp(-1.0, 1.0)
    } else {
        0.0
    };
    let share = |x: f64| (255.0 * x).round() as u8;
    [value.max(0.0), 1.0 - value.abs(), (-value).max(0.0)].map(share)
}

#[cfg(test)]
mod tests {
    use super::colour;

    #[test]
    fn colours_run_from_blue_to_red() {
        assert_eq!(colour(-2.0), [0, 0, 255]);
        assert_eq!(colour(0.0), [0, 255, 0]);
        assert_eq!(colour(0.5), [128, 128, 0]);
        assert_eq!(colour(f64::NAN), [0, 255, 0]);
    }
}
