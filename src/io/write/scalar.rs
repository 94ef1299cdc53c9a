//! A mesh with one number a vertex: PLY with colours, or VTU.

use std::io::{self, Write};
use std::path::Path;

use super::ply::{Paint, write_mesh};
use super::{Staged, WriteError, stage};
use crate::mesh::TriMesh;

/// VTK's number for a triangle.
const VTK_TRIANGLE: u8 = 5;

/// Numbers on the vertices of a mesh, and how to colour them.
#[derive(Clone, Copy)]
pub struct Scalars<'a> {
    /// Name of the array.
    pub name: &'static str,
    /// One a vertex; not a number where there is none.
    pub values: &'a [f64],
    /// Red at the first, green in the middle, blue at the second.
    pub range: [f64; 2],
}

/// Writes a mesh with a number at every vertex, to a place beside its target;
/// nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
///
/// # Panics
///
/// If there are fewer numbers than vertices.
pub fn stage_scalars(mesh: &TriMesh, scalars: Scalars, file: &Path) -> Result<Staged, WriteError> {
    let suffix = file.extension().and_then(|suffix| suffix.to_str());
    match suffix.map(str::to_ascii_lowercase).as_deref() {
        Some("ply") => {
            let [low, high] = scalars.range;
            let comment = format!("{}; colours: red {low}, blue {high}", scalars.name);
            let paint = Paint {
                name: scalars.name,
                values: scalars.values,
                colour: &|value| colour(value, scalars.range),
            };
            stage(file, |out| {
                write_mesh(mesh, &comment, &[], Some(paint), out)
            })
        }
        Some("vtu") => stage(file, |out| write_vtu(mesh, scalars, out)),
        _ => Err(WriteError::UnknownFormat {
            file: file.to_owned(),
            known: ".ply, .vtu",
        }),
    }
}

/// Red, green, blue between the ends of a range; grey for no number.
fn colour(value: f64, [low, high]: [f64; 2]) -> [u8; 3] {
    if value.is_nan() {
        return [150; 3];
    }
    let at = ((value - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let share = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    [
        share(1.0 - 2.0 * at),
        share(1.0 - (2.0 * at - 1.0).abs()),
        share(2.0 * at - 1.0),
    ]
}

fn write_vtu(mesh: &TriMesh, scalars: Scalars, out: &mut dyn Write) -> io::Result<()> {
    let (points, cells) = (mesh.positions.len(), mesh.triangles.len());
    write!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n\
         <PointData Scalars=\"{name}\">\n\
         <DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">\n",
        name = scalars.name
    )?;
    for value in &scalars.values[..points] {
        writeln!(out, "{value}")?;
    }
    out.write_all(
        b"</DataArray>\n</PointData>\n<Points>\n\
          <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
    )?;
    for p in &mesh.positions {
        writeln!(out, "{} {} {}", p.x, p.y, p.z)?;
    }
    out.write_all(
        b"</DataArray>\n</Points>\n<Cells>\n\
          <DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n",
    )?;
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "{a} {b} {c}")?;
    }
    out.write_all(b"</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n")?;
    for cell in 1..=cells {
        writeln!(out, "{}", 3 * cell)?;
    }
    out.write_all(b"</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n")?;
    for _ in 0..cells {
        writeln!(out, "{VTK_TRIANGLE}")?;
    }
    out.write_all(b"</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
}

#[cfg(test)]
mod tests {
    use super::colour;

    #[test]
    fn colours_run_from_red_over_green_to_blue() {
        let range = [1.0, 3.0];
        assert_eq!(colour(0.5, range), [255, 0, 0]);
        assert_eq!(colour(2.0, range), [0, 255, 0]);
        assert_eq!(colour(3.0, range), [0, 0, 255]);
        assert_eq!(colour(f64::NAN, range), [150; 3]);
        // A plate of one thickness throughout.
        assert_eq!(colour(2.0, [2.0, 2.0]), [255, 0, 0]);
    }
}
