//! `midsurf extract`: part and tags in, mid-surface and report out.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use midsurf::extract::{DEFAULT_ANGLE, Extraction, Settings, extract};
use midsurf::io::write::{ShellFormat, Staged, SurfaceOptions, files_for, stage, stage_surface};
use midsurf::mesh::PartOptions;
use midsurf::settings::cell::CellSize;
use midsurf::shell::Faces;
use midsurf::surface::listing::listing;

use super::extract_report::{Report, Seconds};
use crate::cli::shared::console::say;
use crate::cli::shared::coping::CopingSource;
use crate::cli::shared::elements::ElementArgs;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::{Input, print_warnings};
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::numbers::{angle, figure, positive};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::shell::ShellArgs;
use midsurf::io::quote::{shown, shown_path};

const EXAMPLES: &str = "\
Examples:
  midsurf extract bracket.obj --coping bracket.coping.txt -o mid.obj
  midsurf extract part.stl --coping part.toml --cell 0.5t -o mid.vtu -o mid.ply
  midsurf extract part.obj --coping part.coping.txt --cell 1.0 -o mid.obj --json report.json
  midsurf extract part.obj --coping part.coping.txt -o part.inp --template cantilever

The suffix of -o tells the format: .obj (one group a sheet, with NAME.thickness.csv
beside it), .ply and .vtu (with thickness), .stl, .html (a page to look at part and
mid-surface in any browser, in one file); .inp (CalculiX, Abaqus), .bdf (Nastran),
.msh (Gmsh) and .glb: shell models, with sets for sheets, seams, borders and coping
faces. Without -o only the summary is printed.

A sheet ends where the angle between its two footpoints falls below --angle: a
web a quarter as thick as the wall that it stands on still has 28 degrees there.
Fins into sharp outer corners are dropped at any angle, unless --keep-fins.

Features smaller than two cells (a vent, a small hole) may be closed over; the
report says which. A cell so small that the lattice would need more than
--memory-limit is refused, with the smallest cell that fits.

An open part is refused;
--allow-open goes on all the same, but inside and outside are then guesses near
the gaps, and sheets may be missing or cut short there.

Exit codes: 0 done, 1 done but the result has cracks, 2 wrong usage or bad input,
4 no usable result, 130 interrupted.";

