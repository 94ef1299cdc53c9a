//! Edits that do not make triangles pass through each other.
//!
//! An edit looks at the triangles around it alone; that another sheet passes
//! there shows in the whole. So the whole is looked at once all edits are made,
//! and where triangles cut each other that did not before, the edits are made
//! again without those beside that place.

use glam::DVec3;

use crate::mesh::{FaceId, self_intersections};
use crate::surface::marked::MarkedMesh;

/// Places where nothing is edited: balls by centre and radius.
#[derive(Clone, Debug, Default)]
pub struct Kept(Vec<(DVec3, f64)>);

impl Kept {
    /// Whether a vertex at a place stays, with its triangles.
    pub(super) fn contains(&self, p: DVec3) -> bool {
        self.0.iter().any(|(centre, r)| p.distance(*centre) <= *r)
    }

    /// Keeps the surroundings of two triangles: a ball `wide` times as wide as
    /// their corners need.
    fn keep(&mut self, mesh: &MarkedMesh, pair: (FaceId, FaceId), wide: f64) {
        let corners = [pair.0, pair.1].map(|f| mesh.triangles[f.index()]);
        let places = || (corners.iter().flatten()).map(|&v| mesh.vertices[v as usize].at);
        let centre = places().sum::<DVec3>() / 6.0;
        let radius = places().map(|p| p.distance(centre)).fold(0.0, f64::max);
        self.0.push((centre, wide * radius));
    }
}

/// Edits a mesh so that no more pairs of its triangles pass through each other
/// than before; as it was, if even edits far from such places do.
pub fn without_cuts(
    mesh: MarkedMesh,
    edit: impl Fn(&MarkedMesh, &Kept) -> MarkedMesh,
) -> MarkedMesh {
    const ROUNDS: i32 = 5;
    let cuts = |mesh: &MarkedMesh| self_intersections(&mesh.plain());
    let mut kept = Kept::default();
    let mut before = None;
    for round in 0..ROUNDS {
        let edited = edit(&mesh, &kept);
        let found = cuts(&edited);
        if found.is_empty() || found.len() <= *before.get_or_insert_with(|| cuts(&mesh).len()) {
            return edited;
        }
        for pair in found {
            kept.keep(&edited, pair, 1.5 * 2_f64.powi(round));
        }
    }
    mesh
}
