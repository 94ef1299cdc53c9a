//! What a part is, before anything is made of it: its counts and measures, and
//! how thick its walls are, with a map of that.
//!
//! [`Shape::of`] looks at the triangles alone; [`Walls::of`] makes the distance
//! field once, for all that is asked of the walls.

mod map;
#[cfg(test)]
mod tests;
mod thickness;

use serde::Serialize;

use crate::field::Field;
use crate::mesh::{EdgeCensus, Part};

pub use map::ThicknessMap;
pub use thickness::{WallCheck, WallThickness};

/// Counts and measures of a part, in part units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shape {
    /// Triangles, those of no area too.
    pub triangles: usize,
    /// Vertices.
    pub vertices: usize,
    /// Triangles that are tagged as coping.
    pub coping_triangles: usize,
    /// Whether every edge has as many triangles on one side as on the other.
    pub watertight: bool,
    /// Edges of one triangle.
    pub open_edges: usize,
    /// Edges of more than two.
    pub non_manifold_edges: usize,
    /// Pieces that hang together by edges; a triangle with a repeated corner is
    /// no piece of its own.
    pub components: usize,
    /// Vertices less edges plus triangles.
    pub euler: i64,
    /// Signed, by orientation.
    pub volume: f64,
    /// Of all triangles.
    pub area: f64,
    /// Of those that are not coping.
    pub wall_area: f64,
    /// Least corner of the box.
    pub min: [f64; 3],
    /// Greatest corner of the box.
    pub max: [f64; 3],
    /// Of the box.
    pub diagonal: f64,
}

impl Shape {
    /// Measures a part.
    pub fn of(part: &Part) -> Shape {
        let mesh = part.mesh();
        let uses = mesh.edges();
        let EdgeCensus {
            open,
            balanced,
            unbalanced,
            ..
        } = uses.census();
        let (labels, _) = uses.components(mesh.triangles.len());
        let whole = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let labels = labels.into_iter().zip(&mesh.triangles);
        let mut pieces: Vec<u32> = labels.filter(|(_, t)| whole(t)).map(|(l, _)| l).collect();
        let faces = pieces.len() as i64;
        pieces.sort_unstable();
        pieces.dedup();
        let edges = uses.by_edge().count() as i64;
        let walls = mesh.faces().filter(|face| !part.coping()[face.index()]);
        let bounds = part.bounds();
        Shape {
            triangles: part.triangle_count(),
            vertices: mesh.positions.len(),
            coping_triangles: part.coping_count(),
            watertight: part.is_closed(),
            open_edges: open,
            non_manifold_edges: balanced + unbalanced,
            components: pieces.len(),
            euler: mesh.positions.len() as i64 - edges + faces,
            volume: part.volume(),
            area: part.area(),
            wall_area: walls.map(|face| mesh.triangle_area(face)).sum(),
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            diagonal: bounds.diagonal(),
        }
    }
}

/// The walls of a part, ready to be asked.
#[derive(Debug)]
pub struct Walls<'p> {
    part: &'p Part,
    field: Field,
}

impl<'p> Walls<'p> {
    /// Prepares the distance field.
    pub fn of(part: &'p Part) -> Walls<'p> {
        Walls {
            part,
            field: Field::new(part),
        }
    }

    /// How thick the walls are; none where no wall faces another. With
    /// `min_wall`, a length in part units, whether they are thick enough too.
    pub fn thickness(&self, min_wall: Option<f64>) -> Option<WallThickness> {
        WallThickness::measure(self.part, &self.field, min_wall)
    }

    /// The thickness all over the walls.
    pub fn map(&self) -> ThicknessMap {
        ThicknessMap::measure(self.part, &self.field)
    }
}
