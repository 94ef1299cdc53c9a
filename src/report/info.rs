//! What a part is, in figures.

use std::collections::HashSet;

use serde::Serialize;

use super::thickness::WallThickness;
use crate::intake::Input;
use crate::io::{NameSet, Unit};
use crate::mesh::EdgeCensus;
use crate::settings::warning::Warning;

/// What a part is.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The file.
    pub part: String,
    /// SHA-256 of the file's bytes.
    pub sha256: String,
    /// Checksum of the geometry alone.
    pub geometry: String,
    /// Facets of the file.
    pub facets: usize,
    /// Triangles.
    pub triangles: usize,
    /// Vertices.
    pub vertices: usize,
    /// Triangles tagged as coping.
    pub coping_triangles: usize,
    /// Whether every edge is run equally often both ways.
    pub watertight: bool,
    /// Edges of one triangle only.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Pieces that hang together over edges.
    pub components: usize,
    /// Vertices less edges plus triangles.
    pub euler: i64,
    /// Enclosed volume.
    pub volume: f64,
    /// Area of all triangles.
    pub area: f64,
    /// Area of those that are not coping.
    pub wall_area: f64,
    /// Lowest corner of the box.
    pub min: [f64; 3],
    /// Highest corner of the box.
    pub max: [f64; 3],
    /// Diagonal of the box.
    pub diagonal: f64,
    /// Unit of all lengths, where it is known.
    pub unit: Option<Unit>,
    /// Groups that the file names.
    pub groups: Vec<String>,
    /// Objects that the file names.
    pub objects: Vec<String>,
    /// Materials that the file names.
    pub materials: Vec<String>,
    /// Wall thickness; none where no wall faces another.
    pub thickness: Option<WallThickness>,
    /// What was odd.
    pub warnings: Vec<Warning>,
}

impl Info {
    /// Of a part whose walls were measured.
    pub fn of(input: &Input, thickness: Option<WallThickness>) -> Info {
        let part = &input.part;
        let mesh = part.mesh();
        let uses = mesh.edges();
        let EdgeCensus {
            open,
            balanced,
            unbalanced,
            ..
        } = uses.census();
        // A triangle with a repeated corner is no shell of its own.
        let (labels, _) = uses.components(mesh.triangles.len());
        let whole = |&[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let labels = labels.into_iter().zip(&mesh.triangles);
        let mut shells: Vec<u32> = labels.filter(|(_, t)| whole(t)).map(|(l, _)| l).collect();
        let triangles = shells.len() as i64;
        shells.sort_unstable();
        shells.dedup();
        let edges = uses.by_edge().count() as i64;
        let bounds = part.bounds();
        let wall_area = mesh
            .faces()
            .filter(|face| !part.coping()[face.index()])
            .map(|face| mesh.triangle_area(face))
            .sum();
        let sets = input.names.sets();
        let object = |set: &NameSet| set.object.clone();
        let material = |set: &NameSet| set.material.clone();
        Info {
            part: input.file.to_string_lossy().into_owned(),
            sha256: input.sha256.clone(),
            geometry: input.geometry.clone(),
            facets: input.facets,
            triangles: part.triangle_count(),
            vertices: mesh.positions.len(),
            coping_triangles: part.coping_count(),
            watertight: part.is_closed(),
            open_edges: open,
            non_manifold_edges: balanced + unbalanced,
            components: shells.len(),
            euler: mesh.positions.len() as i64 - edges + triangles,
            volume: part.volume(),
            area: part.area(),
            wall_area,
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            diagonal: bounds.diagonal(),
            unit: input.unit,
            groups: unique(sets.iter().flat_map(|set| set.groups.clone())),
            objects: unique(sets.iter().filter_map(object)),
            materials: unique(sets.iter().filter_map(material)),
            thickness,
            warnings: input.warnings.clone(),
        }
    }
}

/// Each name once, in order of first use.
fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = HashSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}
