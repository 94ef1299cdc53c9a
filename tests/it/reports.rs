//! Reports of all commands share one envelope.

use serde_json::Value;

use crate::common::{Desk, fixture, text};

#[test]
fn every_report_has_the_envelope() {
    let desk = Desk::new();
    let plate = fixture("plate.obj");
    let tags = fixture("plate.coping.txt");
    let [plate, tags] = [&plate, &tags].map(|file| file.to_str().unwrap());
    let mid = desk.path("mid.ply");
    let cube = "v 0 0 0\nv 8 0 0\nv 8 8 0\nv 0 8 0\nv 0 0 8\nv 8 0 8\nv 8 8 8\nv 0 8 8\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 4 1 5 8\nf 2 3 7 6\n";
    let cube = desk.put("cube.obj", cube);
    let patch = desk.put(
        "patch.obj",
        "v 0 0 0\nv 8 0 0\nv 8 8 0\nv 0 8 0\nf 1 2 3 4\n",
    );
    let [mid, cube, patch] = [&mid, &cube, &patch].map(|file| file.to_str().unwrap());
    let extract = ["extract", plate, "--coping", tags, "--cell", "1t"];
    check(&desk, &[&extract[..], &["-o", mid]].concat());
    check(&desk, &["rethicken", mid]);
    check(
        &desk,
        &["roundtrip", plate, "--coping", tags, "--solid-cell", "0.5t"],
    );
    check(&desk, &["offset", cube, "--distance", "1", "--cell", "5%"]);
    check(
        &desk,
        &["hollow", cube, "--thickness", "1", "--cell", "0.5"],
    );
    check(
        &desk,
        &["thicken", patch, "--thickness", "1", "--cell", "0.3t"],
    );
    check(
        &desk,
        &["subdivide", cube, "--thickness", "0.2", "--samples", "2"],
    );
    check(
        &desk,
        &["subdivide", cube, "--interpolate", "--samples", "2"],
    );
    let contour = [
        "--scheme",
        "contour",
        "--thickness",
        "0.5",
        "--cell",
        "0.8t",
    ];
    check(&desk, &[&["subdivide", cube][..], &contour].concat());
}

fn check(desk: &Desk, args: &[&str]) {
    let output = desk.run(&[args, &["--json", "-", "-q", "-j", "2"]].concat());
    assert_eq!(
        output.status.code(),
        Some(0),
        "{args:?}: {}",
        text(&output.stderr)
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["schema"], 1, "{args:?}");
    assert_eq!(report["tool"]["name"], "midsurf", "{args:?}");
    assert_eq!(report["tool"]["command"], args[0], "{args:?}");
    assert_eq!(
        report["input"]["sha256"].as_str().map(str::len),
        Some(64),
        "{args:?}"
    );
    assert_eq!(report["settings"]["threads"], 2, "{args:?}");
    assert!(
        report["seconds"].is_number() || report["seconds"]["total"].is_number(),
        "{args:?}"
    );
    assert_eq!(
        report["peak_memory"].is_u64(),
        cfg!(target_os = "linux"),
        "{args:?}"
    );
    assert_eq!(
        report["outputs"].as_array().map(Vec::len),
        Some(args.contains(&"-o").into())
    );
    assert!(report["warnings"].is_array(), "{args:?}");
}

/// A remedy may name only what the command takes.
#[test]
fn remedies_name_only_flags_of_the_command() {
    let desk = Desk::new();
    let open = desk.put(
        "open.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n",
    );
    let open = open.to_str().unwrap();
    for (args, has) in [
        (&["extract", open][..], true),
        (&["offset", open, "--distance", "1"], false),
        (&["roundtrip", open], false),
    ] {
        let output = desk.run(args);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert_eq!(told.contains("--allow-open"), has, "{told}");
        assert!(told.contains("close the holes"), "{told}");
    }
}
