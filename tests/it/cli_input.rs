//! The command on good and bad input: exit codes, messages, no stray files.

use glam::DVec3;
use midsurf::mesh::TriMesh;

use crate::common::{Desk, cuboid, fixture, inverted, obj_text, stl_bytes, text};

fn plate() -> TriMesh {
    cuboid(DVec3::ZERO, DVec3::new(10.0, 10.0, 1.0))
}

fn open_plate() -> TriMesh {
    let mut mesh = plate();
    mesh.triangles.remove(5);
    mesh
}

#[test]
fn files_that_cannot_be_read() {
    let desk = Desk::new();
    desk.refuses(
        &["missing.obj"],
        &["missing.obj", "cannot be read", "check the path"],
    );
    std::fs::create_dir(desk.path("folder.obj")).unwrap();
    desk.refuses(&["folder.obj"], &["folder.obj", "is not a file"]);
    desk.put("part.x_t", "**PARASOLID");
    desk.refuses(
        &["part.x_t"],
        &["part.x_t", "no suffix of a known mesh format", ".step"],
    );
    desk.put("empty.obj", "");
    desk.refuses(
        &["empty.obj"],
        &["empty.obj", "the file is empty", "export or download"],
    );
    desk.put(
        "page.obj",
        "<!DOCTYPE html>\n<html><body>404</body></html>\n",
    );
    desk.refuses(
        &["page.obj"],
        &["page.obj", "a web page (HTML), not a mesh", "raw file"],
    );
    desk.put("points.obj", "v 0 0 0\n");
    desk.refuses(&["points.obj"], &["points.obj", "no faces, only points"]);
}

#[test]
fn files_with_a_flaw_at_a_place() {
    let desk = Desk::new();
    let good = obj_text(&plate());
    let lines = good.lines().count();
    desk.put("nan.obj", good.replacen("v 10 ", "v nan ", 1));
    desk.refuses(
        &["nan.obj"],
        &[
            "nan.obj, line 2",
            "not a finite number",
            "repair the vertex",
        ],
    );
    desk.put("huge.obj", good.replacen("v 10 ", "v 1e400 ", 1));
    desk.refuses(&["huge.obj"], &["huge.obj, line 2", "1e400"]);
    desk.put("range.obj", format!("{good}f 1 2 9\n"));
    let place = format!("range.obj, line {}", lines + 1);
    desk.refuses(
        &["range.obj"],
        &[&place, "vertex 9 does not exist", "8 vertices"],
    );
    desk.put("cut.obj", &good[..good.len() - 4]);
    let place = format!("cut.obj, line {lines}");
    desk.refuses(&["cut.obj"], &[&place, "three corners"]);

    let stl = stl_bytes(&plate(), "solid plate");
    desk.put("cut.stl", &stl[..stl.len() - 20]);
    desk.refuses(
        &["cut.stl"],
        &["cut.stl, byte 634", "claims 12 facets", "damaged"],
    );
    let mut nan = stl.clone();
    nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    desk.put("nan.stl", nan);
    desk.refuses(&["nan.stl"], &["nan.stl, byte 96", "finite"]);
    desk.put("cut.ply", "ply\nformat ascii 1.0\nelement vertex 8\n");
    desk.refuses(&["cut.ply"], &["cut.ply, line 4"]);
}

#[test]
fn meshes_that_are_no_part() {
    let desk = Desk::new();
    desk.put("open.obj", obj_text(&open_plate()));
    desk.refuses(
        &["open.obj"],
        &[
            "open.obj, line 16",
            "the mesh is open: 3 edges",
            "from (0, 0, 0) to (0, 0, 1) of triangle 7",
            "--allow-open",
            "guesses",
        ],
    );
    desk.put("open.stl", stl_bytes(&open_plate(), ""));
    desk.refuses(&["open.stl"], &["open.stl, byte ", "the mesh is open"]);
    let mut membrane = plate();
    membrane.triangles.push([0, 3, 7]);
    membrane.triangles.push([0, 7, 4]);
    desk.put("membrane.obj", obj_text(&membrane));
    desk.refuses(&["membrane.obj"], &["membrane.obj, line", "do not pair up"]);
    let mut flat = plate();
    flat.positions.iter_mut().for_each(|p| p.z = 0.0);
    desk.put("flat.obj", obj_text(&flat));
    desk.refuses(&["flat.obj"], &["flat.obj", "encloses no volume"]);
    desk.put("plate.obj", obj_text(&plate()));
    desk.refuses(
        &["plate.obj", "--weld", "5"],
        &["plate.obj", "weld tolerance of 5"],
    );
}

