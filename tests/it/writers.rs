//! Mid-surface writers: what is written can be read, and appears whole.

use std::path::Path;

use glam::DVec3;
use midsurf::io::write::{
    SurfaceFormat, SurfaceOptions, WriteError, files_for, stage, stage_surface, write_surface,
};
use midsurf::io::{MeshFormat, read_mesh};
use midsurf::mesh::FaceId;
use midsurf::surface::{
    Ball, Border, BorderKind, MidSurface, MidTriangle, MidVertex, Seam, SurfaceParts, VertexKind,
};

use crate::common::read;

/// Three sheets that meet in a seam of two vertices, as at a T.
pub fn three_sheets() -> MidSurface {
    let at = |x: f64, y: f64, z: f64, kind| MidVertex {
        position: DVec3::new(x, y, z),
        kind,
        ball: Ball {
            radius: 1.0,
            thickness: 2.0 + 0.1 * x,
            footpoints: [DVec3::new(x, y, z + 1.0), DVec3::new(x, y, z - 1.0)]
                .into_iter()
                .collect(),
        },
    };
    use VertexKind::{CopingBorder, FadingBorder, Junction};
    let vertices = vec![
        at(0.0, 0.0, 0.0, Junction),
        at(0.0, 1.0 / 3.0, 0.0, Junction),
        at(-1.0, 0.0, 0.0, CopingBorder),
        at(1.0, 0.0, 1e-17, CopingBorder),
        at(0.0, 0.0, -1.0, FadingBorder),
    ];
    MidSurface::new(SurfaceParts {
        vertices,
        triangles: [[0, 1, 2], [1, 0, 3], [0, 1, 4]]
            .into_iter()
            .zip([2, 0, 1])
            .map(|(corners, sheet)| MidTriangle { corners, sheet })
            .collect(),
        seams: vec![Seam {
            path: vec![0, 1],
            sheets: vec![0, 1, 2],
            closed: false,
            unmarked: 0,
        }],
        borders: vec![
            Border {
                path: vec![1, 2, 0],
                sheet: 2,
                kind: BorderKind::Coping,
                closed: false,
            },
            Border {
                path: vec![0, 3, 1],
                sheet: 0,
                kind: BorderKind::Coping,
                closed: false,
            },
            Border {
                path: vec![1, 4, 0],
                sheet: 1,
                kind: BorderKind::Fading,
                closed: false,
            },
        ],
        junctions: vec![0, 1],
        creases: vec![],
    })
    .unwrap()
}

fn written(format: SurfaceFormat, options: SurfaceOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_surface(&three_sheets(), format, options, &mut bytes).unwrap();
    bytes
}

#[test]
fn obj_has_a_group_a_sheet_and_exact_coordinates() {
    let bytes = written(SurfaceFormat::Obj, SurfaceOptions::default());
    let loaded = read(MeshFormat::Obj, &bytes).unwrap();
    let surface = three_sheets();
    // Grouped by sheet: the second triangle comes first.
    let order = [1, 2, 0];
    for (face, &original) in loaded.mesh.faces().zip(&order) {
        let triangle = surface.triangles()[original];
        let expected = triangle
            .corners
            .map(|v| surface.vertices()[v as usize].position);
        assert_eq!(loaded.mesh.corners(face), expected);
        let group = format!("sheet_{}", triangle.sheet);
        assert_eq!(loaded.names_of(face).groups, [group]);
    }
    let text = String::from_utf8(bytes).unwrap();
    assert!(!text.contains("\nl "), "no lines unless asked for");
}

#[test]
fn obj_lines_are_there_when_asked_for() {
    let bytes = written(SurfaceFormat::Obj, SurfaceOptions { obj_lines: true });
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains("g seam_0\nl 1 2\n"), "{text}");
    assert!(text.contains("g coping_border_0\nl 2 3 1\n"), "{text}");
    assert!(text.contains("g fading_border_2\nl 2 5 1\n"), "{text}");
    assert_eq!(read(MeshFormat::Obj, &bytes).unwrap().facet_count(), 3);
}

#[test]
fn a_closed_line_returns_to_its_start() {
    // One triangle, all its edges one border.
    let mut parts = three_sheets().into_parts();
    parts.triangles.truncate(1);
    parts.triangles[0].sheet = 0;
    parts.seams.clear();
    parts.borders.truncate(1);
    parts.borders[0].sheet = 0;
    parts.borders[0].closed = true;
    let surface = MidSurface::new(parts).unwrap();
    let mut bytes = Vec::new();
    let options = SurfaceOptions { obj_lines: true };
    write_surface(&surface, SurfaceFormat::Obj, options, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("g coping_border_0\nl 2 3 1 2\n"), "{text}");
}

