//! VTK unstructured grid (XML), for ParaView, pyVista and meshio.
//!
//! One piece, so that lines share the points of the triangles. Cells: the
//! triangles first, then every segment of every seam and border as a line.
//!
//! | array | on | value |
//! | --- | --- | --- |
//! | `thickness` | points | distance between footpoints, part units |
//! | `radius` | points | radius of the ball that touches the nearest walls |
//! | `foot_1`, `foot_2` | points | way to a footpoint on either wall, if both are known; their difference is normal to the sheet |
//! | `kind` | points | 0 sheet, 1 seam, 2 junction, 3 coping border, 4 fading border |
//! | `sheet` | cells | sheet of a triangle or border; -1 on seams |
//! | `kind` | cells | 0 triangle, 1 seam, 3 coping border, 4 fading border |
//! | `line` | cells | number of the seam or border within its list; -1 on triangles |
//!
//! Arrays are base64 of little-endian bytes behind a 64-bit byte count.

use std::io::{self, Write};

use glam::DVec3;

use super::{CREASE_CODE, border_code, vertex_code};
use crate::surface::{MidSurface, MidVertex, VertexKind, segments};

/// VTK's number for a two-node line.
const VTK_LINE: u8 = 3;
/// VTK's number for a triangle.
pub(super) const VTK_TRIANGLE: u8 = 5;

/// Cell arrays, filled cell by cell.
#[derive(Default)]
struct Cells {
    corners: Vec<u8>,
    offsets: Vec<u8>,
    types: Vec<u8>,
    sheet: Vec<u8>,
    kind: Vec<u8>,
    line: Vec<u8>,
    ends: i64,
}

impl Cells {
    fn push(&mut self, corners: &[u32], vtk_type: u8, sheet: i32, kind: u8, line: i32) {
        for &corner in corners {
            self.corners
                .extend_from_slice(&i64::from(corner).to_le_bytes());
        }
        self.ends += corners.len() as i64;
        self.offsets.extend_from_slice(&self.ends.to_le_bytes());
        self.types.push(vtk_type);
        self.sheet.extend_from_slice(&sheet.to_le_bytes());
        self.kind.push(kind);
        self.line.extend_from_slice(&line.to_le_bytes());
    }

    fn of(surface: &MidSurface) -> Cells {
        let mut cells = Cells::default();
        for triangle in surface.triangles() {
            let sheet = triangle.sheet as i32;
            cells.push(&triangle.corners, VTK_TRIANGLE, sheet, 0, -1);
        }
        for (number, seam) in surface.seams().iter().enumerate() {
            let kind = vertex_code(VertexKind::Seam);
            for segment in segments(&seam.path, seam.closed) {
                cells.push(&segment, VTK_LINE, -1, kind, number as i32);
            }
        }
        for (number, border) in surface.borders().iter().enumerate() {
            let kind = border_code(border.kind);
            for segment in segments(&border.path, border.closed) {
                let sheet = border.sheet as i32;
                cells.push(&segment, VTK_LINE, sheet, kind, number as i32);
            }
        }
        for (number, crease) in surface.creases().iter().enumerate() {
            for segment in segments(&crease.path, crease.closed) {
                let sheet = crease.sheet as i32;
                cells.push(&segment, VTK_LINE, sheet, CREASE_CODE, number as i32);
            }
        }
        cells
    }
}

pub(super) fn write(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    let cells = Cells::of(surface);
    let vertices = &surface.vertices();
    let positions: Vec<u8> = vertices
        .iter()
        .flat_map(|vertex| vertex.position.to_array())
        .flat_map(f64::to_le_bytes)
        .collect();
    let thickness: Vec<u8> = vertices
        .iter()
        .flat_map(|vertex| vertex.ball.thickness.to_le_bytes())
        .collect();
    let radius: Vec<u8> = vertices
        .iter()
        .flat_map(|vertex| vertex.ball.radius.to_le_bytes())
        .collect();
    let feet = [0, 1].map(|n| ways(vertices, n));
    let kinds: Vec<u8> = vertices
        .iter()
        .map(|vertex| vertex_code(vertex.kind))
        .collect();

    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        vertices.len(),
        cells.types.len()
    )?;
    writeln!(out, "<PointData Scalars=\"thickness\">")?;
    array(out, "Float64", "thickness", 1, &thickness)?;
    array(out, "UInt8", "kind", 1, &kinds)?;
    array(out, "Float64", "radius", 1, &radius)?;
    for (name, ways) in ["foot_1", "foot_2"].into_iter().zip(&feet) {
        array(out, "Float64", name, 3, ways)?;
    }
    writeln!(out, "</PointData>\n<CellData Scalars=\"sheet\">")?;
    array(out, "Int32", "sheet", 1, &cells.sheet)?;
    array(out, "UInt8", "kind", 1, &cells.kind)?;
    array(out, "Int32", "line", 1, &cells.line)?;
    writeln!(out, "</CellData>\n<Points>")?;
    array(out, "Float64", "Points", 3, &positions)?;
    writeln!(out, "</Points>\n<Cells>")?;
    array(out, "Int64", "connectivity", 1, &cells.corners)?;
    array(out, "Int64", "offsets", 1, &cells.offsets)?;
    array(out, "UInt8", "types", 1, &cells.types)?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

/// Way from each vertex to a footpoint of two; zero where they are not known, or
/// a third wall ties.
fn ways(vertices: &[MidVertex], foot: usize) -> Vec<u8> {
    let way = |v: &MidVertex| match v.ball.footpoints.len() {
        2 => v.ball.footpoints[foot] - v.position,
        _ => DVec3::ZERO,
    };
    let ways = vertices.iter().flat_map(|v| way(v).to_array());
    ways.flat_map(f64::to_le_bytes).collect()
}

pub(super) fn array(
    out: &mut dyn Write,
    data_type: &str,
    name: &str,
    components: usize,
    bytes: &[u8],
) -> io::Result<()> {
    write!(out, "<DataArray type=\"{data_type}\" Name=\"{name}\" ")?;
    if components > 1 {
        write!(out, "NumberOfComponents=\"{components}\" ")?;
    }
    writeln!(out, "format=\"binary\">")?;
    let count = (bytes.len() as u64).to_le_bytes();
    base64(count.iter().chain(bytes).copied(), out)?;
    writeln!(out, "\n</DataArray>")
}

/// Base64 of RFC 4648, with padding.
fn base64(bytes: impl Iterator<Item = u8>, out: &mut dyn Write) -> io::Result<()> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut bytes = bytes;
    while let Some(first) = bytes.next() {
        let (second, third) = (bytes.next(), bytes.next());
        let group = u32::from_be_bytes([0, first, second.unwrap_or(0), third.unwrap_or(0)]);
        let digit = |shift: u32| DIGITS[(group >> shift & 63) as usize];
        let mut text = [digit(18), digit(12), digit(6), digit(0)];
        if second.is_none() {
            text[2] = b'=';
        }
        if third.is_none() {
            text[3] = b'=';
        }
        out.write_all(&text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn base64_matches_the_vectors_of_rfc_4648() {
        for (plain, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let mut out = Vec::new();
            super::base64(plain.bytes(), &mut out).unwrap();
            assert_eq!(out, expected.as_bytes());
        }
    }
}
