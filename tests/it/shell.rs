//! Shell models: what is written for solvers can be read, and holds what each
//! format asks for; `midsurf check` tells a good model from a bad one.

use glam::DVec3;
use midsurf::io::MeshFormat;
use midsurf::io::write::{
    Dialect, ShellFormat, ShellOptions, WriteError, stage_shell, write_shell,
};
use midsurf::mesh::FaceId;
use midsurf::shell::{Faces, Order, ShellModel, ShellSettings};

use crate::common::{Desk, fixture, read};
use crate::writers::three_sheets;

fn model(order: Order) -> ShellModel {
    let settings = ShellSettings {
        order,
        ..ShellSettings::default()
    };
    ShellModel::of(&three_sheets(), &Faces::default(), &settings)
}

fn written(model: &ShellModel, format: ShellFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_shell(model, format, ShellOptions::default(), &mut bytes).unwrap();
    bytes
}

#[test]
fn decks_come_back_with_positions_and_triangles() {
    let surface = three_sheets();
    for order in [Order::Linear, Order::Quadratic] {
        let model = model(order);
        for (format, reader) in [
            (ShellFormat::Inp, MeshFormat::Inp),
            (ShellFormat::Bdf, MeshFormat::Bdf),
            (ShellFormat::Msh, MeshFormat::Msh),
        ] {
            let loaded = read(reader, &written(&model, format)).unwrap();
            assert_eq!(loaded.mesh.triangles.len(), surface.triangles().len());
            // Thickness too, of every corner.
            for &v in loaded.mesh.triangles.iter().flatten() {
                let at = loaded.mesh.positions[v as usize];
                let own = model.nodes.iter().find(|n| n.position.distance(at) < 1e-13);
                let thickness = loaded.values.thickness[v as usize];
                assert!(
                    (thickness - own.unwrap().thickness).abs() < 1e-6,
                    "{format:?}"
                );
            }
            // Some decks list elements sheet by sheet, some by number.
            for face in (0..3).map(FaceId) {
                let corners = loaded.mesh.corners(face);
                let same = |own: [DVec3; 3]| {
                    let from =
                        |s: usize| (0..3).all(|k| own[(k + s) % 3].distance(corners[k]) < 1e-13);
                    (0..3).any(from)
                };
                let mut all = surface.triangles().iter();
                assert!(all.any(|t| same(t.corners.map(|v| surface.position(v)))));
            }
        }
    }
}

#[test]
fn an_inp_has_what_calculix_needs() {
    let model = model(Order::Quadratic);
    let deck = String::from_utf8(written(&model, ShellFormat::Inp)).unwrap();
    assert!(deck.contains("*ELEMENT, TYPE=S6, ELSET=SHEET_1\n2, "));
    assert!(deck.contains("*NSET, NSET=SEAM_1\n1, 2, 6,\n"), "{deck}");
    let block = |keyword: &str| -> Vec<&str> {
        let lines = deck.lines().skip_while(|l| *l != keyword).skip(1);
        lines.take_while(|l| !l.starts_with('*')).collect()
    };
    // A thickness on every node, a normal at every corner of every element.
    assert_eq!(block("*NODAL THICKNESS").len(), model.nodes.len());
    assert_eq!(block("*NORMAL").len(), 3 * 6);
    // What stands under a section is swallowed if it is not a number.
    let sections = deck
        .matches("MATERIAL=STEEL, NODAL THICKNESS\n2.0\n")
        .count();
    assert_eq!(sections, 3);
    for word in deck
        .lines()
        .filter(|l| !l.starts_with('*'))
        .flat_map(|l| l.split(", "))
    {
        assert!(word.len() <= 20, "{word} is cut by CalculiX");
    }
    let mut bytes = Vec::new();
    let options = ShellOptions {
        dialect: Dialect::Abaqus,
        template: None,
    };
    write_shell(&model, ShellFormat::Inp, options, &mut bytes).unwrap();
    assert!(String::from_utf8(bytes).unwrap().contains("TYPE=STRI65"));
}

#[test]
fn a_bdf_keeps_to_its_columns() {
    for (order, card, thickness) in [
        (Order::Linear, "CTRIA3", 24),
        (Order::Quadratic, "CTRIA6", 24),
    ] {
        let deck = String::from_utf8(written(&model(order), ShellFormat::Bdf)).unwrap();
        let lines: Vec<&str> = deck.lines().collect();
        assert!(lines.iter().all(|l| l.len() <= 80));
        let at = lines.iter().position(|l| l.starts_with(card)).unwrap();
        if order == Order::Linear {
            // T1 to T3 are fields 4 to 6 of the second line.
            assert_eq!(&lines[at + 1][thickness..thickness + 8], "     2.0");
            assert_eq!(&lines[at][16..24], "       3");
        } else {
            // Fields 3 to 5, after angle and offset.
            assert_eq!(&lines[at + 1][thickness..thickness + 8], "     2.0");
        }
        let shell = lines.iter().find(|l| l.starts_with("PSHELL")).unwrap();
        // Bending and shear have a material.
        assert_eq!((&shell[32..40], &shell[48..56]), ("       1", "       1"));
    }
}

