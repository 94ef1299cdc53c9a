//! Tags made on the page, as an ordinary tag file.

use std::fmt::Write;

use crate::mesh::{Bounds, FaceId, TriMesh};

/// The TOML form of tags that marks the facets of the flagged triangles: one rule
/// for each piece that hangs together, by index, with where it is and how large.
///
/// `source` gives the facet of each triangle, ascending; a facet is coping if one
/// of its triangles is.
pub(super) fn tag_file(
    mesh: &TriMesh,
    source: &[u32],
    coping: &[bool],
    file: &str,
    geometry: &str,
) -> String {
    let facets = source.last().map_or(0, |&last| last + 1);
    let mut text = format!(
        "format = \"coping-tags\"\nversion = 1\n\n[mesh]\nfile = {}\ntriangles = {facets}\ngeometry = \"{geometry}\"\n",
        quoted(file)
    );
    for (n, piece) in pieces(mesh, coping).iter().enumerate() {
        let area: f64 = piece.iter().map(|&face| mesh.triangle_area(face)).sum();
        let bounds = Bounds::of(piece.iter().flat_map(|&face| mesh.corners(face)));
        let middle = 0.5 * (bounds.min + bounds.max);
        let [x, y, z] = middle.to_array().map(|v| format!("{v:.4}"));
        let _ = write!(
            text,
            "\n[[coping]]\nname = \"piece {} at ({x}, {y}, {z}), area {area:.4}\"\ntriangles = [{}]\n",
            n + 1,
            ranges(piece, source)
        );
    }
    text
}

/// Flagged triangles that hang together through edges, in order of the lowest.
fn pieces(mesh: &TriMesh, coping: &[bool]) -> Vec<Vec<FaceId>> {
    let welded = crate::mesh::weld_exact(&mesh.positions).apply(mesh);
    let chosen: Vec<FaceId> = mesh.faces().filter(|face| coping[face.index()]).collect();
    let marked = TriMesh {
        positions: welded.positions.clone(),
        triangles: (chosen.iter().map(|face| welded.triangles[face.index()])).collect(),
    };
    let (label, count) = marked.edges().components(chosen.len());
    let mut pieces = vec![Vec::new(); count];
    for (face, label) in chosen.into_iter().zip(label) {
        pieces[label as usize].push(face);
    }
    pieces
}

/// The facets of some triangles as `"a-b"` or plain numbers.
fn ranges(piece: &[FaceId], source: &[u32]) -> String {
    let mut facets: Vec<u32> = piece.iter().map(|face| source[face.index()]).collect();
    facets.dedup();
    let runs = facets.chunk_by(|&a, &b| b == a + 1);
    let word = |run: &[u32]| match run {
        [first, .., last] => format!("\"{first}-{last}\""),
        _ => run.iter().map(u32::to_string).collect(),
    };
    runs.map(word).collect::<Vec<String>>().join(", ")
}

/// A basic string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::tag_file;
    use crate::coping::{geometry_checksum, read_tags_bytes};
    use crate::io::{MeshFormat, read_mesh_bytes};

    /// What is written marks what was marked, whatever the file's facets are.
    #[test]
    fn saved_tags_are_read_back() {
        let text = "\
            v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 0 0 1\nv 4 0 1\nv 4 4 1\nv 0 4 1\n\
            f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 4 1 5 8\nf 2 3 7 6\n";
        let name = "a \"b\"\\c.obj";
        let loaded = read_mesh_bytes(text.as_bytes(), MeshFormat::Obj, name.as_ref()).unwrap();
        let geometry = geometry_checksum(&loaded.mesh);
        let coping: Vec<bool> = loaded
            .source
            .iter()
            .map(|&f| [1, 4, 5].contains(&f))
            .collect();
        let tags = tag_file(&loaded.mesh, &loaded.source, &coping, name, &geometry);
        assert_eq!(tags.matches("[[coping]]").count(), 1, "{tags}");
        let read = read_tags_bytes(tags.as_bytes(), &loaded, "t.toml".as_ref(), name.as_ref());
        assert_eq!(read.unwrap().flags, coping);
        let apart: Vec<bool> = loaded.source.iter().map(|&f| f >= 4).collect();
        let tags = tag_file(&loaded.mesh, &loaded.source, &apart, name, &geometry);
        assert_eq!(tags.matches("[[coping]]").count(), 2, "{tags}");
        let read = read_tags_bytes(tags.as_bytes(), &loaded, "t.toml".as_ref(), name.as_ref());
        assert_eq!(read.unwrap().flags, apart);
    }
}
