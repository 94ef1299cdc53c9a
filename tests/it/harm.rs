//! No input harms: messages, paths, memory, time, threads, outputs, signals.

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use glam::DVec3;
use serde_json::Value;

use crate::common::{Desk, cuboid, fixture, obj_text, text};

const BINARY: &str = env!("CARGO_BIN_EXE_midsurf");

/// Ends with one of the codes that are documented, and speaks briefly, without
/// moving the terminal's cursor.
fn check(output: &Output, code: i32) -> String {
    let told = text(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(code),
        "{}",
        &told[..told.len().min(3000)]
    );
    for printed in [&told, &text(&output.stdout)] {
        let escape = printed.chars().find(|c| c.is_control() && *c != '\n');
        assert_eq!(escape, None, "{printed:?}");
    }
    told
}

#[test]
fn messages_are_short_and_plain() {
    let desk = Desk::new();
    desk.put(
        "plate.obj",
        obj_text(&cuboid(DVec3::ZERO, DVec3::new(9.0, 9.0, 1.0))),
    );
    let long = "x".repeat(3_000_000);
    let nested = format!(
        "format = \"coping-tags\"\nversion = 1\na = {}",
        "[".repeat(200_000)
    );
    let red = "\u{1b}]0;title\u{7}\u{1b}[31m";
    for (name, content) in [
        ("long.txt", long.clone()),
        ("red.txt", format!("{red}\n")),
        ("name.txt", format!("group: {red}{long}\n")),
        ("long.toml", long.clone()),
        ("deep.toml", nested),
        (
            "red.toml",
            format!("format = \"{}\"\n", "\\u001b[2J".repeat(1000)),
        ),
        ("key.toml", format!("\"\\u001b[2J{long}\" = 1\n")),
    ] {
        desk.put(name, content);
        let output = desk.run(&["extract", "plate.obj", "--coping", name]);
        let told = check(&output, 2);
        assert!(told.len() < 3000, "{name}: {} bytes", told.len());
        assert!(told.contains(name), "{told}");
    }
    for (name, content) in [
        ("word.obj", format!("v 0 0 {red}{long}\n")),
        ("index.obj", format!("v 0 0 0\nf 1 1 {long}{red}\n")),
        ("word.off", format!("OFF\n3 1 0\n0 0 {red}{long}\n")),
        ("word.ply", format!("ply\nformat ascii 1.0\n{red}{long}\n")),
        (
            "word.stl",
            format!("solid {red}\nfacet {long}\n{red}{long}\n"),
        ),
    ] {
        desk.put(name, content);
        let told = check(&desk.run(&["info", name]), 2);
        assert!(told.len() < 3000, "{name}: {} bytes", told.len());
    }
}

#[test]
fn names_of_a_mesh_are_shown_plainly_and_reported_whole() {
    let desk = Desk::new();
    let red = "\u{1b}[31mred\u{1b}[0m";
    let long = format!("head{}tail", "y".repeat(5000));
    let plate = obj_text(&cuboid(DVec3::ZERO, DVec3::new(9.0, 9.0, 1.0)));
    let plate = plate.replacen(
        "f ",
        &format!("g {red} {long}\nusemtl {red}\nodd{red} 1\nf "),
        1,
    );
    desk.put("plate.obj", plate);
    check(&desk.run(&["info", "plate.obj"]), 0);
    let output = desk.run(&["info", "plate.obj", "--json"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["groups"], serde_json::json!([red, long]));
    desk.put("tags.txt", format!("group: {red}\n"));
    let output = desk.run(&["tags", "plate.obj", "tags.txt"]);
    assert!(check(&output, 0).contains("\\u{1b}[31m"));
    assert!(text(&output.stdout).contains("\\u{1b}[31mred"));
}

#[cfg(target_os = "linux")]
#[test]
fn file_names_need_not_be_unicode() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::new();
    let name = |bytes: &'static [u8]| desk.path("").join(OsStr::from_bytes(bytes));
    let (part, tags, mid) = (
        name(b"pl\xffte.obj"),
        name(b"t\xfegs.txt"),
        name(b"m\xfdd.ply"),
    );
    std::fs::copy(fixture("plate.obj"), &part).unwrap();
    std::fs::copy(fixture("plate.coping.txt"), &tags).unwrap();
    let run = |args: &[&OsStr]| Command::new(BINARY).args(args).output().unwrap();
    let word = OsStr::new;
    let shared = [word("--json"), word("-"), word("-o")];
    let extract = [
        word("extract"),
        part.as_os_str(),
        word("--coping"),
        tags.as_os_str(),
    ];
    check(
        &run(&[&extract[..], &shared, &[mid.as_os_str()]].concat()),
        0,
    );
    assert!(mid.is_file());
    check(&run(&[word("info"), part.as_os_str(), word("--json")]), 0);
    check(
        &run(&[
            word("tags"),
            part.as_os_str(),
            tags.as_os_str(),
            word("--json"),
        ]),
        0,
    );
    let solid = name(b"s\xfclid.stl");
    let rethicken = [word("rethicken"), mid.as_os_str()];
    let output = run(&[&rethicken[..], &shared, &[solid.as_os_str()]].concat());
    check(&output, 0);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        report["outputs"][0]
            .as_str()
            .unwrap()
            .contains("s\u{fffd}lid.stl")
    );
}

