//! `midsurf extract`: part and tags in, mid-surface and report out.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use midsurf::io::write::{
    SurfaceOptions, WriteError, check_target, files_for, stage, stage_surface,
};
use midsurf::mesh::midsurface::MidSurface;
use midsurf::mesh::{Part, PartOptions};
use serde::Serialize;
use serde_json::{Value, json};

use super::cell::CellSize;
use super::failure::Failure;
use super::info::figure;
use super::input::{Input, Warning, print_warnings};
use super::progress::Progress;
use super::say;

/// Version of the JSON report's layout.
const REPORT_SCHEMA: u32 = 1;

const EXAMPLES: &str = "\
Examples:
  midsurf extract bracket.obj --coping bracket.coping.txt -o mid.obj
  midsurf extract part.stl --coping part.toml --cell 0.5t -o mid.vtu -o mid.ply
  midsurf extract part.obj --coping part.coping.txt --cell 1.0 -o mid.obj --json report.json

The suffix of -o tells the format: .obj (one group a sheet, with NAME.thickness.csv
beside it), .ply and .vtu (with thickness), .stl. An open part is refused;
--allow-open goes on all the same, but inside and outside are then guesses near
the gaps, and sheets may be missing or cut short there.

Exit codes: 0 done, 1 done but the result has cracks, 2 wrong usage or bad input,
4 no usable result, 130 interrupted.";

/// Extract the mid-surface of a part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
#[command(group = clap::ArgGroup::new("outputs").required(true).multiple(true).args(["output", "json"]))]
pub(super) struct Args {
    /// The part: a closed triangle or polygon mesh (.obj, .stl, .ply, .off)
    part: PathBuf,
    /// Coping tags: text, or TOML if the name ends in .toml
    #[arg(long, value_name = "FILE")]
    coping: Option<PathBuf>,
    /// Cell size: a length, `0.5t` (wall thicknesses), `1%` (of the diagonal), or auto
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    cell: CellSize,
    /// Smallest object angle of a sheet in degrees, between 0 and 180
    #[arg(long, value_name = "DEG", value_parser = angle, allow_negative_numbers = true)]
    angle: Option<f64>,
    /// Threads to use; the result does not depend on it
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Output file; repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Write a report as JSON; `-` for stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Keep the fins that run into convex edges of one wall
    #[arg(long)]
    keep_fins: bool,
    /// Go on when the part has gaps
    #[arg(long)]
    allow_open: bool,
    /// Merge vertices of the part within this distance
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    weld: Option<f64>,
    /// Write seams and borders into OBJ files too, as lines
    #[arg(long)]
    obj_lines: bool,
    /// Print errors and nothing else
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,
    /// Print more; twice for all
    #[arg(short, long, action = clap::ArgAction::Count)]
    verbose: u8,
}

/// Settings of the extraction, checked.
#[derive(Clone, Copy, Debug, Serialize)]
struct Settings {
    cell: CellSize,
    angle: Option<f64>,
    keep_fins: bool,
}

/// What the extraction hands back.
struct Extraction {
    surface: MidSurface,
    cracks: usize,
    /// Counts, areas, times: goes into the report as it is.
    facts: Value,
    /// Lines for stderr.
    summary: Vec<String>,
    warnings: Vec<Warning>,
}

fn angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(angle) if angle > 0.0 && angle < 180.0 => Ok(angle),
        _ => Err("expected degrees between 0 and 180".to_owned()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(length) if length > 0.0 && length.is_finite() => Ok(length),
        _ => Err("expected a positive length".to_owned()),
    }
}

pub(super) fn run(args: Args) -> Result<ExitCode, Failure> {
    check_names(&args)?;
    if let Some(threads) = args.threads {
        // Fails only if the pool exists already; nothing ran before this.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global();
    }
    let progress = Progress::new(args.quiet);
    progress.stage("reading", 0);
    let options = PartOptions {
        allow_open: args.allow_open,
        weld: args.weld,
    };
    let input = Input::read(&args.part, args.coping.as_deref(), options)?;
    if !args.quiet {
        progress.aside(|| print_warnings(&input.warnings));
    }
    if args.verbose > 0 {
        progress.aside(|| describe(&input));
    }
    let settings = Settings {
        cell: args.cell,
        angle: args.angle,
        keep_fins: args.keep_fins,
    };
    let extraction = extract(&input.part, &settings, &progress)?;

    progress.stage("writing", 0);
    let report = report(&args, &input, &settings, &extraction);
    write(&args, &extraction.surface, &report)?;
    drop(progress);
    if !args.quiet {
        print_warnings(&extraction.warnings);
        for line in &extraction.summary {
            say(format_args!("{line}"));
        }
    }
    Ok(if extraction.cracks > 0 {
        ExitCode::from(1)
    } else {
        ExitCode::SUCCESS
    })
}

