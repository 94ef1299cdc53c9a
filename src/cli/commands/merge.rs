//! Shards: `midsurf extract --shard` makes one, `midsurf merge` joins all.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use midsurf::intake::{Input, check_size};
use midsurf::io::write::{SurfaceOptions, files_for, stage, stage_surface};
use midsurf::settings::progress::Stop;
use midsurf::settings::quote::{figure, shown_path};
use midsurf::shard::{MergeError, Shard, ShardFileError, ShardOf, merge, shard};
use serde_json::json;

use super::extract_args::Args as ExtractArgs;
use crate::cli::shared::console::say;
use crate::cli::shared::elements::ElementArgs;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::{RunArgs, check_suffix};

const EXAMPLES: &str = "\
Examples:
  midsurf extract part.stl --shard 1/2 -o a.shard
  midsurf extract part.stl --shard 2/2 -o b.shard
  midsurf merge a.shard b.shard -o mid.vtu

Each shard may be made on another machine. The result is the same, byte for
byte, as that of `midsurf extract` on the whole part.

Exit codes: 0 done, 1 done but the result has cracks, 2 wrong usage or bad input,
4 no usable result, 130 interrupted.";

/// Join the shards of an extraction.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// All shards, in any order
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Output file (.obj, .ply, .vtu, .stl); repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    elements: ElementArgs,
    /// Write seams and borders into OBJ files too, as lines
    #[arg(long)]
    obj_lines: bool,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let inputs: Vec<(&Path, &'static str)> =
        args.shards.iter().map(|f| (f.as_path(), "shard")).collect();
    let mut files = Vec::new();
    for output in &args.output {
        check_suffix(output, ".obj, .ply, .vtu, .stl")?;
        files.extend(files_for(output).map_err(Failure::input)?);
    }
    args.run.check_names(&inputs, files)?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let mut shards: Vec<Shard> = Vec::with_capacity(args.shards.len());
    for file in &args.shards {
        check_size(file)?;
        // A device may never end.
        if std::fs::metadata(file).is_ok_and(|meta| !meta.is_file()) {
            return Err(Failure::refused(file, &ShardFileError::NoShard));
        }
        let bytes = std::fs::read(file).map_err(ShardFileError::from);
        let shard = bytes.and_then(|bytes| Shard::read(&bytes));
        shards.push(shard.map_err(|error| Failure::refused(file, &error))?);
    }
    let which: Vec<ShardOf> = shards.iter().map(Shard::which).collect();
    let read = start.elapsed().as_secs_f64();
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let result = merge(shards, args.elements.settings(), &show, &Stop::default())
        .map_err(|error| refused(&args.shards, &which, error))?;
    if result.surface.triangles().is_empty() {
        return Err(Failure::no_result(
            "no mid-surface was found in any shard",
            "check the coping tags with `midsurf tags PART TAGS`, and take a smaller --cell",
        ));
    }
    progress.show("writing", 0, 0);
    let options = SurfaceOptions {
        obj_lines: args.obj_lines,
    };
    let mut staged = Vec::new();
    for file in &args.output {
        staged.extend(stage_surface(&result.surface, file, options).map_err(Failure::output)?);
    }
    let counts = *result.graph.counts();
    let cracks = result.graph.cracks().len();
    let report = Envelope {
        command: "merge",
        input: json!({ "shards": args.shards.iter().map(|f| named(f)).collect::<Vec<_>>() }),
        settings: json!({
            "cell_length": result.work.cell,
            "elements": args.elements.settings(),
            "obj_lines": args.obj_lines,
        }),
        seconds: json!({ "read": read, "total": start.elapsed().as_secs_f64() }),
        outputs: args.output.iter().map(PathBuf::as_path).collect(),
        warnings: Vec::new(),
    };
    let report = report.around(json!({
        "result": counts,
        "cracks": cracks,
        "closed_over": result.closed_over,
        "work": result.work.counts,
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        say(format_args!(
            "merged       {} shards, cell {}, {} active",
            which.len(),
            figure(result.work.cell),
            result.work.counts.cells
        ));
        say(format_args!(
            "mesh         {} vertices, {} triangles, {} sheets, {cracks} cracks",
            counts.vertices, counts.triangles, counts.sheets
        ));
    }
    Ok(ExitCode::from(u8::from(cracks > 0)))
}

/// The error at the file that it names, where it names one.
fn refused(files: &[PathBuf], which: &[ShardOf], error: MergeError) -> Failure {
    let at = match &error {
        MergeError::Doubled { which }
        | MergeError::OtherPart { which, .. }
        | MergeError::OtherSettings { which, .. }
        | MergeError::OtherVersion { which, .. } => Some(*which),
        _ => None,
    };
    let file = at.and_then(|at| which.iter().rposition(|&w| w == at));
    match file {
        Some(n) => Failure::refused(&files[n], &error),
        None => Failure::input(error),
    }
}

/// `midsurf extract --shard`: computes one shard and writes it.
pub(crate) fn run_shard(args: &ExtractArgs, which: ShardOf) -> Result<ExitCode, Failure> {
    let [file] = &args.output[..] else {
        return Err(Failure::usage(
            "--shard makes one file",
            "name it with one -o FILE.shard",
        ));
    };
    check_suffix(file, ".shard")?;
    if args.list || args.elements.element_size.is_some() {
        return Err(Failure::usage(
            "--list and --element-size want the whole mid-surface",
            "give them to `midsurf merge`, or look at what it writes",
        ));
    }
    let mut inputs = vec![(args.part.as_path(), "part")];
    inputs.extend(args.coping.file().map(|file| (file, "coping tags")));
    args.run.check_names(&inputs, vec![file.clone()])?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let reading = args.reading.with(Some(&args.select));
    let input = Input::read(&args.part, &args.coping, &reading, args.allow_open)?;
    let read = start.elapsed().as_secs_f64();
    if !args.run.quiet {
        progress.aside(|| print_warnings(&input.warnings));
    }
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let made = shard(
        &input.part,
        &args.settings(),
        which,
        &show,
        &Stop::default(),
    )
    .map_err(|error| Failure::refused(&args.part, &error))?;
    progress.show("writing", 0, 0);
    let staged = stage(file, |out: &mut dyn Write| made.write(out)).map_err(Failure::output)?;
    let report = Envelope {
        command: "extract",
        input: json!({ "part": named(&input.file), "sha256": input.sha256 }),
        settings: json!({
            "shard": which.to_string(),
            "cell": args.cell,
            "angle": args.angle,
            "keep_fins": args.keep_fins,
        }),
        seconds: json!({ "read": read, "total": start.elapsed().as_secs_f64() }),
        outputs: vec![file.as_path()],
        warnings: input.warnings.iter().collect(),
    };
    let report = report.around(json!({ "work": made.counts() }));
    args.run.finish(vec![staged], &report)?;
    drop(progress);
    if !args.run.quiet {
        say(format_args!(
            "shard        {which} of {}, {} active cells",
            shown_path(&input.file),
            made.counts().cells
        ));
    }
    Ok(ExitCode::SUCCESS)
}