#[cfg(unix)]
#[test]
fn outputs_that_are_inputs_are_refused() {
    let desk = Desk::new();
    let plate = fixture("plate.obj");
    let tags = fixture("plate.coping.txt");
    std::fs::copy(plate, desk.path("plate.obj")).unwrap();
    std::fs::copy(tags, desk.path("tags.txt")).unwrap();
    let extract = ["extract", "plate.obj", "--coping", "tags.txt", "-q"];
    check(&desk.run(&[&extract[..], &["-o", "m.obj"]].concat()), 0);
    std::fs::hard_link(desk.path("plate.obj"), desk.path("hard.obj")).unwrap();
    std::os::unix::fs::symlink(desk.path("tags.txt"), desk.path("soft.json")).unwrap();
    std::os::unix::fs::symlink(desk.path("m.obj"), desk.path("soft.obj")).unwrap();
    let before: Vec<_> = desk
        .files()
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect();
    for args in [
        &["rethicken", "m.obj", "--json", "m.thickness.csv"][..],
        &["rethicken", "m.obj", "-o", "m.obj"],
        &["rethicken", "m.obj", "-o", "soft.obj"],
        &[
            "rethicken",
            "m.obj",
            "--thickness",
            "m.thickness.csv",
            "--json",
            "m.thickness.csv",
        ],
        &["offset", "plate.obj", "--distance", "1", "-o", "hard.obj"],
        &[
            "extract",
            "plate.obj",
            "--coping",
            "tags.txt",
            "--json",
            "soft.json",
        ],
        &[
            "extract",
            "plate.obj",
            "-o",
            "a.obj",
            "--json",
            "a.thickness.csv",
        ],
        &["extract", "plate.obj", "-o", "a.ply", "-o", "./a.ply"],
        &["tags", "plate.obj", "tags.txt", "-o", "hard.obj"],
        &["roundtrip", "plate.obj", "-o", "d.ply", "--solid", "d.ply"],
        &[
            "subdivide",
            "plate.obj",
            "--thickness",
            "0.1",
            "-o",
            "hard.obj",
        ],
    ] {
        let told = check(&desk.run(args), 2);
        assert!(told.contains("named twice"), "{args:?}: {told}");
    }
    let after: Vec<_> = desk
        .files()
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect();
    assert!(before == after);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_leaves_nothing_behind() {
    for signal in ["-INT", "-TERM"] {
        // The moment of writing may be missed.
        let met = (0..10).any(|_| interrupted(signal));
        assert!(met, "{signal}");
    }
}

/// Whether the command could be interrupted while it was writing a file.
#[cfg(target_os = "linux")]
fn interrupted(signal: &str) -> bool {
    let desk = Desk::new();
    let mut run = Command::new(BINARY)
        .current_dir(desk.path(""))
        .args([
            "subdivide",
            "--interpolate",
            "--samples",
            "128",
            "-q",
            "-o",
            "a.obj",
        ])
        .arg(fixture("cages/cube.obj"))
        .spawn()
        .unwrap();
    let passing = || desk.files().iter().any(|file| is_passing(file));
    while run.try_wait().unwrap().is_none() {
        if passing() {
            let id = run.id().to_string();
            Command::new("kill").args([signal, &id]).status().unwrap();
            let code = run.wait().unwrap().code();
            assert!(!passing(), "{signal}: {:?}", desk.files());
            return code == Some(130);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!passing());
    false
}

#[cfg(target_os = "linux")]
fn is_passing(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default();
    name.to_string_lossy().starts_with(".midsurf-")
}

/// Runs under a limit of the shell's `ulimit`.
#[cfg(target_os = "linux")]
fn under(limit: &str, desk: &Desk, args: &[&str]) -> Output {
    let words = format!("ulimit {limit} && exec \"$0\" \"$@\"");
    Command::new("sh")
        .current_dir(desk.path(""))
        .args(["-c", &words, BINARY])
        .args(args)
        .output()
        .unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn fewer_threads_than_asked_for_are_no_failure() {
    let desk = Desk::new();
    let plate = fixture("plate.obj");
    let args = ["extract", plate.to_str().unwrap(), "-j", "1024", "-o"];
    // Address space for some of the stacks only.
    let told = check(
        &under("-v 3000000", &desk, &[&args[..], &["a.obj"]].concat()),
        0,
    );
    assert!(told.contains("fewer than 1024 threads"), "{told}");
    check(
        &desk.run(&["extract", args[1], "-j", "1", "-o", "b.obj"]),
        0,
    );
    let [a, b] = ["a.obj", "b.obj"].map(|file| std::fs::read(desk.path(file)).unwrap());
    assert!(a == b);
}

#[cfg(target_os = "linux")]
#[test]
fn endless_and_large_inputs_stop_at_the_bound() {
    let desk = Desk::new();
    std::os::unix::fs::symlink("/dev/zero", desk.path("zero.obj")).unwrap();
    let told = check(&desk.run(&["info", "zero.obj", "--max-input", "1M"]), 2);
    assert!(
        told.contains("1048576 bytes") && told.contains("--max-input"),
        "{told}"
    );
    desk.put("large.txt", "#".repeat(2000));
    let plate = fixture("plate.obj");
    let plate = plate.to_str().unwrap();
    let told = check(
        &desk.run(&["tags", plate, "large.txt", "--max-input", "1500"]),
        2,
    );
    assert!(told.contains("1500 bytes"), "{told}");
}

#[test]
fn files_of_nothing_but_short_lists_are_refused_at_once() {
    let desk = Desk::new();
    let count = 3_000_000;
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n\
         property float y\nproperty float z\nelement face {count}\n\
         property list uchar int vertex_indices\nend_header\n"
    );
    let body = vec![0_u8; 12 + count];
    desk.put("lists.ply", [header.as_bytes(), &body].concat());
    let told = check(&desk.run(&["info", "lists.ply"]), 2);
    assert!(told.contains("three corners"), "{told}");
    let real = header.replace("list uchar int", "list float int");
    desk.put("real.ply", [real.as_bytes(), &body].concat());
    let told = check(&desk.run(&["info", "real.ply"]), 2);
    assert!(told.contains("floating point"), "{told}");
    // One face of very many corners.
    desk.put(
        "face.obj",
        format!("v 0 0 0\nf{}\n", " 1".repeat(1_000_000)),
    );
    let told = check(&desk.run(&["info", "face.obj"]), 2);
    assert!(
        told.contains("1000000 corners") || told.contains("too large"),
        "{told}"
    );
    let told = check(&desk.run(&["subdivide", "face.obj", "--thickness", "1"]), 2);
    assert!(told.contains("too large"), "{told}");
}

#[test]
fn walls_out_of_proportion_are_refused() {
    let desk = Desk::new();
    let cube = fixture("cages/cube.obj");
    let cube = cube.to_str().unwrap();
    for scheme in ["crust", "direct", "contour"] {
        let args = [
            "subdivide",
            cube,
            "--thickness",
            "1e300",
            "--scheme",
            scheme,
            "-o",
            "a.obj",
        ];
        let told = check(&desk.run(&args), 2);
        assert!(told.contains("proportion"), "{told}");
    }
    assert_eq!(desk.files().len(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn what_does_not_fit_into_memory_is_refused() {
    let desk = Desk::new();
    let cage = fixture("cages/genus3.obj");
    let cage = cage.to_str().unwrap();
    let samples = ["subdivide", cage, "--thickness", "0.01", "--samples", "128"];
    let told = check(
        &desk.run(&[&samples[..], &["--memory-limit", "1G"]].concat()),
        2,
    );
    assert!(
        told.contains("samples would fit") && told.contains("--memory-limit"),
        "{told}"
    );
    let told = check(&under("-v 700000", &desk, &samples), 2);
    assert!(told.contains("samples would fit"), "{told}");
    let levels = [
        "subdivide",
        cage,
        "--thickness",
        "0.01",
        "--levels",
        "8",
        "--memory-limit",
        "2G",
    ];
    check(&desk.run(&levels), 2);
    desk.put("large.obj", "v 0 0 0\n".repeat(8_000_000));
    let told = check(&under("-v 700000", &desk, &["info", "large.obj"]), 4);
    assert!(told.contains("would fit"), "{told}");
    let plate = fixture("plate.obj");
    let plate = plate.to_str().unwrap();
    let fine = ["offset", plate, "--distance", "0.5", "--cell", "0.01"];
    let told = check(&under("-v 700000", &desk, &fine), 2);
    assert!(told.contains("smallest cell that fits"), "{told}");
}

/// Quadratic work would take minutes here.
#[test]
fn many_names_patterns_and_rules_are_no_trouble() {
    let desk = Desk::new();
    let corners = "v 0 0 0\nv 9 0 0\nv 9 9 0\nv 0 9 0\nv 0 0 1\nv 9 0 1\nv 9 9 1\nv 0 9 1\n";
    let faces = [
        "4 3 2 1", "5 6 7 8", "1 2 6 5", "3 4 8 7", "4 1 5 8", "2 3 7 6",
    ];
    let mut mesh = corners.to_owned();
    for number in 0..100_000 {
        mesh += &format!("g name_{number}\nf {}\n", faces[number % 6]);
    }
    desk.put("names.obj", mesh);
    let tags: String = (0..2000).map(|n| format!("group: name_{n}*\n")).collect();
    desk.put("patterns.txt", tags);
    check(&desk.run(&["tags", "names.obj", "patterns.txt"]), 0);
    let head = "format = \"coping-tags\"\nversion = 1\n";
    let rules: String = (0..50_000)
        .map(|n| format!("[[coping]]\ntriangles = [{n}]\n"))
        .collect();
    desk.put("rules.toml", format!("{head}{rules}"));
    check(&desk.run(&["tags", "names.obj", "rules.toml"]), 0);
    desk.put(
        "ranges.txt",
        "0-199999:2 0-199999\n"
            .repeat(20_000)
            .replace("199999", "99999"),
    );
    check(&desk.run(&["tags", "names.obj", "ranges.txt"]), 0);
}

#[test]
fn tangled_polygons_are_given_up() {
    let desk = Desk::new();
    // A star that winds around many times.
    let count = 5000;
    let mut mesh = String::new();
    for k in 0..count {
        let angle = 2.4 * f64::from(k);
        mesh += &format!("v {} {} 0\n", angle.cos(), angle.sin());
    }
    let ring: String = (1..=count).map(|k| format!(" {k}")).collect();
    mesh += &format!("f{ring}\n");
    desk.put("star.obj", mesh);
    desk.put("tags.txt", "0\n");
    let told = check(&desk.run(&["tags", "star.obj", "tags.txt"]), 0);
    assert!(told.contains("cross themselves"), "{told}");
    let told = check(&desk.run(&["thicken", "star.obj", "--thickness", "0.1"]), 2);
    assert!(told.contains("cuts through itself"), "{told}");
}

/// Where memory is refused in the middle of work the command ends in words, with the
/// code for no result, and leaves nothing behind.
#[cfg(target_os = "linux")]
#[test]
fn refused_memory_is_no_crash() {
    let desk = Desk::new();
    let mesh = cuboid(DVec3::ZERO, DVec3::new(9.0, 9.0, 1.0));
    desk.put("plate.obj", obj_text(&mesh));
    // A small file that asks for much once it is read: a million copies of a box.
    let mut model = String::from("<model><resources><object id='1'><mesh><vertices>");
    for p in &mesh.positions {
        model += &format!("<vertex x='{}' y='{}' z='{}'/>", p.x, p.y, p.z);
    }
    model += "</vertices><triangles>";
    for [a, b, c] in &mesh.triangles {
        model += &format!("<triangle v1='{a}' v2='{b}' v3='{c}'/>");
    }
    model += "</triangles></mesh></object>";
    for level in 2..8 {
        let parts = format!("<component objectid='{}'/>", level - 1).repeat(10);
        model += &format!("<object id='{level}'><components>{parts}</components></object>");
    }
    model += "</resources><build><item objectid='6'/></build></model>";
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("3D/3dmodel.model", zip::write::SimpleFileOptions::default())
        .unwrap();
    std::io::Write::write_all(&mut zip, model.as_bytes()).unwrap();
    desk.put("copies.3mf", zip.finish().unwrap().into_inner());
    let before = desk.files();
    let told = check(
        &under(
            "-v 500000",
            &desk,
            &["extract", "copies.3mf", "-o", "a.obj"],
        ),
        4,
    );
    assert!(
        told.contains("out of memory") || told.contains("would fit"),
        "{told}"
    );
    assert_eq!(desk.files(), before);
    // What fits is none the worse for the bound.
    check(
        &under(
            "-v 500000",
            &desk,
            &["extract", "plate.obj", "-j", "2", "-o", "b.obj"],
        ),
        0,
    );
}

/// Files of every format, larger than the memory that a process has left.
#[cfg(target_os = "linux")]
#[test]
fn readers_keep_within_the_memory_of_the_process() {
    let desk = Desk::new();
    let lines = |line: &str| line.repeat((60 << 20) / line.len());
    let binary = |head: &[u8]| [head, &vec![0x3f; 60 << 20]].concat();
    let triangles = (60_u32 << 20) / 50;
    let mut stl = vec![0; 84 + 50 * triangles as usize];
    stl[80..84].copy_from_slice(&triangles.to_le_bytes());
    for (name, content) in [
        ("a.obj", lines("v 1 2 3\nf 1 1 1\n").into_bytes()),
        ("a.stl", stl),
        (
            "a.off",
            format!("OFF\n9000000 1 0\n{}", lines("1 2 3\n")).into_bytes(),
        ),
        (
            "a.ply",
            binary(
                b"ply\nformat binary_little_endian 1.0\nelement vertex 5000000\n\
                  property float x\nproperty float y\nproperty float z\nend_header\n",
            ),
        ),
        (
            "a.msh",
            format!(
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9000000\n{}",
                lines("1 2 3 4\n")
            )
            .into_bytes(),
        ),
        (
            "a.inp",
            format!("*NODE\n{}", lines("1, 2, 3, 4\n")).into_bytes(),
        ),
        ("a.bdf", lines("GRID,1,,1.,2.,3.\n").into_bytes()),
        (
            "a.gltf",
            format!("{{\"nodes\": [{}]}}", lines("{},").trim_end_matches(',')).into_bytes(),
        ),
        ("a.3mf", binary(b"PK\x03\x04")),
    ] {
        desk.put(name, content);
        let output = under("-v 500000", &desk, &["info", name]);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 2 | 4)), "{name}: {code:?}");
        let told = check(&output, code.unwrap());
        assert!(!told.contains("panicked"), "{name}: {told}");
        std::fs::remove_file(desk.path(name)).unwrap();
    }
}
