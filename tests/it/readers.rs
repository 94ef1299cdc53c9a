//! Mesh readers on good, odd and broken files.

use glam::DVec3;
use midsurf::coping::read_tags;
use midsurf::io::{MeshFormat, Place, read_mesh};
use midsurf::mesh::{FaceId, Part, PartOptions};
use proptest::prelude::*;

use crate::common::{
    fixture, obj_text, ply_binary, ply_text, read, small_box, soup, stl_bytes, stl_text,
};

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

/// The header with line ends as DOS has them, the body as it is.
fn crlf_header(bytes: Vec<u8>) -> Vec<u8> {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = String::from_utf8(bytes[..at].to_vec()).unwrap();
    let mut whole = header.replace('\n', "\r\n").into_bytes();
    whole.extend(&bytes[at..]);
    whole
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
        crlf_header(ply_binary(&mesh, false, false)),
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

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

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