#[test]
fn ply_round_trips() {
    let bytes = written(SurfaceFormat::Ply, SurfaceOptions::default());
    let loaded = read(MeshFormat::Ply, &bytes).unwrap();
    let surface = three_sheets();
    let positions: Vec<DVec3> = surface.vertices().iter().map(|v| v.position).collect();
    assert_eq!(loaded.mesh.positions, positions);
    let triangles: Vec<_> = surface.triangles().iter().map(|t| t.corners).collect();
    assert_eq!(loaded.mesh.triangles, triangles);
    // Thickness, radius and kind of the last vertex, sheet of the last face.
    let faces = bytes.len() - 7 * 9 - 3 * 17;
    assert_eq!(bytes[faces - 1], 4);
    assert_eq!(bytes[faces - 9..faces - 1], 1.0f64.to_le_bytes());
    assert_eq!(bytes[faces - 17..faces - 9], 2.0f64.to_le_bytes());
    assert_eq!(loaded.values.radius, [1.0; 5]);
    assert_eq!(bytes[bytes.len() - 7 * 9 - 4..][..4], 1u32.to_le_bytes());
    // A seam, two coping borders and a fading one between seam vertices.
    let edges = [
        ([0, 1], 1.0),
        ([1, 2], 3.0),
        ([2, 0], 3.0),
        ([0, 3], 3.0),
        ([3, 1], 3.0),
        ([1, 4], 4.0),
        ([4, 0], 4.0),
    ];
    assert_eq!(loaded.values.edges, edges);
}

#[test]
fn stl_round_trips_in_single_precision() {
    let bytes = written(SurfaceFormat::Stl, SurfaceOptions::default());
    let loaded = read(MeshFormat::Stl, &bytes).unwrap();
    assert_eq!(loaded.facet_count(), 3);
    let third = f64::from((1.0 / 3.0) as f32);
    assert_eq!(
        loaded.mesh.corners(FaceId(0))[1],
        DVec3::new(0.0, third, 0.0)
    );
}

/// Bytes of an array of a VTU file, without their count.
fn vtu_array(text: &str, name: &str, nth: usize) -> Vec<u8> {
    let tag = format!("Name=\"{name}\"");
    let start = text.match_indices(&tag).nth(nth).unwrap().0;
    let body = text[start..].split_once(">\n").unwrap().1;
    let digits = body.split_once('\n').unwrap().0;
    let value = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut bytes = Vec::new();
    for group in digits.as_bytes().chunks(4) {
        let given = group.iter().filter(|&&c| c != b'=').count();
        let bits = group.iter().fold(0u32, |bits, &c| {
            bits << 6 | u32::from(if c == b'=' { 0 } else { value(c) })
        });
        bytes.extend(&bits.to_be_bytes()[1..given]);
    }
    let count = u64::from_le_bytes(bytes[..8].try_into().unwrap());
    assert_eq!(count as usize, bytes.len() - 8, "{name}");
    bytes.split_off(8)
}

#[test]
fn vtu_holds_triangles_then_lines() {
    let bytes = written(SurfaceFormat::Vtu, SurfaceOptions::default());
    let text = String::from_utf8(bytes).unwrap();
    assert!(
        text.contains("NumberOfPoints=\"5\" NumberOfCells=\"10\""),
        "{text}"
    );
    let integers = |name, nth| -> Vec<i32> {
        let bytes = vtu_array(&text, name, nth);
        let words = bytes.chunks_exact(4);
        words
            .map(|w| i32::from_le_bytes(w.try_into().unwrap()))
            .collect()
    };
    let longs = |name| -> Vec<i64> {
        let bytes = vtu_array(&text, name, 0);
        let words = bytes.chunks_exact(8);
        words
            .map(|w| i64::from_le_bytes(w.try_into().unwrap()))
            .collect()
    };
    let doubles = |name| -> Vec<f64> {
        let bytes = vtu_array(&text, name, 0);
        let words = bytes.chunks_exact(8);
        words
            .map(|w| f64::from_le_bytes(w.try_into().unwrap()))
            .collect()
    };
    assert_eq!(vtu_array(&text, "types", 0), [5, 5, 5, 3, 3, 3, 3, 3, 3, 3]);
    assert_eq!(longs("offsets"), [3, 6, 9, 11, 13, 15, 17, 19, 21, 23]);
    assert_eq!(
        longs("connectivity")[..11],
        [0, 1, 2, 1, 0, 3, 0, 1, 4, 0, 1]
    );
    assert_eq!(integers("sheet", 0), [2, 0, 1, -1, 2, 2, 0, 0, 1, 1]);
    assert_eq!(integers("line", 0), [-1, -1, -1, 0, 0, 0, 1, 1, 2, 2]);
    assert_eq!(vtu_array(&text, "kind", 0), [2, 2, 3, 3, 4]);
    assert_eq!(vtu_array(&text, "kind", 1), [0, 0, 0, 1, 3, 3, 3, 3, 4, 4]);
    assert_eq!(doubles("thickness"), [2.0, 2.0, 1.9, 2.1, 2.0]);
    assert_eq!(doubles("radius"), [1.0; 5]);
    for (name, way) in [("foot_1", 1.0), ("foot_2", -1.0)] {
        assert_eq!(doubles(name), [0.0, 0.0, way].repeat(5), "{name}");
    }
    assert_eq!(doubles("Points")[4], 1.0 / 3.0);
}

