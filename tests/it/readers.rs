//! Mesh readers on good, odd and broken files.

use glam::DVec3;
use midsurf::io::{MeshFormat, Place, read_mesh};
use midsurf::mesh::{FaceId, Part, PartOptions, TriMesh};
use midsurf::tags::read_tags;
use proptest::prelude::*;

use crate::common::{cuboid, fixture, obj_text, read, soup, stl_bytes};

/// Name, triangles, coping triangles, volume and area of the closed mesh, as
/// the generator of the parts states them.
const FIXTURES: [(&str, usize, usize, f64, f64); 24] = [
    ("boss_gussets", 418, 121, 6995.048947, 7353.536336),
    ("box_divider", 44, 14, 17064.0, 17884.0),
    ("box_tube", 32, 16, 10000.0, 10400.0),
    ("bracket", 908, 448, 5049.463127, 7269.373752),
    ("cross", 44, 28, 7800.0, 8312.0),
    ("cylinder_shell", 360, 180, 10034.955047, 10546.68603),
    ("ell", 20, 12, 5500.0, 5920.0),
    ("ell_bend", 108, 56, 5369.638966, 5785.624168),
    ("enclosure", 2588, 988, 30256.117019, 33342.384718),
    ("hemisphere_shell", 2094, 90, 5012.321143, 5270.621551),
    ("ibeam", 44, 28, 11520.0, 12144.0),
    ("open_box", 28, 8, 13632.0, 13992.0),
    ("plate", 12, 8, 4800.0, 5200.0),
    ("plate_holes", 416, 204, 4235.194066, 4852.567684),
    ("plate_round_edge", 172, 84, 6878.184263, 4052.452051),
    ("plate_tapered", 12, 8, 7200.0, 5401.499766),
    ("rib_grid", 140, 72, 11056.0, 11476.0),
    ("slanted_45", 28, 18, 6622.72078, 7059.784705),
    ("tee", 28, 18, 6400.0, 6856.0),
    ("tee_filleted", 116, 62, 6448.885388, 6793.37472),
    ("tee_rotated", 28, 18, 6400.0, 6856.0),
    ("tee_thick_web", 28, 18, 6637.5, 6840.5),
    ("tee_thin_web", 28, 18, 7762.5, 6960.5),
    ("wavy_rib", 4658, 324, 4651.184508, 6197.013226),
];

#[test]
fn every_fixture_is_a_part_without_warnings() {
    for (name, triangles, coping, volume, area) in FIXTURES {
        let file = fixture(&format!("{name}.obj"));
        let loaded = read_mesh(&file).unwrap();
        assert_eq!(loaded.mesh.triangles.len(), triangles, "{name}");
        assert!(loaded.warnings.is_empty(), "{name}");
        let tag_file = fixture(&format!("{name}.coping.txt"));
        let tags = read_tags(tag_file, &loaded, &file).unwrap();
        let (part, warnings) = Part::new(loaded.mesh, tags.flags, PartOptions::default()).unwrap();
        assert_eq!(warnings, [], "{name}");
        assert!(part.is_closed(), "{name}");
        assert_eq!(part.coping_count(), coping, "{name}");
        assert!((part.volume() / volume - 1.0).abs() < 1e-8, "{name}");
        assert!((part.area() / area - 1.0).abs() < 1e-8, "{name}");
    }
}

#[test]
fn obj_and_stl_of_one_part_agree() {
    let obj = read_mesh(fixture("tee.obj")).unwrap();
    let stl = read_mesh(fixture("tee.stl")).unwrap();
    assert_eq!(soup(&obj.mesh), soup(&stl.mesh));
    assert_eq!(stl.mesh.positions.len(), obj.mesh.positions.len());
    assert_eq!(obj.names_of(FaceId(0)).groups, ["face_0"]);
    assert_eq!(obj.names_of(FaceId(0)).object.as_deref(), Some("tee"));
    assert_eq!(obj.place_of(FaceId(0)), Place::Line(20));
    assert_eq!(stl.place_of(FaceId(2)), Place::Byte(184));
}

