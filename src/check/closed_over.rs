//! Coping faces that no border reached: features closed over.

use crate::field::Field;
use crate::mesh::{Bounds, Part, TriMesh};
use crate::surface::{BorderKind, MidSurface, VertexKind};
use glam::DVec3;
use serde::Serialize;

/// Distance from a coping face, in cells, up to which a border vertex counts
/// as lying on it. Borders end on the face to rounding; faces of one feature
/// are a wall apart.
const REACH: f64 = 1e-3;

/// A connected piece of coping without any border on it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosedOver {
    /// Lowest triangle of it, as tag files count for a file of triangles.
    pub triangle: u32,
    /// How many it has.
    pub triangles: usize,
    /// Their area, square part units.
    pub area: f64,
    /// Low corner of the box around it.
    pub min: [f64; 3],
    /// High corner of it.
    pub max: [f64; 3],
}

/// All pieces of coping, connected through edges, that no coping border lies
/// on, in order of their lowest triangle: what was smaller than some two cells
/// (a vent, a small hole) was closed over there.
///
/// A small feature whose coping adjoins that of a larger one belongs to one
/// piece with it and is not told apart.
pub fn closed_over(part: &Part, surface: &MidSurface, cell: f64) -> Vec<ClosedOver> {
    let mesh = part.mesh();
    let faces: Vec<u32> = (0..mesh.triangles.len() as u32)
        .filter(|&face| part.coping()[face as usize])
        .collect();
    if faces.is_empty() {
        return Vec::new();
    }
    let coping = TriMesh {
        positions: mesh.positions.clone(),
        triangles: faces
            .iter()
            .map(|&face| mesh.triangles[face as usize])
            .collect(),
    };
    let (label, count) = coping.edges().components(faces.len());
    let reached = reached(&coping, surface, REACH * cell, &label, count);
    let mut pieces: Vec<(ClosedOver, Bounds)> = Vec::new();
    let mut place = vec![usize::MAX; count];
    for (face, (&source, &label)) in coping.faces().zip(faces.iter().zip(&label)) {
        let label = label as usize;
        if reached[label] {
            continue;
        }
        if place[label] == usize::MAX {
            place[label] = pieces.len();
            let piece = ClosedOver {
                triangle: source,
                triangles: 0,
                area: 0.0,
                min: [0.0; 3],
                max: [0.0; 3],
            };
            pieces.push((piece, Bounds::EMPTY));
        }
        let (piece, bounds) = &mut pieces[place[label]];
        piece.triangles += 1;
        piece.area += coping.triangle_area(face);
        *bounds = coping.corners(face).into_iter().fold(*bounds, Bounds::with);
    }
    // A piece without area has no border, and nothing to close over.
    pieces
        .into_iter()
        .filter(|(piece, _)| piece.area > 0.0)
        .map(|(piece, bounds)| ClosedOver {
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            ..piece
        })
        .collect()
}

/// Which pieces have a border vertex within `reach`.
fn reached(
    coping: &TriMesh,
    surface: &MidSurface,
    reach: f64,
    label: &[u32],
    count: usize,
) -> Vec<bool> {
    let field = Field::of_tagged(coping, vec![true; coping.triangles.len()]);
    let mut reached = vec![false; count];
    for p in border_points(surface) {
        if let Some(foot) = field.nearest_coping(p, reach) {
            reached[label[foot.face.index()] as usize] = true;
        }
    }
    reached
}

/// Vertices on coping borders, ends of seams among them; some twice.
fn border_points(surface: &MidSurface) -> impl Iterator<Item = DVec3> + '_ {
    let on_lines = surface
        .borders()
        .iter()
        .filter(|border| border.kind == BorderKind::Coping)
        .flat_map(|border| border.path.iter().map(|&v| &surface.vertices()[v as usize]));
    let by_kind = surface
        .vertices()
        .iter()
        .filter(|vertex| vertex.kind == VertexKind::CopingBorder);
    on_lines.chain(by_kind).map(|vertex| vertex.position)
}

#[cfg(test)]
mod tests {
    use crate::io::{MeshFormat, read_mesh_bytes};
    use crate::mesh::PartOptions;
    use crate::surface::{Ball, MidVertex, SurfaceParts};

    use super::*;

    /// A plate of 4 x 4 x 1, its two faces across x tagged.
    fn plate() -> Part {
        let text = "\
            v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 1\nv 4 0 1\nv 4 4 1\nv 0 4 1\n\
            f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 4 1 5 8\nf 2 3 7 6\n";
        let loaded =
            read_mesh_bytes(text.as_bytes(), MeshFormat::Obj, "plate.obj".as_ref()).unwrap();
        let coping = loaded.source.iter().map(|&facet| facet >= 4).collect();
        Part::new(loaded.mesh, coping, PartOptions::default())
            .unwrap()
            .0
    }

    fn borders_at(points: &[DVec3]) -> MidSurface {
        let vertex = |&position: &DVec3| MidVertex {
            position,
            kind: VertexKind::CopingBorder,
            ball: Ball::default(),
        };
        MidSurface::new(SurfaceParts {
            vertices: points.iter().map(vertex).collect(),
            ..SurfaceParts::default()
        })
        .unwrap()
    }

    #[test]
    fn faces_without_a_border_are_named() {
        let left = DVec3::new(0.0, 2.0, 0.5);
        let right = DVec3::new(4.0, 2.0, 0.5);
        let part = plate();
        assert_eq!(closed_over(&part, &borders_at(&[left, right]), 1.0), []);
        let missing = closed_over(&part, &borders_at(&[left]), 1.0);
        assert_eq!(missing.len(), 1);
        assert_eq!((missing[0].triangle, missing[0].triangles), (10, 2));
        assert_eq!(missing[0].area, 4.0);
        assert_eq!(
            (missing[0].min, missing[0].max),
            ([4.0, 0.0, 0.0], [4.0, 4.0, 1.0])
        );
        // Near is not on.
        let near = borders_at(&[left, right - 0.01 * DVec3::X]);
        assert_eq!(closed_over(&part, &near, 1.0).len(), 1);
        assert_eq!(closed_over(&part, &MidSurface::default(), 1.0).len(), 2);
    }
}
