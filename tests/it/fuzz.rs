//! Files that were damaged at random, and solids nobody would draw: no panic,
//! and what the README promises holds for every result.
//!
//! `PROPTEST_CASES=100000 cargo test --release --test it fuzz` runs for long.
//! Files that once failed are kept in `fixtures/fuzz`.

use std::path::Path;

use glam::DVec3;
use midsurf::CellSize;
use midsurf::coping::read_tags_bytes;
use midsurf::extract::{Settings, extract};
use midsurf::io::{MeshFormat, read_control_bytes, read_mesh_bytes};
use midsurf::mesh::{Part, PartOptions, TriMesh, self_intersections};
use midsurf::offset::{self, offset};
use midsurf::roundtrip::{self, roundtrip};
use midsurf::subdivide::Cage;
use midsurf::thicken::{self, Side, thicken};
use proptest::prelude::*;

use crate::common::{cuboid, fixture, obj_text, ply_binary, ply_text, stl_bytes, stl_text};

/// Reads a file as whatever its suffix says, and checks what it holds.
fn read(bytes: &[u8], file: &Path) {
    match file.extension().and_then(|suffix| suffix.to_str()) {
        Some("txt" | "toml") => {
            let part = fixture("tee.obj");
            let loaded = midsurf::io::read_mesh(&part).unwrap();
            if let Err(error) = read_tags_bytes(bytes, &loaded, file, &part) {
                assert!(error.to_string().len() <= 3000, "{error}");
            }
        }
        _ => {
            let format = MeshFormat::of(file).unwrap();
            match read_mesh_bytes(bytes, format, file) {
                Ok(loaded) => {
                    assert!(loaded.mesh.positions.iter().all(|p| p.is_finite()));
                    let flags = vec![false; loaded.mesh.triangles.len()];
                    let options = PartOptions {
                        allow_open: true,
                        weld: None,
                    };
                    let _ = Part::new(loaded.mesh, flags, options);
                }
                Err(error) => assert!(error.to_string().len() <= 3000, "{error}"),
            }
            if format == MeshFormat::Obj
                && let Ok(control) = read_control_bytes(bytes, file)
            {
                let _ = Cage::new(control.positions, &control.faces);
            }
        }
    }
}

/// What is done to a file: at a share of its length, so many bytes go and
/// others come.
type Damage = (f64, usize, Vec<u8>);

fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let words = prop_oneof![
        Just(b"-".to_vec()),
        Just(b"1e999".to_vec()),
        Just(b"4294967295".to_vec()),
        Just(b"nan".to_vec()),
        Just(b"\n".to_vec()),
        Just(b"0/0/0".to_vec()),
        Just(b"\x1b[2J".to_vec()),
        proptest::collection::vec(any::<u8>(), 0..6),
    ];
    proptest::collection::vec((0.0..1.0, 0..12_usize, words), 1..5)
}

fn damaged(mut bytes: Vec<u8>, damage: &[Damage]) -> Vec<u8> {
    for (share, gone, come) in damage {
        let at = (share * bytes.len() as f64) as usize;
        let end = (at + gone).min(bytes.len());
        bytes.splice(at..end, come.iter().copied());
    }
    bytes
}

/// Sound files of every kind that is read.
fn sound(kind: usize) -> (&'static str, Vec<u8>) {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 1.0));
    let off = || {
        let mut text = format!("OFF\n{} {} 0\n", mesh.positions.len(), mesh.triangles.len());
        mesh.positions
            .iter()
            .for_each(|p| text += &format!("{} {} {}\n", p.x, p.y, p.z));
        mesh.triangles
            .iter()
            .for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
        text.into_bytes()
    };
    let toml = "format = \"coping-tags\"\nversion = 1\n[mesh]\ntriangles = 56\n[options]\n\
        on_empty = \"warn\"\n[[coping]]\nname = \"a\"\ntriangles = [0, \"4-9:2\"]\n[[coping]]\n\
        plane = { point = [0, 0, 0], normal = [1, 0, 0], tol = 0.1 }\n[[wall]]\n\
        box = { min = [0, 0, 0], max = [1, 1, 1] }\n[[coping]]\n\
        near = { point = [0, 0, 0], grow_angle = 20 }\n";
    match kind {
        0 => ("a.obj", obj_text(&mesh).into_bytes()),
        1 => ("a.stl", stl_bytes(&mesh, "a")),
        2 => ("a.stl", stl_text(&mesh, "a").into_bytes()),
        3 => ("a.ply", ply_binary(&mesh, false, true)),
        4 => ("a.ply", ply_binary(&mesh, true, false)),
        5 => ("a.ply", ply_text(&mesh).into_bytes()),
        6 => ("a.off", off()),
        7 => ("a.toml", toml.as_bytes().to_vec()),
        8 => (
            "a.txt",
            b"# rims\n0-3, 7\n9-20:2\ngroup: *\nobject: a?\n".to_vec(),
        ),
        _ => {
            let cages = ["cube", "genus3", "open_hole", "spike", "valence_mix"];
            let cage = fixture(&format!("cages/{}.obj", cages[kind % cages.len()]));
            ("a.obj", std::fs::read(cage).unwrap())
        }
    }
}

