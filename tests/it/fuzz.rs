//! Files that were damaged at random, and solids nobody would draw: no panic,
//! and what the README promises holds for every result.
//!
//! `tools/fuzz/run` looks for more of them, for as long as one likes, and has the
//! checks. Files that once failed are kept in `fixtures/fuzz`.

#[path = "../../tools/fuzz/src/checks.rs"]
mod checks;
#[path = "../../tools/fuzz/src/solids.rs"]
mod solids;

use glam::DVec3;
use proptest::prelude::*;

use crate::common::{cuboid, fixture, obj_text, ply_binary, ply_text, stl_bytes, stl_text};

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
            ("a.cage", std::fs::read(cage).unwrap())
        }
    }
}

#[test]
fn files_that_once_failed() {
    let folder = fixture("fuzz");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let suffix = file.extension().unwrap_or_default().to_string_lossy();
        let bytes = std::fs::read(&file).unwrap();
        match &*suffix {
            "md" => continue,
            "extract" => checks::extracts(&solids::solid(&bytes)),
            "roundtrip" => checks::goes_round(&solids::solid(&bytes)),
            "offset" => checks::offsets(&solids::solid(&bytes)),
            "thicken" => checks::thickens(&solids::sheet(&bytes)),
            "repair" => checks::repairs(&solids::soup(&bytes)),
            _ => checks::reads(&bytes, &file),
        }
        count += 1;
    }
    assert!(count > 0);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_panic(kind in 0..14_usize, damage in damage()) {
        let (name, bytes) = sound(kind);
        checks::reads(&damaged(bytes, &damage), name.as_ref());
    }

    #[test]
    fn faults_are_mended_or_refused(bytes in proptest::collection::vec(any::<u8>(), 40..120)) {
        checks::repairs(&solids::soup(&bytes));
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
    fn solids_of_any_bytes_keep_all_promises(
        bytes in proptest::collection::vec(any::<u8>(), 20..60),
    ) {
        let case = solids::solid(&bytes);
        checks::goes_round(&case);
        checks::offsets(&case);
        checks::thickens(&solids::sheet(&bytes));
    }
}
