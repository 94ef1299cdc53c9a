//! A mesh with figures at its points and triangles, for ParaView.

use std::io::{self, Write};
use std::path::Path;

use super::vtu::{VTK_TRIANGLE, array};
use super::{Staged, WriteError, stage};
use crate::mesh::TriMesh;

/// A figure for every point or every triangle, under a name.
pub type Figures<'f> = (&'f str, &'f [f64]);

/// Writes a mesh with figures as `.vtu` to a place beside its target; nothing
/// shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_fields(
    mesh: &TriMesh,
    points: &[Figures],
    triangles: &[Figures],
    file: &Path,
) -> Result<Staged, WriteError> {
    let suffix = file.extension().and_then(|suffix| suffix.to_str());
    if !suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("vtu")) {
        return Err(WriteError::UnknownFormat {
            file: file.to_owned(),
            known: ".vtu",
        });
    }
    stage(file, |out| write(mesh, points, triangles, out))
}

fn write(
    mesh: &TriMesh,
    points: &[Figures],
    triangles: &[Figures],
    out: &mut dyn Write,
) -> io::Result<()> {
    let count = mesh.triangles.len();
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">",
        mesh.positions.len(),
    )?;
    let floats =
        |values: &[f64]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let wholes = |values: &mut dyn Iterator<Item = i64>| -> Vec<u8> {
        values.flat_map(i64::to_le_bytes).collect()
    };
    writeln!(out, "<PointData>")?;
    for (name, values) in points {
        array(out, "Float64", name, 1, &floats(values))?;
    }
    writeln!(out, "</PointData>\n<CellData>")?;
    for (name, values) in triangles {
        array(out, "Float64", name, 1, &floats(values))?;
    }
    writeln!(out, "</CellData>\n<Points>")?;
    let positions: Vec<f64> = mesh.positions.iter().flat_map(|p| p.to_array()).collect();
    array(out, "Float64", "Points", 3, &floats(&positions))?;
    writeln!(out, "</Points>\n<Cells>")?;
    let corners = &mut mesh.triangles.iter().flatten().map(|&v| i64::from(v));
    array(out, "Int64", "connectivity", 1, &wholes(corners))?;
    array(
        out,
        "Int64",
        "offsets",
        1,
        &wholes(&mut (1..=count as i64).map(|n| 3 * n)),
    )?;
    array(out, "UInt8", "types", 1, &vec![VTK_TRIANGLE; count])?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}
