//! Whether tags belong to a mesh.

use sha2::{Digest, Sha256};

use super::error::Located;
use super::error::TagProblem;
use super::rule::MeshCheck;
use crate::io::LoadedMesh;
use crate::mesh::TriMesh;

/// Checksum of a mesh's triangles that survives a change of file format and
/// of triangle order: coordinates rounded to single precision, each triangle
/// begun at its lowest corner, triangles sorted, SHA-256 in hexadecimal.
pub fn geometry_checksum(mesh: &TriMesh) -> String {
    let mut triangles: Vec<[[u32; 3]; 3]> = mesh
        .faces()
        .map(|face| {
            // Adding zero makes one zero of both.
            let mut corners = mesh
                .corners(face)
                .map(|p| p.to_array().map(|x| (x as f32 + 0.0).to_bits()));
            let lowest = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
            corners.rotate_left(lowest);
            corners
        })
        .collect();
    triangles.sort_unstable();
    let mut hash = Sha256::new();
    for word in triangles.as_flattened().as_flattened() {
        hash.update(word.to_le_bytes());
    }
    crate::io::hex(&hash.finalize())
}

/// Refuses tags made for another mesh.
pub(super) fn check(wanted: &MeshCheck, loaded: &LoadedMesh, mesh: &str) -> Result<(), Located> {
    let other = |what, expected: &str, found: String| TagProblem::OtherMesh {
        what,
        expected: expected.to_owned(),
        found,
        mesh: mesh.to_owned(),
    };
    if let Some((facets, span)) = &wanted.facets
        && *facets != loaded.facet_count() as u64
    {
        let found = loaded.facet_count().to_string();
        let problem = other("the number of triangles", &facets.to_string(), found);
        return Err((span.clone(), problem));
    }
    if let Some((geometry, span)) = &wanted.geometry {
        let found = geometry_checksum(&loaded.mesh);
        if !geometry.eq_ignore_ascii_case(&found) {
            return Err((
                span.clone(),
                other("the geometry checksum", geometry, found),
            ));
        }
    }
    if let Some((sha256, span)) = &wanted.sha256
        && !sha256.eq_ignore_ascii_case(&loaded.sha256)
    {
        let found = loaded.sha256.clone();
        return Err((span.clone(), other("the sha256 of the file", sha256, found)));
    }
    Ok(())
}
