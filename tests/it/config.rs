//! Flags from a file, the log, and progress for programs.

use serde_json::Value;

use crate::common::{Desk, fixture, text};

fn plate(desk: &Desk) {
    std::fs::copy(fixture("plate.obj"), desk.path("plate.obj")).unwrap();
}

fn report(desk: &Desk, args: &[&str]) -> Value {
    let output = desk.run(&[args, &["--json", "-", "-q"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn keys_are_flags_and_the_command_line_goes_before() {
    let desk = Desk::new();
    plate(&desk);
    desk.put(
        "run.toml",
        "cell = \"0.7t\"\nkeep-fins = true\noutput = [\"a.ply\", \"a.vtu\"]\nthreads = 1\n\
         [extract]\nangle = 20\n[offset]\ndistance = 1.5\ncell = 2\n",
    );
    let told = report(&desk, &["extract", "plate.obj", "--config", "run.toml"]);
    assert_eq!(told["settings"]["cell"], "0.7t");
    assert_eq!(told["settings"]["angle"], 20.0);
    assert_eq!(told["settings"]["keep_fins"], true);
    assert_eq!(told["settings"]["threads"], 1);
    assert_eq!(told["config"]["file"], "run.toml");
    assert_eq!(told["config"]["keys"]["extract"]["angle"], 20);
    assert!(desk.path("a.ply").is_file() && desk.path("a.vtu").is_file());
    let args = [
        "extract",
        "plate.obj",
        "--config=run.toml",
        "--cell",
        "0.9t",
        "-o",
        "b.ply",
    ];
    let told = report(&desk, &args);
    assert_eq!(told["settings"]["cell"], "0.9t");
    assert_eq!(told["outputs"], serde_json::json!(["b.ply"]));
    // A flag that the command must have may stand in the file.
    desk.put(
        "offset.toml",
        "distance = -0.5\ncell = 1.0\nunit = \"mm\"\n",
    );
    let told = report(&desk, &["offset", "plate.obj", "--config", "offset.toml"]);
    assert_eq!(told["settings"]["distance"], -0.5);
    assert_eq!(told["settings"]["unit"], "mm");
    assert!(report(&desk, &["extract", "plate.obj"])["config"].is_null());
}

#[test]
fn what_is_no_flag_is_refused() {
    let desk = Desk::new();
    plate(&desk);
    for (content, words) in [
        ("cells = 1\n", "no flag \"--cells\""),
        ("cell = [[1]]\nangle = {}\n", "angle"),
        ("keep-fins = \"yes\"\n", "keep-fins"),
        ("cell = \n", "run.toml"),
        ("cell = \"wide\"\n", "--cell"),
    ] {
        desk.put("run.toml", content);
        let output = desk.run(&["extract", "plate.obj", "--config", "run.toml"]);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{content}: {told}");
        assert!(told.contains(words), "{content}: {told}");
    }
    let output = desk.run(&["extract", "plate.obj", "--config", "nowhere.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("nowhere.toml"));
}

#[test]
fn the_config_and_the_log_overwrite_nothing() {
    let desk = Desk::new();
    plate(&desk);
    let content = "cell = \"1t\"\n";
    desk.put("run.toml", content);
    for args in [
        &[
            "extract",
            "plate.obj",
            "--config",
            "run.toml",
            "--json",
            "run.toml",
        ][..],
        &[
            "extract",
            "plate.obj",
            "--config",
            "run.toml",
            "--log-file",
            "run.toml",
        ],
        &["extract", "plate.obj", "--log-file", "plate.obj"],
        &[
            "extract",
            "plate.obj",
            "--log-file",
            "a.json",
            "--json",
            "a.json",
        ],
    ] {
        let output = desk.run(args);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {told}");
        assert!(told.contains("named twice"), "{told}");
    }
    assert_eq!(
        std::fs::read_to_string(desk.path("run.toml")).unwrap(),
        content
    );
    assert_eq!(desk.files().len(), 2);
}

#[test]
fn the_log_has_what_is_said_and_the_stages() {
    let desk = Desk::new();
    plate(&desk);
    let output = desk.run(&["extract", "plate.obj", "--log-file", "run.log"]);
    assert_eq!(output.status.code(), Some(0));
    let log = std::fs::read_to_string(desk.path("run.log")).unwrap();
    for stage in ["reading", "field", "mesh"] {
        assert!(
            log.lines()
                .any(|line| line.ends_with(&format!("] {stage}"))),
            "{log}"
        );
    }
    for line in text(&output.stderr).lines() {
        assert!(log.contains(line), "{line}");
    }
    assert!(log.contains(" DEBUG "), "{log}");
    desk.put("bad.obj", "v 0 0 nan\n");
    let output = desk.run(&["extract", "bad.obj", "--log-file", "bad.log", "-q"]);
    assert_eq!(output.status.code(), Some(2));
    let log = std::fs::read_to_string(desk.path("bad.log")).unwrap();
    assert!(log.contains("Error: bad.obj, line 1"), "{log}");
}

#[test]
fn stages_are_told_as_often_as_asked() {
    let desk = Desk::new();
    plate(&desk);
    let said = |flags: &[&str]| {
        let output = desk.run(&[&["extract", "plate.obj"], flags].concat());
        assert_eq!(output.status.code(), Some(0));
        text(&output.stderr)
    };
    let [none, once, twice] = [&[][..], &["-v"], &["-vv"]].map(said);
    assert!(!none.contains(" INFO "), "{none}");
    for event in ["traced cells=", "trace took ", "field took "] {
        assert!(once.contains(event), "{once}");
    }
    assert!(!once.contains("DEBUG"), "{once}");
    assert!(twice.contains("DEBUG"), "{twice}");
    let output = desk.run(&[
        "offset",
        "plate.obj",
        "--distance",
        "1",
        "-o",
        "o.stl",
        "-v",
    ]);
    assert!(text(&output.stderr).contains("band took "));
    let output = desk.run(&["extract", "plate.obj", "-v", "-q"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn progress_for_programs_is_json() {
    let desk = Desk::new();
    plate(&desk);
    let output = desk.run(&["extract", "plate.obj", "--progress", "json"]);
    let told = text(&output.stderr);
    let lines: Vec<Value> = (told.lines().filter(|line| line.starts_with('{')))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let stages: Vec<&str> = lines
        .iter()
        .map(|line| line["stage"].as_str().unwrap())
        .collect();
    assert_eq!(stages.first(), Some(&"reading"));
    assert_eq!(stages.last(), Some(&"end"));
    assert!(stages.contains(&"mesh"), "{stages:?}");
    let seconds: Vec<f64> = lines
        .iter()
        .map(|line| line["seconds"].as_f64().unwrap())
        .collect();
    assert!(seconds.is_sorted());
    let output = desk.run(&["extract", "plate.obj", "--progress", "json", "-q"]);
    assert_eq!(output.status.code(), Some(2));
}