/// The box that the odd files below hold.
fn small_box() -> TriMesh {
    cuboid(DVec3::new(-1.0, 0.0, 0.5), DVec3::new(2.0, 3.0, 0.25))
}

fn check_obj(text: &[u8]) {
    let expected = small_box();
    let loaded = read(MeshFormat::Obj, text).unwrap();
    assert_eq!(soup(&loaded.mesh), soup(&expected));
}

#[test]
fn obj_oddities_do_not_matter() {
    let plain = obj_text(&small_box());
    check_obj(plain.as_bytes());
    check_obj(format!("\u{feff}{plain}").as_bytes());
    check_obj(plain.replace('\n', "\r\n").as_bytes());
    check_obj(plain.replace('\n', "\r").as_bytes());
    check_obj(plain.replace(' ', " \\\n ").as_bytes());
    check_obj(plain.replace(' ', "\t ").as_bytes());
    check_obj(plain.trim_end().as_bytes());
    // Comments, also after values and with a path that ends in a backslash.
    check_obj(format!("# made in C:\\\n#\n\n{}", plain.replace('\n', " # x\n")).as_bytes());
    // Points and lines are no faces.
    check_obj(format!("{plain}p 1\nl 1 2 3\n").as_bytes());
    // Texture and normal indices, even of missing ones.
    check_obj(plain.replace("f 1 ", "f 1/7 ").as_bytes());
    check_obj(plain.replace("f 1 ", "f 1//3 ").as_bytes());
    check_obj(plain.replace("f 1 ", "f 1/2/3 ").as_bytes());
    // Colours behind coordinates.
    check_obj(plain.replace(" 0.5\n", " 0.5 1 0 0.5\n").as_bytes());
    // Names that are no UTF-8.
    let mut latin = b"o R\xfcckwand\n".to_vec();
    latin.extend(plain.as_bytes());
    check_obj(&latin);
    let loaded = read(MeshFormat::Obj, &latin).unwrap();
    assert_eq!(
        loaded.names_of(FaceId(0)).object.as_deref(),
        Some("Rückwand")
    );
}

