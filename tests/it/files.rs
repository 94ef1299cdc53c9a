//! Files as people have them: several solids, units, glTF, binary MSH, coloured 3MF.

use std::io::Write;

use base64::Engine;
use glam::DVec3;
use midsurf::io::{LoadedMesh, MeshFormat, Unit, read_mesh};
use midsurf::mesh::TriMesh;
use serde_json::{Value, json};

use crate::common::{Desk, cuboid, fixture, read, stl_text, text};

fn plate() -> TriMesh {
    cuboid(DVec3::ZERO, DVec3::new(20.0, 12.0, 2.0))
}

fn report(desk: &Desk, args: &[&str]) -> Value {
    let output = desk.run(&[args, &["--json", "-", "-q"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn codes(report: &Value) -> Vec<String> {
    let warnings = report["warnings"].as_array().unwrap();
    let code = |w: &Value| w["code"].as_str().unwrap().to_owned();
    warnings.iter().map(code).collect()
}

#[test]
fn one_solid_of_several_by_number_or_name() {
    let desk = Desk::new();
    let far = cuboid(DVec3::X * 50.0, DVec3::new(8.0, 8.0, 1.0));
    desk.put(
        "two.stl",
        stl_text(&plate(), "plate") + &stl_text(&far, "tile 1"),
    );
    let volume = |solid: &str| {
        let args = [
            "info", "two.stl", "--coping", "none", "--json", "--solid", solid,
        ];
        let output = desk.run(&args);
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        told["volume"].as_f64().unwrap()
    };
    assert_eq!(volume("plate"), 480.0);
    assert_eq!(volume("1"), 480.0);
    assert_eq!(volume("tile 1"), 64.0);
    assert_eq!(volume("2"), 64.0);
    assert_eq!(volume("all"), 544.0);
    // Tags keep counting the facets of the file.
    desk.put("tags.txt", "12-23\n");
    let output = desk.run(&["tags", "two.stl", "tags.txt", "--solid", "2", "--json"]);
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(told["coping"]["triangles"], 12, "{told}");
    let output = desk.run(&["info", "two.stl", "--solid", "3"]);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(told.contains("\"plate\", \"tile 1\""), "{told}");
}

#[test]
fn a_mid_surface_is_remeshed_on_its_solid_of_several() {
    let desk = Desk::new();
    let far = cuboid(DVec3::X * 50.0, DVec3::new(8.0, 8.0, 1.0));
    desk.put(
        "two.stl",
        stl_text(&plate(), "plate") + &stl_text(&far, "tile"),
    );
    let extract = ["extract", "two.stl", "--solid", "tile", "-o", "mid.ply"];
    report(&desk, &extract);
    let mesh = [
        "mesh",
        "mid.ply",
        "--part",
        "two.stl",
        "--solid",
        "tile",
        "--element-size",
        "2",
    ];
    let told = report(&desk, &mesh);
    assert_eq!(told["settings"]["solid"], "tile");
    let area = told["result"]["area"].as_f64().unwrap();
    assert!((area - 64.0).abs() < 1e-9, "{area}");
    let there_and_back = ["roundtrip", "two.stl", "--body", "tile"];
    let told = report(&desk, &there_and_back);
    assert_eq!(told["settings"]["solid"], "tile");
    let volume = told["input"]["volume"].as_f64().unwrap();
    assert!((volume - 64.0).abs() < 1e-9, "{told}");
}

#[test]
fn scale_changes_numbers_and_unit_none() {
    let desk = Desk::new();
    std::fs::copy(fixture("plate.obj"), desk.path("plate.obj")).unwrap();
    let plain = report(&desk, &["extract", "plate.obj"]);
    let scaled = report(
        &desk,
        &["extract", "plate.obj", "--scale", "10", "--unit", "mm"],
    );
    let area = |told: &Value| told["result"]["area"].as_f64().unwrap();
    assert!((area(&scaled) / area(&plain) - 100.0).abs() < 1e-9);
    assert_eq!(scaled["input"]["unit"], "mm");
    assert!(plain["input"]["unit"].is_null());
    // The file is the same one: tags that are bound to it fit.
    assert_eq!(scaled["input"]["geometry"], plain["input"]["geometry"]);
    for args in [["--scale", "0"], ["--scale", "nan"], ["--unit", "parsec"]] {
        let output = desk.run(&[&["extract", "plate.obj"][..], &args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn tags_in_other_units_are_told() {
    let desk = Desk::new();
    let metres = TriMesh {
        positions: plate().positions.iter().map(|p| 1e-3 * *p).collect(),
        ..plate()
    };
    desk.put("plate.obj", crate::common::obj_text(&metres));
    let head = "format = \"coping-tags\"\nversion = 1\n[[coping]]\n";
    let near = format!("{head}near = {{ point = [20, 6, 1], grow_angle = 20 }}\n");
    desk.put("near.toml", &near);
    let output = desk.run(&["extract", "plate.obj", "--coping", "near.toml"]);
    let told = text(&output.stderr);
    assert!(told.contains("--scale 1000"), "{told}");
    let told = report(
        &desk,
        &[
            "extract",
            "plate.obj",
            "--coping",
            "near.toml",
            "--scale",
            "1000",
        ],
    );
    assert!(!codes(&told).contains(&"other_units".to_owned()), "{told}");
    // A box that selects nothing says so too.
    let boxed = format!("{head}box = {{ min = [19.9, -1, -1], max = [20.1, 13, 3] }}\n");
    desk.put("box.toml", boxed);
    let output = desk.run(&["extract", "plate.obj", "--coping", "box.toml"]);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2));
    assert!(told.contains("--scale 1000"), "{told}");
}

/// A plate in glTF: its upper half as a strip-free primitive with vertices of its own,
/// placed by a node with a turn, a scale and a shift.
fn gltf(uri: Option<&str>) -> (Value, Vec<u8>) {
    let mesh = plate();
    let mut data: Vec<u8> = Vec::new();
    for face in mesh.faces() {
        for p in mesh.corners(face) {
            // Halved: the node doubles it. Turned back by a quarter about z.
            let q = 0.5 * DVec3::new(p.y, -p.x, p.z);
            data.extend(q.to_array().iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
    }
    let points = data.len();
    let corners = 3 * mesh.triangles.len();
    data.extend((0..corners as u16).flat_map(u16::to_le_bytes));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [1] }],
        "nodes": [
            { "name": "plate", "mesh": 0, "scale": [2, 2, 2] },
            { "children": [0], "rotation": [0, 0, half, half], "translation": [1, 2, 3] },
        ],
        "meshes": [{ "name": "geometry", "primitives": [
            { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 },
        ] }],
        "materials": [{ "name": "steel" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": corners, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": corners, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": points },
            { "buffer": 0, "byteOffset": points, "byteLength": data.len() - points },
        ],
        "buffers": [{ "byteLength": data.len() }],
    });
    if let Some(uri) = uri {
        document["buffers"][0]["uri"] = json!(uri);
    }
    (document, data)
}

fn glb(document: &Value, data: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = data.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let total = (12 + 8 + text.len() + 8 + data.len()) as u32;
    let word = |n: usize| (n as u32).to_le_bytes();
    [
        &b"glTF"[..],
        &word(2),
        &total.to_le_bytes(),
        &word(text.len()),
        b"JSON",
        &text,
        &word(data.len()),
        b"BIN\0",
        &data,
    ]
    .concat()
}

fn is_plate(loaded: &LoadedMesh) {
    assert_eq!(loaded.mesh.triangles.len(), 12);
    assert_eq!(loaded.mesh.positions.len(), 8);
    assert!(loaded.mesh.edges().census().is_closed());
    assert!((loaded.mesh.volume() - 480.0).abs() < 1e-3);
    let low = loaded.mesh.bounds().min;
    assert!(low.distance(DVec3::new(1.0, 2.0, 3.0)) < 1e-5, "{low}");
    assert_eq!(loaded.unit, Some(Unit::Metre));
    assert_eq!(loaded.names.of(0).object.as_deref(), Some("plate"));
    assert_eq!(loaded.names.of(0).material.as_deref(), Some("steel"));
}

#[test]
fn gltf_comes_as_its_scene_places_it() {
    let (document, data) = gltf(None);
    is_plate(&read(MeshFormat::Gltf, &glb(&document, &data)).unwrap());
    let inside = base64::engine::general_purpose::STANDARD.encode(&data);
    let inside = format!("data:application/octet-stream;base64,{inside}");
    let (document, _) = gltf(Some(&inside));
    is_plate(&read(MeshFormat::Gltf, document.to_string().as_bytes()).unwrap());
    let desk = Desk::new();
    let (document, data) = gltf(Some("plate.bin"));
    desk.put("plate.bin", &data);
    let file = desk.put("plate.gltf", document.to_string());
    is_plate(&read_mesh(&file).unwrap());
}

#[test]
fn bad_gltf_is_refused_in_words() {
    let (document, data) = gltf(None);
    let with = |pointer: &str, value: Value| {
        let mut document = document.clone();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match document.pointer_mut(parent).unwrap() {
            Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
            object => object[key] = value,
        }
        let error = read(MeshFormat::Gltf, &glb(&document, &data)).unwrap_err();
        error.to_string()
    };
    for (pointer, value, words) in [
        ("/accessors/0/count", json!(1_u64 << 40), "past the end"),
        ("/accessors/0/componentType", json!(5), "no known type"),
        ("/accessors/1/count", json!(3000), "past the end"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), "past the end"),
        ("/bufferViews/1/buffer", json!(7), "buffer 7"),
        ("/nodes/1/children", json!([0, 1]), "twice"),
        ("/nodes/1/children", json!([9]), "node 9"),
        ("/nodes/0/mesh", json!(4), "mesh 4"),
        ("/nodes/0/scale", json!([1e308, 1e308, 1e308]), "finite"),
        ("/meshes", json!("none"), "no glTF"),
        ("/buffers/0", json!({ "uri": "../secret.bin" }), "elsewhere"),
        ("/buffers/0", json!({ "uri": "/etc/passwd" }), "elsewhere"),
        ("/buffers/0", json!({ "uri": "data:;base64,?" }), "base64"),
    ] {
        let told = with(pointer, value);
        assert!(told.contains(words), "{pointer}: {told}");
    }
    let mut packed = document.clone();
    packed["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let told = read(MeshFormat::Gltf, &glb(&packed, &data))
        .unwrap_err()
        .to_string();
    assert!(told.contains("without compression"), "{told}");
    let whole = glb(&document, &data);
    for length in [3, 11, 15, 40, whole.len() - 1] {
        assert!(
            read(MeshFormat::Gltf, &whole[..length]).is_err(),
            "{length}"
        );
    }
}

/// The shell models written for viewers come back: sheets as objects.
#[test]
fn glb_that_was_written_is_read() {
    let desk = Desk::new();
    let tee = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let [tee, tags] = [&tee, &tags].map(|file| file.to_str().unwrap());
    let args = [
        "extract", tee, "--coping", tags, "-o", "mid.glb", "-o", "mid.obj",
    ];
    assert_eq!(desk.run(&args).status.code(), Some(0));
    let glb = read_mesh(desk.path("mid.glb")).unwrap();
    let obj = read_mesh(desk.path("mid.obj")).unwrap();
    assert_eq!(glb.mesh.triangles.len(), obj.mesh.triangles.len());
    assert!((glb.mesh.area() / obj.mesh.area() - 1.0).abs() < 1e-5);
    assert_eq!(glb.solids(), ["SHEET_1", "SHEET_2", "SHEET_3"]);
}

/// The same mesh in both forms of both versions of MSH, in either byte order.
#[test]
fn binary_msh_is_what_ascii_says() {
    let mesh = plate();
    let ascii = |version: &str| {
        let mut text = format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n");
        text += "$PhysicalNames\n1\n2 7 \"rim\"\n$EndPhysicalNames\n";
        if version == "4.1" {
            text +=
                "$Entities\n0 0 1 1\n3 0 0 0 20 12 2 1 7 0\n5 0 0 0 20 12 2 0 1 3\n$EndEntities\n";
            text += "$Nodes\n1 8 1 8\n2 3 0 8\n";
            (1..=8).for_each(|n| text += &format!("{n}\n"));
            for p in &mesh.positions {
                text += &format!("{} {} {}\n", p.x, p.y, p.z);
            }
            text += "$EndNodes\n$Elements\n2 13 1 13\n0 3 15 1\n1 1\n2 3 2 12\n";
            for (n, t) in mesh.triangles.iter().enumerate() {
                text += &format!("{} {} {} {}\n", n + 2, t[0] + 1, t[1] + 1, t[2] + 1);
            }
        } else {
            text += "$Nodes\n8\n";
            for (n, p) in mesh.positions.iter().enumerate() {
                text += &format!("{} {} {} {}\n", n + 1, p.x, p.y, p.z);
            }
            text += "$EndNodes\n$Elements\n13\n1 15 2 0 3 1\n";
            for (n, t) in mesh.triangles.iter().enumerate() {
                text += &format!("{} 2 2 7 3 {} {} {}\n", n + 2, t[0] + 1, t[1] + 1, t[2] + 1);
            }
        }
        (text + "$EndElements\n").into_bytes()
    };
    for version in ["4.1", "2.2"] {
        let said = read(MeshFormat::Msh, &ascii(version)).unwrap();
        assert_eq!(said.mesh, mesh);
        for big in [false, true] {
            let bytes = binary_msh(&mesh, version, big);
            let loaded = read(MeshFormat::Msh, &bytes).unwrap();
            assert_eq!(loaded.mesh, said.mesh, "{version} {big}");
            assert_eq!(loaded.names, said.names, "{version} {big}");
            // Cut anywhere it is refused or less, and never a panic.
            for length in (60..bytes.len()).step_by(7) {
                let _ = read(MeshFormat::Msh, &bytes[..length]);
            }
            assert!(read(MeshFormat::Msh, &bytes[..bytes.len() - 40]).is_err());
        }
    }
}

fn binary_msh(mesh: &TriMesh, version: &str, big: bool) -> Vec<u8> {
    let mut bytes = format!("$MeshFormat\n{version} 1 8\n").into_bytes();
    let put = |bytes: &mut Vec<u8>, le: &[u8]| {
        let mut word = le.to_vec();
        if big {
            word.reverse();
        }
        bytes.extend(word);
    };
    let int = |bytes: &mut Vec<u8>, n: i32| put(bytes, &n.to_le_bytes());
    let size = |bytes: &mut Vec<u8>, n: u64| put(bytes, &n.to_le_bytes());
    let real = |bytes: &mut Vec<u8>, x: f64| put(bytes, &x.to_le_bytes());
    int(&mut bytes, 1);
    bytes.extend(b"\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"rim\"\n$EndPhysicalNames\n");
    let corners = [0.0, 0.0, 0.0, 20.0, 12.0, 2.0];
    if version == "4.1" {
        bytes.extend(b"$Entities\n");
        [0, 0, 1, 1].iter().for_each(|&n| size(&mut bytes, n));
        int(&mut bytes, 3);
        corners.iter().for_each(|&x| real(&mut bytes, x));
        size(&mut bytes, 1);
        int(&mut bytes, 7);
        size(&mut bytes, 0);
        int(&mut bytes, 5);
        corners.iter().for_each(|&x| real(&mut bytes, x));
        size(&mut bytes, 0);
        size(&mut bytes, 1);
        int(&mut bytes, -3);
        bytes.extend(b"\n$EndEntities\n$Nodes\n");
        [1, 8, 1, 8].iter().for_each(|&n| size(&mut bytes, n));
        // With parameters of the surface behind every point.
        [2, 3, 1].iter().for_each(|&n| int(&mut bytes, n));
        size(&mut bytes, 8);
        (1..=8).for_each(|n| size(&mut bytes, n));
        for p in &mesh.positions {
            p.to_array().iter().for_each(|&x| real(&mut bytes, x));
            real(&mut bytes, 0.5);
            real(&mut bytes, 0.25);
        }
        bytes.extend(b"\n$EndNodes\n$Elements\n");
        [2, 13, 1, 13].iter().for_each(|&n| size(&mut bytes, n));
        [0, 3, 15].iter().for_each(|&n| int(&mut bytes, n));
        [1, 1, 1].iter().for_each(|&n| size(&mut bytes, n));
        [2, 3, 2].iter().for_each(|&n| int(&mut bytes, n));
        size(&mut bytes, 12);
        for (n, t) in (2..).zip(&mesh.triangles) {
            size(&mut bytes, n);
            t.iter().for_each(|&v| size(&mut bytes, u64::from(v) + 1));
        }
    } else {
        bytes.extend(b"$Nodes\n8\n");
        for (n, p) in (1..).zip(&mesh.positions) {
            int(&mut bytes, n);
            p.to_array().iter().for_each(|&x| real(&mut bytes, x));
        }
        bytes.extend(b"\n$EndNodes\n$Elements\n13\n");
        [15, 1, 2, 1, 0, 3, 1]
            .iter()
            .for_each(|&n| int(&mut bytes, n));
        [2, 12, 2].iter().for_each(|&n| int(&mut bytes, n));
        for (n, t) in (2..).zip(&mesh.triangles) {
            [n, 7, 3].iter().for_each(|&n| int(&mut bytes, n));
            t.iter().for_each(|&v| int(&mut bytes, v as i32 + 1));
        }
    }
    bytes.extend(b"\n$EndElements\n");
    bytes
}

fn archive(files: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, model) in files {
        let options = zip::write::SimpleFileOptions::default();
        zip.start_file(*name, options).unwrap();
        zip.write_all(model.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Base materials, colours and objects in a file of their own.
#[test]
fn materials_and_further_models_of_3mf() {
    let body = |paint: &str, triangles: [&str; 4]| {
        let [a, b, c, d] = triangles;
        format!(
            "<object id='1' name='tet' {paint}><mesh><vertices><vertex x='0' y='0' z='0'/>\
             <vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='0'/><vertex x='0' y='0' z='1'/>\
             </vertices><triangles><triangle v1='0' v2='2' v3='1' {a}/>\
             <triangle v1='0' v2='1' v3='3' {b}/><triangle v1='1' v2='2' v3='3' {c}/>\
             <triangle v1='0' v2='3' v3='2' {d}/></triangles></mesh></object>"
        )
    };
    let materials = "<basematerials id='5'><base name='steel' displaycolor='#808080'/>\
        <base name='brass' displaycolor='#B08020'/></basematerials>\
        <m:colorgroup id='6'><m:color color='#FF0000'/></m:colorgroup>";
    let part = format!(
        "<model unit='inch'><resources>{materials}{}</resources></model>",
        body("pid='5' pindex='0'", ["", "p1='1'", "pid='6' p1='0'", ""])
    );
    let root = |path: &str| {
        format!(
            "<model unit='millimeter'><resources/><build>\
             <item objectid='1' p:path='{path}'/></build></model>"
        )
    };
    let files = |path: &str| {
        archive(&[
            ("3D/3dmodel.model", &root(path)),
            ("3D/Objects/part.model", &part),
        ])
    };
    let loaded = read(MeshFormat::ThreeMf, &files("/3D/Objects/part.model")).unwrap();
    let material = |facet| loaded.names.of(facet).material.clone().unwrap();
    let found: Vec<String> = (0..4).map(material).collect();
    assert_eq!(found, ["steel", "brass", "#FF0000", "steel"]);
    assert_eq!(loaded.solids(), ["tet"]);
    // The root's unit holds.
    assert!((loaded.mesh.volume() - 1.0 / 6.0).abs() < 1e-12);
    assert_eq!(loaded.unit, Some(Unit::Millimetre));
    let error = read(MeshFormat::ThreeMf, &files("/3D/nowhere.model")).unwrap_err();
    assert!(error.to_string().contains("nowhere"), "{error}");
}

/// Where Gmsh is installed a sag is kept: the bore of radius 5 is followed that closely.
#[test]
fn cad_models_are_meshed_as_finely_as_asked() {
    let desk = Desk::new();
    std::fs::copy(fixture("plate_bore.step"), desk.path("plate.step")).unwrap();
    let output = desk.run(&["info", "plate.step", "--json"]);
    if output.status.code() == Some(2) && text(&output.stderr).contains("pip install gmsh") {
        return;
    }
    let bore = std::f64::consts::PI * 25.0 * 2.0;
    let lost = |sag: &str| {
        let output = desk.run(&["info", "plate.step", "--json", "--cad-sag", sag]);
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        // What chords cut off the bore is wall again.
        (told["volume"].as_f64().unwrap() - (2400.0 - bore)) / bore
    };
    // Two thirds of the sag is cut off, over half the radius.
    for (sag, share) in [
        ("0.02", 2.0 / 3.0 * 0.02 / 2.5),
        ("0.005t", 2.0 / 3.0 * 0.01 / 2.5),
    ] {
        let lost = lost(sag);
        assert!(lost > 0.0 && lost <= share, "{sag}: {lost} of {share}");
    }
    let output = desk.run(&["info", "plate.step", "--cad-sag", "0"]);
    assert_eq!(output.status.code(), Some(2));
}
