//! A checksum of what a mesh is, not of how its file says it.

use sha2::{Digest, Sha256};

use super::text::hex;
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
    hex(&hash.finalize())
}
