//! Whether tags belong to a mesh.

use super::error::Located;
use super::error::TagProblem;
use super::rule::MeshCheck;
use crate::io::LoadedMesh;

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
        let found = loaded.geometry();
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
