//! Vertices in which fans of triangles touch that have no edge in common.

use super::Repair;
use crate::mesh::TriMesh;
use crate::mesh::error::PartWarning;
use crate::mesh::sets::Sets;

/// Gives every fan beyond the first a vertex of its own at the same place.
///
/// Corners of triangles hang together where the triangles share an edge at them.
pub(super) fn part(mesh: &mut TriMesh) -> Option<Repair> {
    let mut sets = Sets::new(3 * mesh.triangles.len());
    let corner = |mesh: &TriMesh, face: usize, v: u32| {
        let at = mesh.triangles[face].iter().position(|&w| w == v);
        (3 * face + at.unwrap_or(0)) as u32
    };
    for uses in mesh.edges().by_edge() {
        for pair in uses.windows(2) {
            for v in pair[0].edge {
                let [a, b] = [&pair[0], &pair[1]].map(|one| corner(mesh, one.face.index(), v));
                sets.join(a, b);
            }
        }
    }
    let (fan, count) = sets.labels();
    // Vertex of each fan, and the first fan of each vertex.
    let mut vertex_of = vec![None; count];
    let mut taken = vec![false; mesh.positions.len()];
    let mut places = Vec::new();
    for face in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.triangles[face];
        if a == b || b == c || c == a {
            continue;
        }
        for k in 0..3 {
            let v = mesh.triangles[face][k];
            let own = vertex_of[fan[3 * face + k] as usize].get_or_insert_with(|| {
                if !std::mem::replace(&mut taken[v as usize], true) {
                    return v;
                }
                let at = mesh.positions[v as usize];
                mesh.positions.push(at);
                places.push(at);
                mesh.positions.len() as u32 - 1
            });
            mesh.triangles[face][k] = *own;
        }
    }
    let vertices = places.len();
    (vertices > 0).then(|| Repair::at(PartWarning::Unpinched { vertices }, places))
}
