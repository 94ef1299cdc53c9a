//! Bodies that overlap or touch made one solid.
//!
//! A part of several bodies, or one that cuts itself, encloses the points about
//! which its surface winds once or more. What of the surface lies inside that
//! solid bounds nothing, and an engine that measures distances from it goes
//! wrong. The crate `manifold-rust` cuts the triangles along each other (exact
//! rational arithmetic, winding numbers by cell; Zhou, Grinspun, Zorin and
//! Jacobson, "Mesh arrangements for solid geometry", 2016), and says of each
//! piece which triangle it is from, so that coping tags go along.

use glam::DVec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{BooleanEngine, Error, MeshGL64, WindingRule};
use thiserror::Error;

use super::{Part, PartError, PartOptions, TriMesh};

/// No channel of the crate's meshes holds normals.
const NO_NORMALS: i32 = -1;

/// Why bodies could not be united.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum UniteError {
    /// The part has no inside.
    #[error("the part is open, so its bodies cannot be told from each other")]
    Open,
    /// Nothing is enclosed.
    #[error("the part encloses nothing once its bodies are united")]
    Empty,
    /// The arrangement was given up.
    #[error("the part's bodies could not be united ({0})")]
    Failed(&'static str),
    /// What came out is no part.
    #[error("the united part: {0}")]
    Part(#[from] PartError),
}

impl Part {
    /// The part with all its bodies in one: its surface is the boundary of what
    /// its own surface winds about, and meets itself at most along edges and in
    /// vertices. Pieces of coping stay coping.
    ///
    /// Vertices and triangles are new ones, flat regions of several triangles
    /// may have fewer.
    ///
    /// # Errors
    ///
    /// [`UniteError`].
    pub fn united(&self) -> Result<Part, UniteError> {
        if !self.closed {
            return Err(UniteError::Open);
        }
        let (mesh, sources) = cleared(&self.mesh)?;
        let coping = self.coping_of(&sources);
        let (part, _) = Part::new(mesh, coping, PartOptions::default())?;
        Ok(part)
    }

    fn coping_of(&self, sources: &[u32]) -> Vec<bool> {
        let flag = |&face: &u32| self.coping.get(face as usize).copied();
        sources
            .iter()
            .map(|face| flag(face).unwrap_or(false))
            .collect()
    }
}

/// A closed mesh without what of its surface lies inside the solid that it
/// encloses, and for each triangle the one that it is a piece of.
///
/// # Errors
///
/// [`UniteError`]: where the mesh is not closed, or encloses nothing.
pub fn cleared(closed: &TriMesh) -> Result<(TriMesh, Vec<u32>), UniteError> {
    let bodies = Manifold::from_mesh_gl64_robust(&soup(closed));
    check(&bodies)?;
    let solid = bodies.rebuild_solid(WindingRule::Positive);
    check(&solid)?;
    let solid = solid.get_mesh_gl64(NO_NORMALS);
    if solid.tri_verts.is_empty() {
        return Err(UniteError::Empty);
    }
    let sources = solid.face_id.iter().map(|&face| face as u32).collect();
    Ok((mesh(&solid), sources))
}

/// What is left of a closed mesh outside another one.
///
/// # Errors
///
/// [`UniteError`]: where one is not closed, or nothing is left.
pub fn without(solid: &TriMesh, tool: &TriMesh) -> Result<TriMesh, UniteError> {
    let [solid, tool] = [solid, tool].map(|closed| Manifold::from_mesh_gl64_robust(&soup(closed)));
    check(&solid)?;
    check(&tool)?;
    let left = solid.difference_with_engine(&tool, BooleanEngine::Auto);
    check(&left)?;
    let left = left.get_mesh_gl64(NO_NORMALS);
    if left.tri_verts.is_empty() {
        return Err(UniteError::Empty);
    }
    Ok(mesh(&left))
}

/// The triangles, each named by its place.
fn soup(mesh: &TriMesh) -> MeshGL64 {
    MeshGL64 {
        num_prop: 3,
        vert_properties: mesh.positions.iter().flat_map(|p| p.to_array()).collect(),
        tri_verts: mesh
            .triangles
            .iter()
            .flatten()
            .map(|&v| u64::from(v))
            .collect(),
        face_id: (0..mesh.triangles.len() as u64).collect(),
        ..MeshGL64::default()
    }
}

fn mesh(soup: &MeshGL64) -> TriMesh {
    let width = soup.num_prop as usize;
    let positions = soup.vert_properties.chunks_exact(width);
    let triangles = soup.tri_verts.chunks_exact(3);
    TriMesh {
        positions: positions.map(DVec3::from_slice).collect(),
        triangles: triangles
            .map(|t| [t[0] as u32, t[1] as u32, t[2] as u32])
            .collect(),
    }
}

fn check(solid: &Manifold) -> Result<(), UniteError> {
    match solid.status() {
        Error::NoError => Ok(()),
        error => Err(UniteError::Failed(error.to_str())),
    }
}