#[test]
fn an_empty_surface_can_be_written() {
    for format in [
        SurfaceFormat::Obj,
        SurfaceFormat::Ply,
        SurfaceFormat::Vtu,
        SurfaceFormat::Stl,
    ] {
        let mut bytes = Vec::new();
        let options = SurfaceOptions::default();
        write_surface(&MidSurface::default(), format, options, &mut bytes).unwrap();
        assert!(!bytes.is_empty());
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn files_appear_on_commit_only() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mid.obj");
    let options = SurfaceOptions::default();
    let staged = stage_surface(&three_sheets(), &file, options).unwrap();
    assert!(!file.exists());
    for one in staged {
        one.commit().unwrap();
    }
    assert_eq!(names(folder.path()), ["mid.obj", "mid.thickness.csv"]);
    assert_eq!(
        files_for(&file).unwrap(),
        [file.clone(), folder.path().join("mid.thickness.csv")]
    );
    assert_eq!(read_mesh(&file).unwrap().facet_count(), 3);
    let csv = std::fs::read_to_string(folder.path().join("mid.thickness.csv")).unwrap();
    assert_eq!(
        csv,
        "vertex_index,thickness,radius\n0,2,1\n1,2,1\n2,1.9,1\n3,2.1,1\n4,2,1\n"
    );
}

#[test]
fn failure_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.json");
    std::fs::write(&file, "old").unwrap();
    let error = stage(&file, |out| {
        out.write_all(b"half")?;
        Err(std::io::Error::other("disk full"))
    })
    .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("report.json: cannot be written: disk full")
    );
    // Staged, but given up.
    drop(stage(&file, |out| out.write_all(b"new")).unwrap());
    assert_eq!(names(folder.path()), ["report.json"]);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "old");
    stage(&file, |out| out.write_all(b"new"))
        .unwrap()
        .commit()
        .unwrap();
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
}

#[test]
fn targets_that_cannot_be_written_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let nothing = |_: &mut dyn std::io::Write| Ok(());
    let error = stage(&folder.path().join("no/mid.obj"), nothing).unwrap_err();
    assert!(matches!(error, WriteError::NoFolder { .. }), "{error}");
    let error = stage(folder.path(), nothing).unwrap_err();
    assert!(matches!(error, WriteError::NotAFile { .. }), "{error}");
    let error = files_for(&folder.path().join("mid.step")).unwrap_err();
    assert!(matches!(error, WriteError::UnknownFormat { .. }), "{error}");
}

#[cfg(unix)]
#[test]
fn permissions_and_links_are_those_of_ordinary_files() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let mode = |file: &Path| std::fs::metadata(file).unwrap().permissions().mode() & 0o777;
    let write = |file: &Path| {
        stage(file, |out| out.write_all(b"x"))
            .unwrap()
            .commit()
            .unwrap();
    };
    let plain = folder.path().join("plain");
    std::fs::write(&plain, "").unwrap();
    let new = folder.path().join("new");
    write(&new);
    assert_eq!(mode(&new), mode(&plain));
    // A file that exists keeps its mode, a link stays a link.
    std::fs::set_permissions(&plain, std::fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.path().join("link");
    symlink(&plain, &link).unwrap();
    write(&link);
    assert_eq!(mode(&plain), 0o640);
    assert_eq!(std::fs::read_to_string(&plain).unwrap(), "x");
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
}