#[test]
fn obj_indices_may_count_backwards_or_run_ahead() {
    let mesh = small_box();
    let mut backwards = String::new();
    let mut ahead = String::new();
    for p in &mesh.positions {
        backwards += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(i64::from)) {
        backwards += &format!("f {} {} {}\n", a - 8, b - 8, c - 8);
        ahead += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    for p in &mesh.positions {
        ahead += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    check_obj(backwards.as_bytes());
    check_obj(ahead.as_bytes());
}

#[test]
fn obj_names_stay_with_their_faces() {
    let text = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
f 1 2 3\n\
g rim top\nusemtl steel\nf 1 2 3 4\n\
g\nf 1 3 4\n\
o second part\ng rim top\nf 2 3 4\nf 1 2 4\n";
    let loaded = read(MeshFormat::Obj, text.as_bytes()).unwrap();
    // The quadrangle makes two triangles.
    assert_eq!(loaded.source, [0, 1, 1, 2, 3, 4]);
    assert_eq!(loaded.facet_count(), 5);
    assert_eq!(loaded.names_of(FaceId(0)).all().count(), 0);
    for triangle in [1, 2] {
        let names: Vec<_> = loaded.names_of(FaceId(triangle)).all().collect();
        assert_eq!(names, ["rim", "top", "steel"]);
    }
    assert_eq!(loaded.names_of(FaceId(3)).groups, ["default"]);
    let names: Vec<_> = loaded.names_of(FaceId(5)).all().collect();
    assert_eq!(names, ["rim", "top", "second part", "steel"]);
    assert_eq!(loaded.names.sets().len(), 4);
    assert_eq!(loaded.place_of(FaceId(2)), Place::Line(8));
}

#[test]
fn obj_polygons_are_triangulated() {
    // Prism over an L with a corner in the middle of a side: two polygons of
    // seven corners and quadrangles around.
    let outline = [(0, 0), (2, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)];
    let mut text = String::new();
    for z in [0, 2] {
        for (x, y) in outline {
            text += &format!("v {x} {y} {z}\n");
        }
    }
    text += "f 7 6 5 4 3 2 1\nf 8 9 10 11 12 13 14\n";
    for k in 1..=7 {
        let next = k % 7 + 1;
        text += &format!("f {k} {next} {} {}\n", next + 7, k + 7);
    }
    let loaded = read(MeshFormat::Obj, text.as_bytes()).unwrap();
    assert_eq!(loaded.facet_count(), 9);
    assert_eq!(loaded.mesh.triangles.len(), 5 + 5 + 14);
    let flags = vec![false; 24];
    let (part, _) = Part::new(loaded.mesh, flags, PartOptions::default()).unwrap();
    assert!(part.is_closed());
    assert_eq!(part.volume(), 14.0);
    assert_eq!(part.area(), 7.0 * 2.0 + 16.0 * 2.0);
}

#[test]
fn stl_is_told_by_size_not_by_its_first_word() {
    let mesh = small_box();
    for header in ["", "solid part", "COLOR=abcd"] {
        let loaded = read(MeshFormat::Stl, &stl_bytes(&mesh, header)).unwrap();
        assert_eq!(soup(&loaded.mesh), soup(&mesh));
        assert_eq!(loaded.mesh.positions.len(), 8);
    }
}

fn stl_text(mesh: &TriMesh, name: &str) -> String {
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

#[test]
fn stl_text_may_hold_several_solids_in_any_case() {
    let mesh = small_box();
    let text = stl_text(&mesh, "first one") + &stl_text(&mesh, "second").to_uppercase();
    for text in [
        text.clone(),
        text.replace('\n', "\r\n"),
        format!("\n {text}"),
    ] {
        let loaded = read(MeshFormat::Stl, text.as_bytes()).unwrap();
        let triangles = soup(&loaded.mesh);
        assert_eq!(triangles[..12], soup(&mesh));
        assert_eq!(triangles[12..], soup(&mesh));
        let name = |triangle| loaded.names_of(FaceId(triangle)).object.as_deref();
        assert_eq!(name(0), Some("first one"));
        assert_eq!(name(12), Some("SECOND"));
    }
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

fn ply_binary(mesh: &TriMesh, big: bool, double: bool) -> Vec<u8> {
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

fn ply_text(mesh: &TriMesh) -> String {
    let mut text = ply_header("ascii", "double", "vertex_index", mesh);
    for p in &mesh.positions {
        text += &format!("{} {} {} 255\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("-7 3 {a} {b} {c}\n");
    }
    text + "5\n"
}

#[test]
fn ply_of_every_encoding_gives_the_same() {
    let mesh = small_box();
    for bytes in [
        ply_text(&mesh).into_bytes(),
        ply_text(&mesh).replace('\n', "\r\n").into_bytes(),
        ply_text(&mesh).replace('\n', "\r").into_bytes(),
        ply_text(&mesh).replace(" 0.", " .").into_bytes(),
        ply_text(&mesh).replace("-1 ", "-1. ").into_bytes(),
        ply_binary(&mesh, false, false),
        ply_binary(&mesh, false, true),
        ply_binary(&mesh, true, false),
        ply_binary(&mesh, true, true),
    ] {
        let loaded = read(MeshFormat::Ply, &bytes).unwrap();
        assert_eq!(loaded.mesh, mesh);
        assert_eq!(loaded.facet_count(), 12);
    }
    // Places of faces: 14 lines of header, 8 of vertices; bytes likewise.
    let text = read(MeshFormat::Ply, ply_text(&mesh).as_bytes()).unwrap();
    assert_eq!(text.place_of(FaceId(1)), Place::Line(14 + 8 + 2));
    let bytes = ply_binary(&mesh, false, false);
    let binary = read(MeshFormat::Ply, &bytes).unwrap();
    let faces = bytes.len() - 4 - 12 * 15;
    assert_eq!(binary.place_of(FaceId(1)), Place::Byte(faces as u64 + 15));
}

#[test]
fn off_with_comments_and_colours() {
    let mesh = small_box();
    let mut rows = String::new();
    for p in &mesh.positions {
        rows += &format!("{} {} {} # a corner\n\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        rows += &format!("3 {a} {b} {c} 255 0 0\n");
    }
    for head in [
        "OFF\n# counts\n8 12 0\n",
        "OFF 8 12 0\n",
        "8 12 0\n",
        "COFF\n8 12\n",
    ] {
        let loaded = read(MeshFormat::Off, format!("{head}{rows}").as_bytes()).unwrap();
        assert_eq!(loaded.mesh, mesh);
    }
}

/// A broken file, where the error should point, and a word of its message.
fn refused(format: MeshFormat, bytes: &[u8], place: Place, message: &str) {
    let error = match read(format, bytes) {
        Ok(_) => panic!("accepted, expected {message:?}"),
        Err(error) => error,
    };
    assert!(error.to_string().contains(message), "{error}");
    assert_eq!(error.place(), place, "{error}");
    assert!(error.to_string().starts_with("given"), "{error}");
}

#[test]
fn broken_obj_files_are_refused_with_their_line() {
    use Place::{Line, Whole};
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, place, message) in [
        ("", Whole, "empty"),
        (" \n\n", Whole, "empty"),
        ("<!DOCTYPE html>\n<html></html>", Whole, "web page"),
        ("\n<HTML lang=en>", Whole, "web page"),
        ("PK\x03\x04zip", Whole, "ZIP"),
        ("hello world\nfoo", Line(1), "\"hello\" starts no OBJ"),
        (triangle, Whole, "no faces"),
        ("v 0 0\n", Line(1), "z is missing"),
        ("v 0 0 nan\n", Line(1), "not a finite number"),
        ("v 0 inf 0\n", Line(1), "not a finite number"),
        ("v 0 0 0\r\rv 1e400 0 0\r", Line(3), "1e400"),
        ("v 0 0,5 0\n", Line(1), "\"0,5\" is not a number"),
        ("v 0 0 0\0\nf 1 1 1\n", Line(1), "binary data"),
        (
            &format!("{triangle}f 1 2 4\n"),
            Line(4),
            "vertex 4 does not exist",
        ),
        (
            &format!("{triangle}f 1 2 3\nf 0 1 2\n"),
            Line(5),
            "vertex 0",
        ),
        (&format!("{triangle}f -1 -2 -4\n"), Line(4), "vertex -4"),
        (
            &format!("{triangle}f 1 2 99999999999\n"),
            Line(4),
            "99999999999",
        ),
        (
            &format!("{triangle}f 1 2 99999999999999999999\n"),
            Line(4),
            "not a vertex index",
        ),
        (
            &format!("{triangle}f 1 2 x\n"),
            Line(4),
            "\"x\" is not a vertex index",
        ),
        (
            &format!("{triangle}f 1/2/3/4 2 3\n"),
            Line(4),
            "not a vertex index",
        ),
        (&format!("{triangle}f 1 2\n"), Line(4), "three corners"),
        (&format!("{triangle}f\n"), Line(4), "three corners"),
    ] {
        refused(MeshFormat::Obj, text.as_bytes(), place, message);
    }
    refused(MeshFormat::Obj, b"\xff\xfev\0 \0", Whole, "UTF-16");
}

#[test]
fn broken_stl_files_are_refused_with_their_place() {
    use Place::{Byte, Line, Whole};
    let mesh = small_box();
    let good = stl_bytes(&mesh, "solid x");
    refused(MeshFormat::Stl, b"", Whole, "empty");
    refused(
        MeshFormat::Stl,
        &good[..good.len() - 1],
        Byte(84 + 11 * 50),
        "claims 12 facets",
    );
    refused(MeshFormat::Stl, &good[..50], Byte(50), "at least 84 bytes");
    let mut lying = good.clone();
    lying[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    refused(
        MeshFormat::Stl,
        &lying,
        Byte(84 + 12 * 50),
        "claims 4294967295 facets",
    );
    let mut nan = good.clone();
    nan[84 + 50 + 12 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    refused(MeshFormat::Stl, &nan, Byte(84 + 50 + 24), "finite");
    refused(
        MeshFormat::Stl,
        &stl_bytes(&TriMesh::default(), ""),
        Whole,
        "no faces",
    );
    refused(
        MeshFormat::Stl,
        b"<html><body>not found</body></html>",
        Whole,
        "web page",
    );

    let text = stl_text(&mesh, "x");
    let cut = text.find("    endloop").unwrap();
    refused(
        MeshFormat::Stl,
        text[..cut].as_bytes(),
        Line(6),
        "ends too early",
    );
    refused(
        MeshFormat::Stl,
        text.replace("endfacet", "endfacets").as_bytes(),
        Line(8),
        "expected `endfacet`",
    );
    refused(
        MeshFormat::Stl,
        text.replacen("vertex -1 ", "vertex NaN ", 1).as_bytes(),
        Line(4),
        "finite",
    );
    refused(
        MeshFormat::Stl,
        text.replacen("vertex -1 ", "vertex ", 1).as_bytes(),
        Line(4),
        "three coordinates",
    );
    refused(
        MeshFormat::Stl,
        b"solid empty\nendsolid empty\n",
        Whole,
        "no faces",
    );
}

#[test]
fn broken_ply_files_are_refused_with_their_place() {
    use Place::{Byte, Line, Whole};
    let mesh = small_box();
    let text = ply_text(&mesh);
    let replaced = |from: &str, to: &str| text.replacen(from, to, 1).into_bytes();
    let ply = MeshFormat::Ply;
    refused(ply, b"plx\n", Line(1), "starts with the line");
    refused(ply, b"ply\nformat ascii 1.0\n", Line(3), "end_header");
    refused(
        ply,
        &replaced("element vertex 8", "element vertex x"),
        Line(4),
        "parse",
    );
    refused(
        ply,
        &replaced("element vertex 8", "element vertex 9"),
        Line(23),
        "",
    );
    refused(
        ply,
        &replaced("element vertex 8", "element vertex 99999999999999999999"),
        Line(4),
        "",
    );
    refused(
        ply,
        &replaced("element vertex", "element point"),
        Whole,
        "`vertex`",
    );
    refused(
        ply,
        &replaced("property double y", "property double yy"),
        Whole,
        "`y`",
    );
    refused(
        ply,
        &replaced("list uchar int vertex_index", "list uchar int strip"),
        Whole,
        "vertex_indices",
    );
    refused(
        ply,
        &replaced(
            "list uchar int vertex_index",
            "list uchar float vertex_index",
        ),
        Whole,
        "floating point",
    );
    refused(
        ply,
        &replaced("-7 3 0 2 3", "-7 3 0 2 8"),
        Line(23),
        "vertex 8 does not exist",
    );
    refused(
        ply,
        &replaced("-7 3 0 2 3", "-7 3 0 -2 3"),
        Line(23),
        "vertex -2 does not exist",
    );
    refused(
        ply,
        &replaced("-7 3 0 2 3", "-7 2 0 2"),
        Line(23),
        "three corners",
    );
    refused(ply, &replaced("-7 3 0 2 3", "-7 3 0 2"), Line(23), "");
    refused(
        ply,
        &replaced("-1 0 0.5 255", "-1 nan 0.5 255"),
        Line(15),
        "finite",
    );
    refused(
        ply,
        &replaced("-1 0 0.5 255", "-1 1e999 0.5 255"),
        Line(15),
        "finite",
    );

    let binary = ply_binary(&mesh, false, false);
    let end = binary.len() as u64;
    refused(
        ply,
        &binary[..binary.len() - 5],
        Byte(end - 4 - 15),
        "ends too early",
    );
    let header = |count: &str| {
        let text = String::from_utf8_lossy(&binary[..300]).into_owned();
        let start = text.find("end_header").unwrap() + 11;
        let mut bytes = text[..start]
            .replace("vertex 8", &format!("vertex {count}"))
            .into_bytes();
        bytes.extend(&binary[start..]);
        (bytes, start + count.len() - 1)
    };
    let (lying, start) = header("1000000000000");
    refused(
        ply,
        &lying,
        Byte(start as u64),
        "claims 1000000000000 vertices",
    );
    let none = b"ply\nformat binary_little_endian 1.0\nelement junk 99999999\n\
element vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
element face 1\nproperty list uchar int vertex_index\nend_header\n0000000000000";
    refused(ply, none, Whole, "no properties");
}

#[test]
fn broken_off_files_are_refused_with_their_place() {
    use Place::{Byte, Line};
    let off = MeshFormat::Off;
    refused(off, b"OFX\n", Line(1), "starts with the word OFF");
    refused(off, b"OFF\n3 x 0\n", Line(2), "not a count");
    refused(off, b"OFF\n9999999999 1 0\n", Line(2), "claims");
    refused(off, b"OFF\n3 1 0\n0 0 0\n1 0 0\n", Byte(22), "too early");
    refused(
        off,
        b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1\n3 0 1 2\n",
        Line(5),
        "three coordinates",
    );
    refused(
        off,
        b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n",
        Line(5),
        "finite",
    );
    refused(
        off,
        b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
        Line(6),
        "vertex 3",
    );
    refused(
        off,
        b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n",
        Line(6),
        "4 corners",
    );
    refused(off, b"OFF BINARY\n3 1 0\n", Line(1), "binary");
}

const FORMATS: [MeshFormat; 4] = [
    MeshFormat::Obj,
    MeshFormat::Stl,
    MeshFormat::Ply,
    MeshFormat::Off,
];

/// Reads and, if that goes well, checks: neither may panic.
fn survive(format: MeshFormat, bytes: &[u8]) {
    if let Ok(loaded) = read(format, bytes) {
        assert_eq!(loaded.source.len(), loaded.mesh.triangles.len());
        let flags = vec![false; loaded.mesh.triangles.len()];
        for weld in [None, Some(0.01)] {
            let options = PartOptions {
                allow_open: true,
                weld,
            };
            let _ = Part::new(loaded.mesh.clone(), flags.clone(), options);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        for format in FORMATS {
            survive(format, &bytes);
        }
    }

    #[test]
    fn random_words_never_panic(words in proptest::collection::vec(
        prop_oneof![
            Just("v "), Just("f "), Just("g "), Just("\n"), Just("-1 "), Just("1 "), Just("2/ "),
            Just("3 "), Just("0.5 "), Just("\\\n"), Just("OFF\n"), Just("ply\n"), Just("nan "),
            Just("solid "), Just("facet "), Just("outer loop\n"), Just("vertex 1 2 3\n"),
            Just("endloop\n"), Just("endfacet\n"), Just("endsolid\n"), Just("\r"), Just("#"),
        ], 0..60)) {
        let text = words.concat();
        for format in FORMATS {
            survive(format, text.as_bytes());
        }
    }

    #[test]
    fn damaged_files_never_panic(
        kind in 0..6usize,
        cut in 0.0..1.0f64,
        damage in proptest::collection::vec((0.0..1.0f64, any::<u8>()), 0..6),
    ) {
        let mesh = small_box();
        let (format, mut bytes) = match kind {
            0 => (MeshFormat::Obj, obj_text(&mesh).into_bytes()),
            1 => (MeshFormat::Stl, stl_bytes(&mesh, "solid")),
            2 => (MeshFormat::Stl, stl_text(&mesh, "x").into_bytes()),
            3 => (MeshFormat::Ply, ply_text(&mesh).into_bytes()),
            4 => (MeshFormat::Ply, ply_binary(&mesh, false, true)),
            _ => (MeshFormat::Ply, ply_binary(&mesh, true, false)),
        };
        for (at, value) in damage {
            let at = (at * bytes.len() as f64) as usize;
            bytes[at] = value;
        }
        survive(format, &bytes);
        bytes.truncate((cut * bytes.len() as f64) as usize);
        survive(format, &bytes);
    }

    #[test]
    fn coordinates_survive_as_they_are(values in proptest::collection::vec(-1e9..1e9f64, 24)) {
        let mut mesh = small_box();
        for (p, v) in mesh.positions.iter_mut().zip(values.chunks_exact(3)) {
            *p = DVec3::from_slice(v);
        }
        let loaded = read(MeshFormat::Obj, obj_text(&mesh).as_bytes()).unwrap();
        prop_assert_eq!(soup(&loaded.mesh), soup(&mesh));
        let loaded = read(MeshFormat::Ply, ply_text(&mesh).as_bytes()).unwrap();
        prop_assert_eq!(&loaded.mesh, &mesh);
    }
}
