//! Small meshes and files that several rooms use.

use std::path::{Path, PathBuf};
use std::process::Output;

use glam::DVec3;
use midsurf::io::{LoadedMesh, MeshFormat, ReadError, read_mesh_bytes};
use midsurf::mesh::TriMesh;
use tempfile::TempDir;

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

/// The box that the odd files below hold.
pub fn small_box() -> TriMesh {
    cuboid(DVec3::new(-1.0, 0.0, 0.5), DVec3::new(2.0, 3.0, 0.25))
}

pub fn stl_text(mesh: &TriMesh, name: &str) -> String {
    let mut text = format!("solid {name}\n");
    for corners in soup(mesh) {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for p in corners {
            text += &format!("      vertex {} {:e} {}\n", p.x, p.y, p.z);
        }
        text += "    endloop\n  endfacet\n";
    }
    text + "endsolid\n"
}

fn ply_header(format: &str, float: &str, list: &str, mesh: &TriMesh) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by hand\n\
         element vertex {}\nproperty {float} x\nproperty {float} y\nproperty {float} z\n\
         property uchar red\n\
         element face {}\nproperty short quality\nproperty list uchar int {list}\n\
         element edge 1\nproperty int vertex1\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
}

pub fn ply_binary(mesh: &TriMesh, big: bool, double: bool) -> Vec<u8> {
    let format = if big {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let float = if double { "double" } else { "float" };
    let mut bytes = ply_header(format, float, "vertex_indices", mesh).into_bytes();
    let mut put = |le: &[u8]| {
        let mut word = le.to_vec();
        if big {
            word.reverse();
        }
        bytes.extend(word);
    };
    for p in &mesh.positions {
        for x in p.to_array() {
            if double {
                put(&x.to_le_bytes());
            } else {
                put(&(x as f32).to_le_bytes());
            }
        }
        put(&[255]);
    }
    for triangle in &mesh.triangles {
        put(&(-7i16).to_le_bytes());
        put(&[3]);
        for corner in triangle {
            put(&corner.to_le_bytes());
        }
    }
    put(&5i32.to_le_bytes());
    bytes
}

pub fn ply_text(mesh: &TriMesh) -> String {
    let mut text = ply_header("ascii", "double", "vertex_index", mesh);
    for p in &mesh.positions {
        text += &format!("{} {} {} 255\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("-7 3 {a} {b} {c}\n");
    }
    text + "5\n"
}

/// A folder of input files to run the command on.
pub struct Desk {
    folder: TempDir,
}

impl Desk {
    pub fn new() -> Desk {
        Desk {
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// Where a file of this name is or will be.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let file = self.path(name);
        std::fs::write(&file, content).unwrap();
        file
    }

    pub fn run(&self, args: &[&str]) -> Output {
        assert_cmd::cargo::cargo_bin_cmd!("midsurf")
            .args(args)
            .current_dir(self.folder.path())
            .env("NO_COLOR", "1")
            .output()
            .unwrap()
    }

    /// Names of all files, to see that none was added.
    pub fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }

    /// Extraction must end with code 2, say all of `words`, and add no file.
    pub fn refuses(&self, args: &[&str], words: &[&str]) {
        let mut all = vec!["extract"];
        all.extend(args);
        all.extend(["-o", "mid.obj", "-o", "mid.vtu", "--json", "report.json"]);
        self.refuses_command(&all, words);
    }

    /// A command must end with code 2, say all of `words`, and add no file.
    pub fn refuses_command(&self, args: &[&str], words: &[&str]) {
        let before = self.files();
        let output = self.run(args);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{args:?}: no {word:?} in\n{stderr}");
        }
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert!(output.stdout.is_empty());
        assert_eq!(self.files(), before, "{args:?}");
    }
}

pub fn text(output: &[u8]) -> String {
    String::from_utf8(output.to_vec()).unwrap()
}

/// Mesh and coping flags of a part in `fixtures`, by the part's name.
pub fn fixture_part(name: &str) -> (TriMesh, Vec<bool>) {
    let file = fixture(&format!("{name}.obj"));
    let loaded = midsurf::io::read_mesh(&file).unwrap();
    let tags = fixture(&format!("{name}.coping.txt"));
    let flags = midsurf::coping::read_tags(tags, &loaded, &file)
        .unwrap()
        .flags;
    (loaded.mesh, flags)
}

/// A closed solid of rings of `chords` vertices round z, given by radius, height and turn in
/// chords: each is joined to the next by twice as many triangles, the last to the first. Rings
/// that run up outside and down inside face outwards.
pub fn ringed(rings: &[(f64, f64, f64)], chords: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    for &(radius, height, turn) in rings {
        for k in 0..chords {
            let angle = std::f64::consts::TAU * (f64::from(k) + turn) / f64::from(chords);
            let at = DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
            mesh.positions.push(at);
        }
    }
    for (ring, &(.., turn)) in (0..).zip(rings) {
        let next = (ring + 1) % rings.len() as u32;
        let at = |ring: u32, k: u32| ring * chords + k % chords;
        for k in 0..chords {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(next, k), at(next, k + 1)];
            // The vertex that lies between two of the other ring is their apex.
            let pair = match turn > rings[next as usize].2 {
                true => [[a, b, d], [a, d, c]],
                false => [[a, b, c], [b, d, c]],
            };
            mesh.triangles.extend(pair);
        }
    }
    mesh
}
