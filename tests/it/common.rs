//! Small meshes and files that several rooms use.

use std::path::{Path, PathBuf};

use glam::DVec3;
use midsurf::io::{LoadedMesh, MeshFormat, ReadError, read_mesh_bytes};
use midsurf::mesh::TriMesh;

/// A file of the `fixtures` folder.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name)
}

/// Box of size `size` from `corner`, outward oriented.
///
/// ```text
///     6 ---- 7      z
///    /|     /|      | y
///   4 ---- 5 |      |/
///   | 2 ---|-3      +-- x
///   |/     |/
///   0 ---- 1
/// ```
pub fn cuboid(corner: DVec3, size: DVec3) -> TriMesh {
    let positions = (0..8)
        .map(|k| {
            let step = DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64);
            corner + step * size
        })
        .collect();
    let quads: [[u32; 4]; 6] = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    TriMesh {
        positions,
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// Both meshes as one, without welding.
pub fn join(a: &TriMesh, b: &TriMesh) -> TriMesh {
    let mut mesh = a.clone();
    let shift = a.positions.len() as u32;
    mesh.positions.extend_from_slice(&b.positions);
    mesh.triangles
        .extend(b.triangles.iter().map(|t| t.map(|v| v + shift)));
    mesh
}

/// The mesh inside out.
pub fn inverted(mesh: &TriMesh) -> TriMesh {
    let mut mesh = mesh.clone();
    for corners in &mut mesh.triangles {
        corners.swap(1, 2);
    }
    mesh
}

/// Corner positions of all triangles: what a mesh is, whatever its numbering.
pub fn soup(mesh: &TriMesh) -> Vec<[DVec3; 3]> {
    mesh.faces().map(|face| mesh.corners(face)).collect()
}

pub fn read(format: MeshFormat, bytes: &[u8]) -> Result<LoadedMesh, ReadError> {
    read_mesh_bytes(bytes, format, Path::new("given"))
}

/// OBJ text of a mesh.
pub fn obj_text(mesh: &TriMesh) -> String {
    let mut text = String::new();
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text
}

/// Binary STL of a mesh, under the given header.
pub fn stl_bytes(mesh: &TriMesh, header: &str) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes[..header.len()].copy_from_slice(header.as_bytes());
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for face in mesh.faces() {
        bytes.extend([0; 12]);
        for p in mesh.corners(face) {
            for x in p.to_array() {
                bytes.extend((x as f32).to_le_bytes());
            }
        }
        bytes.extend([0, 0]);
    }
    bytes
}