#[test]
fn tags_that_do_not_fit() {
    let desk = Desk::new();
    desk.put("plate.obj", obj_text(&plate()));
    let refuses = |name: &str, content: &str, words: &[&str]| {
        desk.put(name, content);
        desk.refuses(&["plate.obj", "--coping", name], words);
    };
    desk.refuses(
        &["plate.obj", "--coping", "none.txt"],
        &["none.txt", "cannot be read"],
    );
    refuses(
        "all.txt",
        "0-11",
        &["all.txt", "all 12 triangles are tagged", "midsurf tags"],
    );
    refuses(
        "range.txt",
        "0\n12",
        &["range.txt, line 2", "triangle 12 does not exist"],
    );
    refuses(
        "word.txt",
        "# tags\nrim\n",
        &["word.txt, line 2", "\"rim\" is no tag", "group: rim_*"],
    );
    refuses(
        "name.txt",
        "group: rim\n",
        &["name.txt, line 1", "no such names"],
    );
    let head = "format = \"coping-tags\"\nversion = 1\n";
    refuses(
        "other.toml",
        &format!("{head}[mesh]\nsha256 = \"1234\"\n[[coping]]\ntriangles = 0\n"),
        &[
            "other.toml, line 4",
            "for another mesh",
            "plate.obj",
            "1234",
        ],
    );
    refuses(
        "typo.toml",
        &format!("{head}[[coping]]\ntriangle = 0\n"),
        &["typo.toml, line 4", "unknown field `triangle`"],
    );

    // Only a triangle without area left as wall.
    let mut sliver = plate();
    sliver.triangles.push([1, 1, 2]);
    desk.put("sliver.obj", obj_text(&sliver));
    desk.put("most.txt", "0-11");
    desk.refuses(
        &["sliver.obj", "--coping", "most.txt"],
        &["most.txt", "no wall is left"],
    );
}

#[test]
fn usage_that_makes_no_sense() {
    let desk = Desk::new();
    desk.put("plate.obj", obj_text(&plate()));
    for flags in [
        ["--cell", "0"],
        ["--cell", "nan"],
        ["--cell", "1mm"],
        ["--angle", "180"],
        ["--angle", "-1"],
        ["--threads", "0"],
        ["--memory-limit", "0"],
        ["--memory-limit", "8X"],
        ["--weld", "0"],
        ["--weld", "inf"],
    ] {
        desk.refuses(&["plate.obj", flags[0], flags[1]], &["error:", flags[0]]);
    }
    desk.refuses(&["plate.obj", "-o", "mid.step"], &["mid.step", ".vtu"]);
    desk.refuses(
        &["plate.obj", "-o", "no/mid.ply"],
        &["no/mid.ply", "does not exist"],
    );
    desk.refuses(
        &["plate.obj", "-o", "plate.obj"],
        &["plate.obj", "named twice"],
    );
    desk.refuses(
        &["plate.obj", "-o", "./mid.vtu"],
        &["mid.vtu", "named twice"],
    );
    desk.put("mid.thickness.csv", "");
    desk.refuses(
        &["plate.obj", "--coping", "mid.thickness.csv"],
        &["named twice, as coping tags and as output"],
    );
    assert_eq!(desk.run(&[]).status.code(), Some(2));
}

#[test]
fn help_names_examples_and_exit_codes() {
    let desk = Desk::new();
    for args in [
        &["--help"][..],
        &["extract", "--help"],
        &["info", "--help"],
        &["tags", "--help"],
    ] {
        let output = desk.run(args);
        assert_eq!(output.status.code(), Some(0));
        let help = text(&output.stdout);
        assert!(help.contains("Exit codes"), "{help}");
        assert!(
            args.len() == 1 || help.contains("Examples:\n  midsurf"),
            "{help}"
        );
    }
}