/// Extract the mid-surface of a part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part: a closed triangle or polygon mesh (.obj, .stl, .ply, .off, .3mf, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    pub(crate) part: PathBuf,
    /// Coping tags: a file (text, or TOML if the name ends in .toml), `auto` to
    /// find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    pub(crate) coping: CopingSource,
    /// Cell size: a length, `0.5t` (wall thicknesses), `1%` (of the diagonal), or auto
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    pub(crate) cell: CellSize,
    /// Smallest object angle of a sheet in degrees, between 0 and 180
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = DEFAULT_ANGLE,
        value_parser = angle,
        allow_negative_numbers = true
    )]
    pub(crate) angle: f64,
    /// Output file; repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Print all sheets, seams, borders and junctions to stdout, sorted by place
    #[arg(long)]
    list: bool,
    /// Keep the fins that run into convex edges of one wall
    #[arg(long)]
    pub(crate) keep_fins: bool,
    /// Go on when the part has gaps
    #[arg(long)]
    pub(crate) allow_open: bool,
    /// Merge vertices of the part within this distance
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) weld: Option<f64>,
    #[command(flatten)]
    pub(crate) elements: ElementArgs,
    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
    /// Write seams and borders into OBJ files too, as lines
    #[arg(long)]
    pub(crate) obj_lines: bool,
    #[command(flatten)]
    shell: ShellArgs,
    #[command(flatten)]
    run: RunArgs,
    /// Print more; twice for all
    #[arg(short, long, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    verbose: u8,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    check_names(&args)?;
    if args.list && args.run.reports_to_stdout() {
        return Err(Failure::usage(
            "--list and `--json -` both want standard output",
            "give the report a file: --json FILE",
        ));
    }
    let start = Instant::now();
    let progress = args.run.start();
    let options = PartOptions {
        allow_open: args.allow_open,
        weld: args.weld,
    };
    let input = Input::read(&args.part, &args.coping, options)?;
    let read = start.elapsed().as_secs_f64();
    if !args.run.quiet {
        progress.aside(|| print_warnings(&input.warnings));
    }
    if args.verbose > 0 {
        progress.aside(|| describe(&input));
    }
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let result = extract(&input.part, &args.settings(), &show)
        .map_err(|error| Failure::refused(&args.part, &error))?;
    if result.surface.triangles().is_empty() {
        return Err(Failure::no_result(
            format!("{}: no mid-surface was found", shown_path(&args.part)),
            "check the coping tags with `midsurf tags PART TAGS`, and take a smaller --cell",
        ));
    }

    progress.show("writing", 0, 0);
    let mut staged = stage_outputs(&args, &input, &result)?;
    let faces = Faces {
        quads: result.quads.clone(),
        middles: result.middles.iter().copied().collect(),
    };
    let (models, model) = args
        .shell
        .stage(&input, &result.surface, &faces, &args.output)?;
    staged.extend(models);
    let seconds = Seconds {
        read,
        write: start.elapsed().as_secs_f64() - read - Seconds::of_work(&result.work),
        total: start.elapsed().as_secs_f64(),
    };
    let report = Report::new(&input, &result, seconds);
    let mut report_json = report.json(&args, &input, &result);
    if let Some(model) = model {
        report_json["shell"] = model;
    }
    args.run.finish(staged, &report_json)?;
    drop(progress);
    if args.list {
        let mut out = io::stdout().lock();
        out.write_all(listing(&result.surface, &result.graph).as_bytes())?;
        out.flush()?;
    }
    if !args.run.quiet {
        print_warnings(&report.warnings);
        for line in report.summary(&result, args.verbose) {
            say(format_args!("{line}"));
        }
    }
    Ok(if result.graph.cracks().is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

impl Args {
    fn settings(&self) -> Settings {
        Settings {
            cell: self.cell,
            min_angle: self.angle,
            keep_fins: self.keep_fins,
            memory_limit: self.memory.allowed(),
            elements: self.elements.settings(),
        }
    }
}

/// What was read, for `--verbose`.
fn describe(input: &Input) {
    say(format_args!(
        "{}: {} triangles, {} of them coping, diagonal {}",
        shown_path(&input.file),
        input.part.triangle_count(),
        input.part.coping_count(),
        figure(input.part.bounds().diagonal())
    ));
    for rule in &input.rules {
        say(format_args!(
            "  {}: {} triangles, area {}",
            shown(&rule.name),
            rule.count,
            figure(rule.area)
        ));
    }
}

/// Refuses file names that could not be written or are named twice.
fn check_names(args: &Args) -> Result<(), Failure> {
    let mut inputs = vec![(args.part.as_path(), "part")];
    inputs.extend(args.coping.file().map(|file| (file, "coping tags")));
    let mut files = Vec::new();
    for output in &args.output {
        if is_page(output) {
            files.push(output.clone());
        } else {
            files.extend(files_for(output).map_err(Failure::input)?);
        }
    }
    args.run.check_names(&inputs, files)
}

/// Whether an output is a page for the browser.
fn is_page(file: &Path) -> bool {
    let suffix = file.extension();
    cfg!(feature = "view") && suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("html"))
}

/// Writes the surface under passing names.
fn stage_outputs(args: &Args, input: &Input, result: &Extraction) -> Result<Vec<Staged>, Failure> {
    let options = SurfaceOptions {
        obj_lines: args.obj_lines,
    };
    let mut staged = Vec::new();
    for file in &args.output {
        if is_page(file) {
            let write = |out: &mut dyn Write| write_page(input, result, out);
            staged.push(stage(file, write).map_err(Failure::output)?);
        } else if ShellFormat::of(file).is_none() {
            staged.extend(stage_surface(&result.surface, file, options).map_err(Failure::output)?);
        }
    }
    Ok(staged)
}

#[cfg(feature = "view")]
fn write_page(input: &Input, result: &Extraction, out: &mut dyn Write) -> io::Result<()> {
    let title = input.file.file_name().unwrap_or(input.file.as_os_str());
    midsurf::view::write_page(&title.to_string_lossy(), &input.part, result, out)
}

#[cfg(not(feature = "view"))]
fn write_page(_: &Input, _: &Extraction, _: &mut dyn Write) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
