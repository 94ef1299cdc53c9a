//! Binary little-endian PLY.

use std::io::{self, Write};

use super::vertex_code;
use crate::mesh::midsurface::MidSurface;

pub(super) fn write(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment mid-surface; kind: 0 sheet, 1 seam, 2 junction, 3 coping border, 4 fading border\n\
         element vertex {}\n\
         property double x\n\
         property double y\n\
         property double z\n\
         property double thickness\n\
         property double radius\n\
         property uchar kind\n\
         element face {}\n\
         property list uchar int vertex_indices\n\
         property int sheet\n\
         end_header\n",
        surface.vertices.len(),
        surface.triangles.len()
    )?;
    for vertex in &surface.vertices {
        for value in vertex.position.to_array() {
            out.write_all(&value.to_le_bytes())?;
        }
        out.write_all(&vertex.thickness.to_le_bytes())?;
        out.write_all(&vertex.radius().to_le_bytes())?;
        out.write_all(&[vertex_code(vertex.kind)])?;
    }
    for triangle in &surface.triangles {
        out.write_all(&[3])?;
        for corner in triangle.corners {
            out.write_all(&corner.to_le_bytes())?;
        }
        out.write_all(&triangle.sheet.to_le_bytes())?;
    }
    Ok(())
}
