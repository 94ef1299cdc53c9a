//! A mesh painted with its deviation: PLY with a scalar and a colour a vertex.

use std::path::Path;

use super::ply::{Paint, write_mesh};
use super::{Staged, WriteError, check_finite, stage};
use crate::mesh::TriMesh;

/// Writes a mesh with a deviation at every vertex, to a place beside its
/// target; nothing shows under its name before [`Staged::commit`].
///
/// Colours run from blue at `-full` over green at zero to red at `full`.
///
/// # Errors
///
/// [`WriteError`] names the file.
///
/// # Panics
///
/// If there are fewer deviations than vertices.
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
    check_finite(&mesh.positions, false, file)?;
    let comment = format!("deviation; colours: blue -{full}, green 0, red {full}");
    let paint = Paint {
        name: "deviation",
        values: deviation,
        colour: &|value| colour(value / full),
    };
    stage(file, |out| {
        write_mesh(mesh, &comment, &[], Some(paint), out)
    })
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
