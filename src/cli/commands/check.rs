//! `midsurf check`: a mid-surface of any program, held against its part.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use midsurf::check::{Check, LEAST_ANGLE, Limits, Measure, Outcome};
use midsurf::intake::{CopingSource, Input};
use midsurf::io::read_any_surface;
use midsurf::io::write::stage_fields;
use midsurf::settings::quote::figure;
use serde_json::{Value, json};

use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::numbers::positive;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::Envelope;
use crate::cli::shared::run::RunArgs;

/// Places that a report states of each measure; all are counted.
const PLACES_SHOWN: usize = 100;

const EXAMPLES: &str = "\
Examples:
  midsurf check part.stl mid.ply --coping part.toml
  midsurf check part.obj model.inp --coping part.coping.txt --fail-on any -o defects.vtu
  midsurf check part.stl other.bdf --tolerance 0.05 --fail-on nodes_off_middle,unwelded

MODEL is a mid-surface of any program: .obj, .ply, .stl, .off, and the shells of .inp,
.bdf and .msh. The middle is where a ball touches two walls, at any thickness.

Measures: nodes_off_middle, nodes_off_sides, nodes_outside, edges_off_sides,
centres_off_middle (HyperMesh's five), uncovered, excess, unwelded, pieces, seams_off,
thickness_off, small_angles, folds, crossings.

-o writes the mesh with `defects` (bits in the order above), `off_middle` for ParaView.

Exit codes: 0 done, 1 done but a measure named by --fail-on is not clean, 2 wrong usage
or bad input.";

/// Measure a mid-surface of any program against its part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part: a closed triangle or polygon mesh
    part: PathBuf,
    /// The mid-surface
    model: PathBuf,
    /// Coping tags of the part: a file (text, or TOML if the name ends in .toml), `auto` to find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    coping: CopingSource,
    /// Greatest deviation that passes, as a share of the wall's thickness
    #[arg(long, value_name = "SHARE", default_value_t = Limits::default().tolerance, value_parser = positive, allow_negative_numbers = true)]
    tolerance: f64,
    /// The same within a thickness of seams and bends
    #[arg(long, value_name = "SHARE", default_value_t = Limits::default().near_seams, value_parser = positive, allow_negative_numbers = true)]
    near_seams: f64,
    /// Measures that must be clean, with commas between, or `any`
    #[arg(long, value_name = "MEASURES", value_delimiter = ',', value_parser = measures)]
    fail_on: Vec<Vec<Measure>>,
    /// Write the mid-surface with its defects (.vtu)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
    #[command(flatten)]
    run: RunArgs,
}

fn measures(text: &str) -> Result<Vec<Measure>, String> {
    if text == "any" {
        return Ok(Measure::ALL.to_vec());
    }
    let named = Measure::ALL.into_iter().filter(|m| m.name() == text);
    let found: Vec<Measure> = named.collect();
    match found.is_empty() {
        true => {
            let names: Vec<&str> = Measure::ALL.iter().map(|m| m.name()).collect();
            Err(format!("expected `any` or some of {}", names.join(", ")))
        }
        false => Ok(found),
    }
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let mut inputs = vec![
        (args.part.as_path(), "part"),
        (args.model.as_path(), "model"),
    ];
    inputs.extend(args.coping.file().map(|file| (file, "coping tags")));
    args.run
        .check_names(&inputs, args.output.iter().cloned().collect())?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let reading = args.reading.with(Some(&args.select));
    let input = Input::read(&args.part, &args.coping, &reading, false)?;
    let (surface, with_thickness) = read_any_surface(&args.model).map_err(Failure::input)?;
    input.owns(&args.model, &surface)?;
    progress.show("checking", 0, 0);
    let limits = Limits {
        tolerance: args.tolerance,
        near_seams: args.near_seams,
        ..Limits::default()
    };
    let check = Check::of(&input.part, &surface, with_thickness, &limits);

    let mut staged = Vec::new();
    if let Some(file) = &args.output {
        let marks: Vec<f64> = check.marks.iter().map(|&m| f64::from(m)).collect();
        let points = [("off_middle", &check.off_middle[..])];
        let cells = [("defects", &marks[..])];
        staged.push(stage_fields(&surface.mesh(), &points, &cells, file).map_err(Failure::output)?);
    }
    let fails: Vec<&Outcome> = (check.outcomes.iter())
        .filter(|o| o.count > 0 && args.fail_on.iter().flatten().any(|m| *m == o.measure))
        .collect();
    let report = Envelope {
        command: "check",
        input: json!({
            "part": input.file,
            "sha256": input.sha256,
            "coping": args.coping.file(),
            "model": args.model,
            "vertices": surface.vertices().len(),
            "triangles": surface.triangles().len(),
        }),
        settings: args.reading.beside(
            Some(&args.select),
            json!({
                "tolerance": args.tolerance,
                "near_seams": args.near_seams,
                "fail_on": args.fail_on.iter().flatten().map(|m| m.name()).collect::<Vec<_>>(),
            }),
        ),
        seconds: json!(start.elapsed().as_secs_f64()),
        outputs: args.output.iter().map(PathBuf::as_path).collect(),
        warnings: input.warnings.iter().collect(),
    }
    .around(json!({
        "thickness": check.thickness,
        "covered": check.covered,
        "failed": fails.iter().map(|o| o.measure.name()).collect::<Vec<_>>(),
        "measures": check.outcomes.iter().map(told).collect::<Vec<Value>>(),
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&input.warnings);
        summary(&check);
    }
    for outcome in &fails {
        say(format_args!("failed: {}", outcome.measure.name()));
    }
    Ok(ExitCode::from(u8::from(!fails.is_empty())))
}

fn told(outcome: &Outcome) -> Value {
    let places = &outcome.defects[..outcome.defects.len().min(PLACES_SHOWN)];
    json!({
        "measure": outcome.measure.name(),
        "checked": outcome.checked,
        "count": outcome.count,
        "worst": outcome.worst,
        "mean": outcome.mean,
        "limit": outcome.limit,
        "places": places,
    })
}

fn summary(check: &Check) {
    say(format_args!(
        "{:20} {:>8} of {:>8}   worst, its limit",
        "measure", "places", "checked"
    ));
    for o in &check.outcomes {
        let place = o.defects.first().map(|d| {
            let [x, y, z] = d.at.to_array().map(figure);
            format!("   at ({x}, {y}, {z})")
        });
        say(format_args!(
            "{:20} {:>8} of {:>8}   {:.3}, {:.3}{}",
            o.measure.name(),
            o.count,
            o.checked,
            o.worst,
            o.limit,
            place.unwrap_or_default()
        ));
    }
    say(format_args!(
        "walls covered {:.1} %, median thickness {}, angles listed below {LEAST_ANGLE} degrees",
        100.0 * check.covered,
        figure(check.thickness)
    ));
}