#[test]
fn info_says_what_a_part_is() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let (part, tags) = (part.to_str().unwrap(), tags.to_str().unwrap());
    let output = desk.run(&["info", part, "--coping", tags]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    let info = text(&output.stdout);
    for line in [
        "triangles    28, 18 of them coping",
        "vertices     16",
        "watertight   yes",
        "components   1",
        "euler        2",
        "volume       6400",
        "area         6856, of it wall 6300",
        "box          (-20, -25, 0) to (20, 1, 50)",
        "objects      1: tee",
    ] {
        assert!(info.lines().any(|l| l == line), "no {line:?} in\n{info}");
    }
    let output = desk.run(&["info", part, "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(info["triangles"], 28);
    assert_eq!(info["watertight"], true);
    assert_eq!(info["volume"], 6400.0);
    assert_eq!(info["warnings"].as_array().unwrap().len(), 0);
    assert_eq!(info["groups"].as_array().unwrap().len(), 10);
}

#[test]
fn info_turns_and_lets_pass_with_a_warning() {
    let desk = Desk::new();
    desk.put("turned.obj", obj_text(&inverted(&plate())));
    let output = desk.run(&["info", "turned.obj"]);
    assert_eq!(output.status.code(), Some(0));
    let stderr = text(&output.stderr);
    assert!(
        stderr.contains("turned.obj: the part was inside out"),
        "{stderr}"
    );
    assert!(text(&output.stdout).contains("volume       100\n"));
    desk.put("open.obj", obj_text(&open_plate()));
    let output = desk.run(&["info", "open.obj"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("open.obj: the mesh is open"));
    assert!(text(&output.stdout).contains("watertight   no, 3 open edges"));
    // Exactly what `info` cannot describe is refused.
    desk.put("junk.ply", "junk");
    let output = desk.run(&["info", "junk.ply"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
}

#[test]
fn tags_shows_and_splits() {
    let desk = Desk::new();
    let part = fixture("tee.obj");
    let tags = fixture("tee.coping.txt");
    let (part, tags) = (part.to_str().unwrap(), tags.to_str().unwrap());
    let output = desk.run(&["tags", part, tags, "-o", "split.obj"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    assert_eq!(table.lines().count(), 4, "{table}");
    let row = |line: usize| -> Vec<String> {
        let line = table.lines().nth(line).unwrap();
        line.split_whitespace().map(str::to_owned).collect()
    };
    assert_eq!(row(2)[..5], ["all", "coping", "coping", "18", "556"]);
    assert_eq!(row(3)[..5], ["all", "wall", "wall", "10", "6300"]);
    let split = midsurf::io::read_mesh(desk.path("split.obj")).unwrap();
    let in_group = |name: &str| {
        let faces = split.mesh.faces();
        faces
            .filter(|&f| split.names_of(f).groups == [name])
            .count()
    };
    assert_eq!((in_group("coping"), in_group("wall")), (18, 10));

    let output = desk.run(&["tags", part, tags, "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["coping"]["triangles"], 18);
    assert_eq!(report["rules"][0]["area"], 556.0);

    for target in ["split.stl", "no/split.obj", part] {
        let output = desk.run(&["tags", part, tags, "-o", target]);
        assert_eq!(output.status.code(), Some(2), "{target}");
    }
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("x.txt");
    let output = desk.run(&["tags", part, missing.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    use std::process::{Command, Stdio};
    let program = assert_cmd::cargo::cargo_bin!("midsurf");
    let mut child = Command::new(program)
        .arg("info")
        .arg(fixture("enclosure.obj"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
}

#[test]
fn messages_are_plain_when_asked() {
    let desk = Desk::new();
    let output = desk.run(&["info", "missing.obj"]);
    assert!(!output.stderr.contains(&0x1b));
}

/// Lines of commas, counts that wrap, planes of a grid with no number between them.
#[test]
fn what_once_panicked_is_answered() {
    let desk = Desk::new();
    let [commas, tags] = ["fuzz/commas.inp", "fuzz/tags.msh"].map(fixture);
    let [commas, tags] = [&commas, &tags].map(|file| file.to_str().unwrap());
    let far = DVec3::splat(9e6);
    desk.put("far.obj", obj_text(&cuboid(far, DVec3::splat(100.0))));
    let offset = [
        "offset",
        "far.obj",
        "--distance",
        "1",
        "--cell",
        "1",
        "-o",
        "out.stl",
    ];
    let runs: [&[&str]; 3] = [&["info", commas], &["info", tags], &offset];
    for args in runs {
        let output = desk.run(args);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{args:?}: {}",
            text(&output.stderr)
        );
        assert!(!text(&output.stderr).contains("panicked"), "{args:?}");
    }
}