/// What was read, for `--verbose`.
fn describe(input: &Input) {
    say(format_args!(
        "{}: {} triangles, {} of them coping, diagonal {}",
        input.file.display(),
        input.part.triangle_count(),
        input.part.coping_count(),
        figure(input.part.bounds().diagonal())
    ));
    for rule in &input.rules {
        say(format_args!(
            "  {}: {} triangles, area {}",
            rule.name,
            rule.count,
            figure(rule.area)
        ));
    }
}

/// The extraction proper.
fn extract(
    _part: &Part,
    _settings: &Settings,
    _progress: &Progress,
) -> Result<Extraction, Failure> {
    Err(Failure::no_result(
        "extraction not linked",
        "this build reads and checks parts only",
    ))
}

/// Refuses outputs that could not be written, or that would overwrite an
/// input or each other, before any work is done.
fn check_names(args: &Args) -> Result<(), Failure> {
    let mut named: Vec<(PathBuf, &'static str)> = vec![(args.part.clone(), "part")];
    named.extend(args.coping.iter().map(|file| (file.clone(), "coping tags")));
    let mut outputs = Vec::new();
    for output in &args.output {
        for file in files_for(output).map_err(Failure::input)? {
            outputs.push((file, "output"));
        }
    }
    if let Some(json) = json_file(args) {
        outputs.push((json.to_owned(), "report"));
    }
    for (file, role) in outputs {
        check_target(&file).map_err(Failure::input)?;
        if let Some((_, first)) = named
            .iter()
            .find(|(other, _)| identity(other) == identity(&file))
        {
            return Err(Failure::input(WriteError::NamedTwice {
                file,
                first,
                second: role,
            }));
        }
        named.push((file, role));
    }
    Ok(())
}

/// The report's file, unless it goes to stdout.
fn json_file(args: &Args) -> Option<&Path> {
    args.json.as_deref().filter(|file| *file != Path::new("-"))
}

/// A name by which equal files are equal.
fn identity(file: &Path) -> PathBuf {
    if let Ok(whole) = file.canonicalize() {
        return whole;
    }
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), file.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => file.to_owned(),
    }
}

fn report(args: &Args, input: &Input, settings: &Settings, extraction: &Extraction) -> Value {
    let bounds = input.part.bounds();
    let warnings: Vec<&Warning> = input.warnings.iter().chain(&extraction.warnings).collect();
    json!({
        "schema": REPORT_SCHEMA,
        "tool": { "name": "midsurf", "version": env!("CARGO_PKG_VERSION") },
        "input": {
            "part": input.file,
            "sha256": input.sha256,
            "geometry": input.geometry,
            "coping": args.coping,
            "triangles": input.part.triangle_count(),
            "coping_triangles": input.part.coping_count(),
            "closed": input.part.is_closed(),
            "volume": input.part.volume(),
            "area": input.part.area(),
            "min": bounds.min,
            "max": bounds.max,
            "coping_rules": input.rules.len(),
        },
        "settings": settings,
        "result": extraction.facts,
        "cracks": extraction.cracks,
        "outputs": args.output,
        "warnings": warnings,
    })
}

/// Writes all files under passing names first, so that either all or none
/// appear as far as one process can see to it.
fn write(args: &Args, surface: &MidSurface, report: &Value) -> Result<(), Failure> {
    let options = SurfaceOptions {
        obj_lines: args.obj_lines,
    };
    let mut staged = Vec::new();
    for file in &args.output {
        staged.extend(stage_surface(surface, file, options).map_err(Failure::output)?);
    }
    if let Some(file) = json_file(args) {
        let write = |out: &mut dyn Write| writeln!(out, "{report:#}");
        staged.push(stage(file, write).map_err(Failure::output)?);
    }
    for file in staged {
        file.commit().map_err(Failure::output)?;
    }
    if args.json.is_some() && json_file(args).is_none() {
        writeln!(io::stdout().lock(), "{report:#}")?;
    }
    Ok(())
}
