//! From the pieces in each tetrahedron to one non-manifold mesh.

pub mod mesh;
pub mod polygon;
pub mod tet;
