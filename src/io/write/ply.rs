//! Binary little-endian PLY.

use std::io::{self, Write};

use glam::DVec3;

use super::{CREASE_CODE, border_code, vertex_code};
use crate::mesh::TriMesh;
use crate::surface::{MidSurface, VertexKind, segments};

/// A number and a colour for it at every vertex.
pub(super) struct Paint<'a> {
    /// Name of the property.
    pub name: &'static str,
    /// By vertex.
    pub values: &'a [f64],
    /// Red, green and blue of a value.
    pub colour: &'a dyn Fn(f64) -> [u8; 3],
}

/// Writes a mesh, painted or not, under a comment of one line; with normals if
/// there are as many as vertices.
pub(super) fn write_mesh(
    mesh: &TriMesh,
    comment: &str,
    normals: &[DVec3],
    paint: Option<Paint>,
    out: &mut dyn Write,
) -> io::Result<()> {
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment {comment}\n\
         element vertex {}\n\
         property double x\n\
         property double y\n\
         property double z\n",
        mesh.positions.len()
    )?;
    let normals = Some(normals).filter(|normals| normals.len() == mesh.positions.len());
    if normals.is_some() {
        write!(
            out,
            "property double nx\n\
             property double ny\n\
             property double nz\n"
        )?;
    }
    if let Some(Paint { name, .. }) = paint {
        write!(
            out,
            "property double {name}\n\
             property uchar red\n\
             property uchar green\n\
             property uchar blue\n"
        )?;
    }
    write!(
        out,
        "element face {}\n\
         property list uchar int vertex_indices\n\
         end_header\n",
        mesh.triangles.len()
    )?;
    for (i, p) in mesh.positions.iter().enumerate() {
        write_floats(&p.to_array(), out)?;
        if let Some(normals) = normals {
            write_floats(&normals[i].to_array(), out)?;
        }
        if let Some(Paint { values, colour, .. }) = &paint {
            write_floats(&[values[i]], out)?;
            out.write_all(&colour(values[i]))?;
        }
    }
    for &corners in &mesh.triangles {
        write_corners(corners, out)?;
    }
    Ok(())
}

/// Writes a mid-surface with thickness, radius and kind a vertex, sheet a face,
/// and the edges of seams, borders and creases with their kind.
pub(super) fn write(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    let seams =
        (surface.seams().iter()).map(|l| (&l.path, l.closed, vertex_code(VertexKind::Seam)));
    let borders = (surface.borders().iter()).map(|l| (&l.path, l.closed, border_code(l.kind)));
    let creases = (surface.creases().iter()).map(|l| (&l.path, l.closed, CREASE_CODE));
    let edges: Vec<([u32; 2], u8)> = seams
        .chain(borders)
        .chain(creases)
        .flat_map(|(path, closed, kind)| segments(path, closed).map(move |edge| (edge, kind)))
        .collect();
    write!(
        out,
        "ply\n\
         format binary_little_endian 1.0\n\
         comment mid-surface; kind: 0 sheet, 1 seam, 2 junction, 3 coping border, 4 fading border, 5 crease\n\
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
         element edge {}\n\
         property int vertex1\n\
         property int vertex2\n\
         property uchar kind\n\
         end_header\n",
        surface.vertices().len(),
        surface.triangles().len(),
        edges.len()
    )?;
    for vertex in surface.vertices() {
        write_floats(&vertex.position.to_array(), out)?;
        write_floats(&[vertex.ball.thickness, vertex.ball.radius], out)?;
        out.write_all(&[vertex_code(vertex.kind)])?;
    }
    for triangle in surface.triangles() {
        write_corners(triangle.corners, out)?;
        out.write_all(&triangle.sheet.to_le_bytes())?;
    }
    for ([a, b], kind) in edges {
        out.write_all(&a.to_le_bytes())?;
        out.write_all(&b.to_le_bytes())?;
        out.write_all(&[kind])?;
    }
    Ok(())
}

fn write_floats(values: &[f64], out: &mut dyn Write) -> io::Result<()> {
    values
        .iter()
        .try_for_each(|value| out.write_all(&value.to_le_bytes()))
}

fn write_corners(corners: [u32; 3], out: &mut dyn Write) -> io::Result<()> {
    out.write_all(&[3])?;
    corners
        .iter()
        .try_for_each(|corner| out.write_all(&corner.to_le_bytes()))
}
