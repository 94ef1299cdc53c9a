//! `midsurf tags detect`: the coping faces of a part, found by the program.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use midsurf::coping::detect::{Detection, Options, Question};
use midsurf::coping::{detect, detected_text, detected_toml};
use midsurf::intake::{facets, shown_ranges};
use midsurf::io::LoadedMesh;
use midsurf::io::write::{stage, stage_picture};
use midsurf::report::detection::account;
use midsurf::settings::quote::figure;
use midsurf::settings::warning::Warning;
use serde_json::{Value, json};

use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::{RunArgs, check_suffix};

const EXAMPLES: &str = "\
Examples:
  midsurf tags detect bracket.stl -o bracket.coping.toml
  midsurf tags detect bracket.stl -o bracket.coping.txt --json faces.json
  midsurf tags detect bracket.stl --list --picture doubts.png

Writes an ordinary tag file, to read, edit and give to --coping: TOML if the
name ends in .toml, else ranges of triangles. What is not sure is asked about,
gravest first; --coping with `rest = \"auto\"` in a TOML file answers single
questions and leaves the rest to the program.

Exit codes: 0 done, 2 wrong usage or bad input.";

/// Find the coping faces of a part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// Tag file to write: TOML if the name ends in .toml, else text
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// About how many points of the surface to look at [default: one a squared wall
    /// thickness, 4000 to 8000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    samples: Option<u32>,
    /// Picture of the part (.png): coping red, in doubt yellow if coping and
    /// orange if wall
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Print every face, not only those in doubt
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode, Failure> {
    let outputs = args.output.iter().chain(&args.picture).cloned().collect();
    args.run.check_names(&[(&*args.part, "part")], outputs)?;
    if let Some(file) = &args.picture {
        check_suffix(file, ".png")?;
    }
    let progress = args.run.start()?;
    let start = Instant::now();
    let (loaded, warnings) = args.reading.with(Some(&args.select)).load(&args.part)?;
    if !args.run.quiet {
        progress.aside(|| print_warnings(&warnings));
    }
    progress.show("detecting", 0, 0);
    let options = Options {
        samples: args.samples.map(|samples| samples as usize),
    };
    let detection = detect(&loaded.mesh, &options);
    drop(progress);
    let report = as_json(args, &loaded, &detection, (start, &warnings));

    let mut staged = Vec::new();
    if let Some(file) = &args.output {
        let is_toml = file
            .extension()
            .is_some_and(|suffix| suffix.eq_ignore_ascii_case("toml"));
        let text = if is_toml {
            detected_toml(&detection, &loaded)
        } else {
            detected_text(&detection, &loaded)
        };
        staged.push(stage(file, |out| out.write_all(text.as_bytes())).map_err(Failure::output)?);
    }
    if let Some(file) = &args.picture {
        let colours = colours(&detection);
        staged.push(stage_picture(&loaded.mesh, &colours, file).map_err(Failure::output)?);
    }
    args.run.finish(staged, &report)?;
    if !args.run.quiet && !args.run.reports_to_stdout() {
        let mut out = io::stdout().lock();
        print(&detection, &loaded.source, args.list, &mut out)?;
        out.flush()?;
    }
    Ok(ExitCode::SUCCESS)
}

/// One colour a triangle: what was decided, and what is asked about.
fn colours(detection: &Detection) -> Vec<[u8; 3]> {
    let mut asked = vec![false; detection.faces.len()];
    for face in detection
        .questions()
        .iter()
        .flat_map(|question| &question.faces)
    {
        asked[*face] = true;
    }
    let mut colours = vec![[0; 3]; detection.flags.len()];
    for face in &detection.faces {
        let colour = match (face.coping, asked[face.number]) {
            (true, false) => [215, 60, 50],
            (true, true) => [250, 210, 40],
            (false, true) => [250, 140, 30],
            (false, false) => [170, 190, 210],
        };
        for &triangle in &face.triangles {
            colours[triangle as usize] = colour;
        }
    }
    colours
}

/// The summary for people: totals, questions, on demand all faces.
fn print(
    detection: &Detection,
    source: &[u32],
    list: bool,
    out: &mut impl Write,
) -> io::Result<()> {
    let area = |coping: bool| -> f64 {
        let faces = detection.faces.iter().filter(|face| face.coping == coping);
        faces.map(|face| face.area).sum()
    };
    let coping = detection.faces.iter().filter(|face| face.coping).count();
    writeln!(
        out,
        "faces        {}, {coping} of them coping",
        detection.faces.len()
    )?;
    writeln!(
        out,
        "coping       {} triangles, area {} of {}",
        detection.flags.iter().filter(|&&flag| flag).count(),
        figure(area(true)),
        figure(area(true) + area(false))
    )?;
    writeln!(
        out,
        "thin wall    {:.0} % of the surface",
        100.0 * detection.thin_share
    )?;
    if let Some(words) = detection.verdict().text() {
        writeln!(out, "note         {words}")?;
    }
    let questions = detection.questions();
    if questions.is_empty() {
        writeln!(out, "questions    none")?;
    }
    for (number, question) in questions.iter().enumerate() {
        writeln!(
            out,
            "question {:<3} {}",
            number + 1,
            question.text(detection)
        )?;
        let first = &detection.faces[question.faces[0]];
        writeln!(
            out,
            "             triangles {}",
            shown_ranges(&facets(source, &first.triangles))
        )?;
    }
    if list {
        for face in &detection.faces {
            let taken = if face.coping { "coping" } else { "wall" };
            writeln!(out, "face {:<7} {taken:<6} {}", face.number, face.summary())?;
        }
    }
    Ok(())
}

fn as_json(
    args: &Args,
    loaded: &LoadedMesh,
    detection: &Detection,
    (start, warnings): (Instant, &[Warning]),
) -> Value {
    let questions = detection.questions();
    Envelope {
        command: "tags detect",
        input: json!({
            "part": named(&args.part),
            "sha256": loaded.sha256,
            "triangles": loaded.mesh.triangles.len(),
        }),
        settings: json!({ "samples": args.samples }),
        seconds: json!({ "total": start.elapsed().as_secs_f64() }),
        outputs: args.output.iter().map(PathBuf::as_path).collect(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "result": account(detection),
        "questions": questions.iter().map(|q| question_json(q, detection)).collect::<Vec<_>>(),
    }))
}

fn question_json(question: &Question, detection: &Detection) -> Value {
    json!({
        "faces": question.faces,
        "coping": question.coping,
        "doubt": question.doubt,
        "reasons": question.reasons,
        "text": question.text(detection),
    })
}
