//! Mesh readers on broken files: refused with place and reason, never a panic.

use midsurf::io::{MeshFormat, Place};
use midsurf::mesh::{Part, PartOptions, TriMesh};
use proptest::prelude::*;

use crate::common::{obj_text, ply_binary, ply_text, read, small_box, stl_bytes, stl_text};

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
        &text.as_bytes()[..cut],
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

    // Edges that say what they are have to exist.
    let with_edge = |edge: &str| {
        let more = "vertex1\nproperty int vertex2\nproperty uchar kind\nend_header\n";
        let text = text.replacen("vertex1\nend_header\n", more, 1);
        text.replace("\n5\n", &format!("\n{edge}\n")).into_bytes()
    };
    let read_edge = read(ply, &with_edge("7 0 3")).unwrap();
    assert_eq!(read_edge.values.edges, [([7, 0], 3.0)]);
    refused(ply, &with_edge("0 8 3"), Line(37), "8");
    refused(ply, &with_edge("0 -1 3"), Line(37), "");

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
                ..PartOptions::default()
            };
            let _ = Part::new(loaded.mesh.clone(), flags.clone(), options);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

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
}