/// Union of unit cubes, one triangle pair a face that bounds it, stretched and
/// turned; edges where cubes touch alone have four triangles.
fn voxels(filled: &[bool], size: DVec3, turn: f64) -> TriMesh {
    let at = |x: i32, y: i32, z: i32| {
        let inside = [x, y, z].iter().all(|k| (0..3).contains(k));
        inside && filled[(x + 3 * y + 9 * z) as usize]
    };
    let mut mesh = TriMesh {
        positions: Vec::new(),
        triangles: Vec::new(),
    };
    let mut node = std::collections::BTreeMap::new();
    for (k, _) in filled.iter().enumerate().filter(|(_, full)| **full) {
        let cell = [k as i32 % 3, k as i32 / 3 % 3, k as i32 / 9];
        for axis in 0..3 {
            for side in [0, 1] {
                let mut over = cell;
                over[axis] += 2 * side - 1;
                if at(over[0], over[1], over[2]) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let corner = |du: i32, dv: i32| {
                    let mut p = cell;
                    p[axis] += side;
                    p[u] += du;
                    p[v] += dv;
                    p
                };
                let mut ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side == 0 {
                    ring.reverse();
                }
                let [a, b, c, d] = ring.map(|p| {
                    *node.entry(p).or_insert_with(|| {
                        let p = size * DVec3::new(p[0].into(), p[1].into(), p[2].into());
                        mesh.positions.push(glam::DQuat::from_rotation_y(turn) * p);
                        mesh.positions.len() as u32 - 1
                    })
                });
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

/// Every result keeps what the README promises of it.
fn check_engines(mesh: &TriMesh, coping: &[bool], cell: f64) {
    let quiet = |_: &'static str, _: u64, _: u64| ();
    let options = PartOptions {
        allow_open: true,
        weld: None,
    };
    if let Ok((part, _)) = Part::new(mesh.clone(), coping.to_vec(), options) {
        let size = part.bounds().diagonal();
        let settings = Settings {
            cell: CellSize::Length(cell * size),
            ..Settings::default()
        };
        if let Ok(result) = extract(&part, &settings, &quiet) {
            let vertices = result.surface.vertices();
            assert!(vertices.iter().all(|v| v.position.is_finite()));
        }
        let settings = roundtrip::Settings {
            extract: settings,
            solid_cell: CellSize::Percent(5.0),
            memory_limit: 1 << 30,
        };
        if let Ok(result) = roundtrip(&part, &settings, &quiet) {
            assert!(result.comparison.closed);
            assert_eq!(result.comparison.self_intersections, 0);
        }
        for distance in [0.03 * size, -0.03 * size] {
            let mut settings = offset::Settings::new(&part, distance);
            settings.cell = cell * size;
            if let Ok(result) = offset(&part, &settings, &quiet) {
                assert!(self_intersections(&result.mesh).is_empty());
                assert!(result.mesh.edges().census().open == 0);
            }
        }
    }
    for side in [Side::Inner, Side::Outer] {
        let mut settings = thicken::Settings::new(0.1, side);
        settings.cell = 0.04;
        if let Ok(result) = thicken(mesh, &settings, &quiet) {
            let crossings = self_intersections(&result.mesh).len();
            assert_eq!(result.self_intersections, crossings);
        }
    }
}

#[test]
fn files_that_once_failed() {
    let folder = fixture("fuzz");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_some_and(|suffix| suffix == "md") {
            continue;
        }
        count += 1;
        read(&std::fs::read(&file).unwrap(), &file);
    }
    assert!(count > 0);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(kind in 0..14_usize, damage in damage()) {
        let (name, bytes) = sound(kind);
        read(&damaged(bytes, &damage), name.as_ref());
    }
}

/// Cases of the solids, which take longer: a tenth of the others.
fn few() -> ProptestConfig {
    let usual = ProptestConfig::default();
    ProptestConfig {
        failure_persistence: None,
        cases: usual.cases.div_ceil(16),
        ..usual
    }
}

proptest! {
    #![proptest_config(few())]

    #[test]
    fn solids_of_cubes_keep_all_promises(
        filled in proptest::collection::vec(prop::bool::weighted(0.6), 27),
        tagged in proptest::collection::vec(prop::bool::weighted(0.2), 324),
        thin in prop_oneof![Just(1.0), Just(0.2), Just(1e-3)],
        turn in prop_oneof![Just(0.0), -3.0..3.0],
        cell in 0.08..0.3,
    ) {
        let mesh = voxels(&filled, DVec3::new(1.0, thin, 1.0), turn);
        let flags = &tagged[..mesh.triangles.len()];
        check_engines(&mesh, flags, cell);
    }
}
