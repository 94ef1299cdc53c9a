//! `midsurf extract`: part and tags in, mid-surface and report out.

use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use midsurf::extract::{Extraction, extract};
use midsurf::intake::Input;
use midsurf::io::write::{ShellFormat, Staged, SurfaceOptions, files_for, stage, stage_surface};
use midsurf::settings::quote::{figure, shown, shown_path};
use midsurf::shell::Faces;
use midsurf::surface::listing::listing;

pub(crate) use super::extract_args::Args;
use super::extract_report::{Report, Seconds};
use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    if let Some(which) = args.shard {
        return super::merge::run_shard(&args, which);
    }
    check_names(&args)?;
    if args.list && args.run.reports_to_stdout() {
        return Err(Failure::usage(
            "--list and `--json -` both want standard output",
            "give the report a file: --json FILE",
        ));
    }
    let start = Instant::now();
    let progress = args.run.start()?;
    let reading = args.reading.with(Some(&args.select));
    let input = Input::read(&args.part, &args.coping, &reading, args.allow_open)?;
    let read = start.elapsed().as_secs_f64();
    if !args.run.quiet {
        progress.aside(|| print_warnings(&input.warnings));
    }
    if args.run.verbose > 0 {
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
        .stage(Some(&input), &result.surface, &faces, &args.output)?;
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
        for line in report.summary(&result, args.run.verbose) {
            say(format_args!("{line}"));
        }
    }
    Ok(if result.graph.cracks().is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
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
