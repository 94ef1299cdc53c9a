//! The README keeps its promises.

use midsurf::surface::MidSurface;

use crate::common::{Desk, text};

fn file(name: &str) -> String {
    std::fs::read_to_string(format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Content of the first code block of a language.
fn block(readme: &str, language: &str) -> Vec<String> {
    let lines = readme.lines().map(str::trim);
    let inside = lines
        .skip_while(|line| *line != format!("```{language}"))
        .skip(1);
    inside
        .take_while(|line| *line != "```")
        .map(str::to_owned)
        .collect()
}

/// The README's example of library use, word for word.
#[rustfmt::skip]
fn example() -> Result<MidSurface, Box<dyn std::error::Error>> {
    use midsurf::CellSize;
    use midsurf::extract::{Settings, extract};
    use midsurf::io::read_mesh;
    use midsurf::mesh::{Part, PartOptions};
    use midsurf::coping::read_tags;

    let loaded = read_mesh("fixtures/tee.obj")?;
    let coping = read_tags("fixtures/tee.coping.txt", &loaded, "fixtures/tee.obj".as_ref())?;
    let (part, _warnings) = Part::new(loaded.mesh, coping.flags, PartOptions::default())?;
    let settings = Settings { cell: CellSize::Thicknesses(1.0), ..Settings::default() };
    let result = extract(&part, &settings, &|_stage, _done, _expected| ())?;
    println!("{} sheets, {} cracks", result.surface.sheet_count(), result.graph.cracks().len());
    Ok(result.surface)
}

#[test]
fn library_example_works_as_printed() {
    // Tests run in the package's folder.
    assert_eq!(example().unwrap().sheet_count(), 3);
    let source = file("tests/it/readme.rs");
    let source: Vec<&str> = source.lines().map(str::trim).collect();
    for line in block(&file("README.md"), "rust") {
        assert!(source.contains(&line.as_str()), "{line}");
    }
}

#[test]
fn first_command_works_and_second_is_what_ci_runs() {
    let commands = block(&file("README.md"), "sh");
    assert_eq!(commands.len(), 2);
    let ci = file(".ci/run");
    assert!(
        ci.lines()
            .any(|line| line == format!("step {}", commands[1])),
        "{}",
        commands[1]
    );

    let desk = Desk::new();
    let args = commands[0].strip_prefix("cargo run --release -- ").unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/");
    let args = args.replace("fixtures/", root);
    let output = desk.run(&args.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let mut names = desk.files();
    names.sort();
    let expected = ["mid.obj", "mid.thickness.csv", "report.json"];
    assert_eq!(names, expected.map(|name| desk.path(name)));
}

#[test]
fn tag_example_is_read() {
    let desk = Desk::new();
    let mut rows: Vec<String> = block(&file("README.md"), "toml");
    // Bound to a mesh of its own.
    rows.retain(|row| !row.starts_with("triangles ="));
    desk.put(
        "tags.toml",
        rows.join("\n") + "\n[options]\non_empty = \"ignore\"\n",
    );
    let part = crate::common::fixture("tee.obj");
    let output = desk.run(&["tags", part.to_str().unwrap(), "tags.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}