#[test]
fn a_glb_has_a_primitive_a_sheet() {
    let bytes = written(&model(Order::Linear), ShellFormat::Glb);
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!((word(4), word(8)), (2, bytes.len()));
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
    let names: Vec<&str> = json["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["SHEET_1", "SHEET_2", "SHEET_3", "SEAMS"]);
    assert!(json["meshes"][0]["primitives"][0]["attributes"]["_THICKNESS"].is_u64());
    let binary = 20 + word(12);
    assert_eq!(
        word(binary),
        json["buffers"][0]["byteLength"].as_u64().unwrap() as usize
    );
}

#[test]
fn extract_writes_models_that_check_passes() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let coping = fixture("tee.coping.txt");
    let [part, coping] = [&part, &coping].map(|file| file.to_str().unwrap());
    let outputs = ["t.inp", "t.bdf", "t.msh", "t.glb"];
    let mut args = vec![
        "extract",
        part,
        "--coping",
        coping,
        "--cell",
        "1t",
        "--template",
        "cantilever",
        "--json",
        "r.json",
    ];
    args.extend(outputs.iter().flat_map(|o| ["-o", o]));
    let run = desk.run(&args);
    assert!(run.status.success(), "{run:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(desk.path("r.json")).unwrap()).unwrap();
    let shell = &report["shell"];
    let [model, solid] =
        ["model", "part"].map(|k| shell["mass_at_density_1"][k]["volume"].as_f64().unwrap());
    assert!((model / solid - 1.0).abs() < 0.03, "{model} and {solid}");
    assert_eq!(shell["leaning_elements"], 0);
    let sets = shell["sets"].as_array().unwrap();
    let coping_sets = sets
        .iter()
        .filter(|s| s["name"].as_str().unwrap().starts_with("COPING_"));
    assert_eq!(coping_sets.count(), 5);
    let deck = std::fs::read_to_string(desk.path("t.inp")).unwrap();
    assert!(deck.contains("*STATIC\n*CLOAD\n") && deck.ends_with("*END STEP\n"));

    for model in &outputs[..3] {
        let run = desk.run(&[
            "check",
            part,
            model,
            "--coping",
            coping,
            "--fail-on",
            "any",
            "-o",
            "d.vtu",
        ]);
        assert!(run.status.success(), "{model}: {run:?}");
    }
    // The same model, moved by a third of the thickness.
    let loaded = midsurf::io::read_mesh(desk.path("t.msh")).unwrap();
    let mut moved = loaded.mesh;
    moved.positions.iter_mut().for_each(|p| p.z += 0.66);
    desk.put("moved.obj", crate::common::obj_text(&moved));
    let check = [
        "check",
        part,
        "moved.obj",
        "--coping",
        coping,
        "--fail-on",
        "nodes_off_middle",
    ];
    let run = desk.run(&check);
    assert_eq!(run.status.code(), Some(1), "{run:?}");
    let run = desk.run(&[
        "check",
        part,
        "moved.obj",
        "--coping",
        coping,
        "--fail-on",
        "nonsense",
    ]);
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    // A model of another part, in another place.
    moved.positions.iter_mut().for_each(|p| *p *= 1000.0);
    desk.put("far.obj", crate::common::obj_text(&moved));
    let run = desk.run(&["check", part, "far.obj", "--json", "c.json"]);
    assert_eq!(run.status.code(), Some(2), "{run:?}");
    assert!(!desk.path("c.json").exists());
}

#[test]
fn the_template_holds_one_end_and_loads_the_other() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let coping = fixture("tee.coping.txt");
    let [part, coping] = [&part, &coping].map(|file| file.to_str().unwrap());
    for (template, step) in [("modal", "*FREQUENCY\n6\n"), ("cantilever", "*STATIC\n")] {
        let run = desk.run(&[
            "extract",
            part,
            "--coping",
            coping,
            "--template",
            template,
            "-o",
            "t.inp",
            "-q",
        ]);
        assert!(run.status.success(), "{run:?}");
        let deck = std::fs::read_to_string(desk.path("t.inp")).unwrap();
        assert!(deck.contains(step));
    }
    let deck = std::fs::read_to_string(desk.path("t.inp")).unwrap();
    let loads = deck
        .split("*CLOAD\n")
        .nth(1)
        .unwrap()
        .lines()
        .take_while(|l| !l.starts_with('*'));
    let sum: f64 = loads
        .map(|l| l.rsplit(", ").next().unwrap().parse::<f64>().unwrap())
        .sum();
    assert!((sum + 1.0).abs() < 1e-9, "{sum}");
}

/// Numbers that are none are refused before anything is written, in every format.
#[test]
fn no_model_is_written_with_numbers_that_are_not_finite() {
    let sound = model(Order::Linear);
    let desk = Desk::new();
    let spoil: [fn(&mut ShellModel); 4] = [
        |m| m.nodes[2].position.y = f64::NAN,
        |m| m.nodes[2].thickness = f64::INFINITY,
        |m| m.normals.iter_mut().for_each(|n| n.z = f64::NAN),
        |m| m.nodes[2].position.x = f64::NEG_INFINITY,
    ];
    for name in ["a.inp", "a.bdf", "a.msh", "a.glb"] {
        let file = desk.path(name);
        assert!(stage_shell(&sound, &file, ShellOptions::default()).is_ok());
        for spoil in spoil {
            let mut model = sound.clone();
            spoil(&mut model);
            let error = stage_shell(&model, &file, ShellOptions::default()).unwrap_err();
            assert!(
                matches!(error, WriteError::NotFinite { .. }),
                "{name}: {error}"
            );
        }
    }
    // What single precision does not hold is none either.
    let mut large = sound.clone();
    large.nodes[2].position.x = 1e39;
    assert!(stage_shell(&large, &desk.path("a.glb"), ShellOptions::default()).is_err());
    assert!(stage_shell(&large, &desk.path("a.inp"), ShellOptions::default()).is_ok());
    assert_eq!(desk.files().len(), 0);
}
