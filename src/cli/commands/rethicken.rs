//! `midsurf rethicken`: a mid-surface with its thickness back to a solid.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use midsurf::io::write::thickness_file;
use midsurf::io::{LoadedSurface, RadiusSource, read_surface};
use midsurf::rethicken::{BallSurface, RethickenError, RethickenWarning, Settings, rethicken};
use midsurf::settings::cell::{CellSize, Scale};
use serde_json::json;

use super::closed_part::work_json;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::{Warning, print_warnings, read_warning};
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::solid::{SolidArgs, summary};
use midsurf::io::quote::shown_path;

const EXAMPLES: &str = "\
Examples:
  midsurf rethicken mid.ply -o solid.stl
  midsurf rethicken mid.obj --cell 0.2t -o solid.obj --json report.json

The solid is the union of balls around all points of the mid-surface, their
radius linear over each triangle. It comes from the property `radius` of a .ply
or from NAME.thickness.csv beside an .obj; with a thickness alone, half of that
is taken, which is a little small near seams.

At coping borders the solid ends flat, square to the mid-surface; at fading
borders it ends round. Only a .ply tells them apart: of other files all free
borders end flat, unless --round-borders is given.

Exit codes: 0 done, 2 wrong usage or bad input, 4 the solid is thinner than a cell.";

/// Thicken a mid-surface by its own thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The mid-surface, non-manifold or not: .ply, or .obj with its table of thickness
    surface: PathBuf,
    /// Table of thickness or radius instead of that in or beside the file (CSV)
    #[arg(long, value_name = "FILE")]
    thickness: Option<PathBuf>,
    /// End round at all free borders
    #[arg(long)]
    round_borders: bool,
    /// Cell size: a length, `0.2t` (of the median thickness), `1%` (of the diagonal), or auto (a quarter of the least thickness)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    cell: CellSize,
    /// Split chords that stray farther than this from the solid [default: 0.1% of the median thickness]
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    solid: SolidArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let mut inputs = vec![(args.surface.as_path(), "mid-surface")];
    inputs.extend(
        args.thickness
            .iter()
            .map(|file| (file.as_path(), "thickness")),
    );
    let beside = thickness_file(&args.surface);
    if args.thickness.is_none() && beside.is_file() {
        inputs.push((&beside, "thickness"));
    }
    args.solid.check_names(&inputs, &args.run)?;
    let start = Instant::now();
    let progress = args.run.start();
    let loaded = read_surface(&args.surface, args.thickness.as_deref()).map_err(Failure::input)?;
    let mut surface =
        BallSurface::of(&loaded.surface).map_err(|error| failure(&error, loaded.radius.file()))?;
    if args.round_borders {
        surface = surface.rounded();
    }
    let read_seconds = start.elapsed().as_secs_f64();
    let settings = args.settings(&surface)?;
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let result =
        rethicken(&surface, &settings, &show).map_err(|error| failure(&error, &args.surface))?;
    let warnings = warnings(&args, &loaded, &surface, &result.warnings);

    progress.show("writing", 0, 0);
    let begin = Instant::now();
    let mesh = &result.mesh;
    let staged = args.solid.stage(mesh, None)?;
    let report = Envelope {
        command: "rethicken",
        input: json!({
            "surface": named(&args.surface),
            "sha256": loaded.sha256,
            "vertices": loaded.vertices,
            "triangles": loaded.triangles,
            "area": surface.area(),
            "flat_border_edges": surface.flat_edges(),
            "median_thickness": surface.median_thickness(),
            "least_thickness": surface.least_thickness(),
            "radius_from": named(loaded.radius.file()),
            "radius_given": matches!(loaded.radius, RadiusSource::Radius(_)),
        }),
        settings: json!({
            "cell": args.cell,
            "cell_length": settings.cell,
            "tolerance": settings.tolerance,
            "precision": settings.precision,
            "round_borders": args.round_borders,
            "memory_limit": args.memory.memory_limit,
        }),
        seconds: json!({
            "read": read_seconds,
            "solid": result.solid_seconds,
            "band": result.work.band_seconds,
            "contour": result.work.contour_seconds,
            "write": begin.elapsed().as_secs_f64(),
            "total": start.elapsed().as_secs_f64(),
        }),
        outputs: args.solid.outputs(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "result": {
            "vertices": mesh.positions.len(),
            "triangles": mesh.triangles.len(),
            "volume": mesh.volume(),
            "area": mesh.area(),
        },
        "work": work_json(&result.work),
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(mesh);
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn settings(&self, surface: &BallSurface) -> Result<Settings, Failure> {
        let mut settings = Settings::new(surface);
        let scale = Scale {
            auto: Some(settings.cell),
            thickness: Some(surface.median_thickness()),
            diagonal: surface.diagonal(),
        };
        settings.cell = self.cell.resolve(&scale).map_err(Failure::input)?;
        settings.tolerance = self.tolerance.unwrap_or(settings.tolerance);
        settings.memory_limit = self.memory.memory_limit.0;
        settings.precision = self.solid.precision();
        Ok(settings)
    }
}

fn warnings(
    args: &Args,
    loaded: &LoadedSurface,
    surface: &BallSurface,
    found: &[RethickenWarning],
) -> Vec<Warning> {
    let warning = |code, message: &str| Warning {
        code,
        message: format!("{}: {message}", shown_path(&args.surface)),
    };
    let mut warnings: Vec<Warning> = (loaded.warnings.iter())
        .map(|w| read_warning(&args.surface, w))
        .collect();
    if matches!(loaded.radius, RadiusSource::HalfThickness(_)) {
        let message = "no radius is given, half the thickness is taken: a little small near seams";
        warnings.push(warning("half_thickness", message));
    }
    if !loaded.kinds && !args.round_borders && surface.flat_edges() > 0 {
        let message = "the file does not tell coping from fading borders: all end flat";
        warnings.push(warning("unknown_borders", message));
    }
    for &found in found {
        let (code, message) = explain(found);
        warnings.push(warning(code, message));
    }
    warnings
}

/// Code and meaning of a warning.
pub(crate) fn explain(warning: RethickenWarning) -> (&'static str, &'static str) {
    match warning {
        RethickenWarning::CoarseCell => (
            "coarse_cell",
            "the cell is larger than half the least thickness: thin places may be missed",
        ),
    }
}

/// A mid-surface that gives no solid.
pub(crate) fn failure(error: &RethickenError, file: &Path) -> Failure {
    match error {
        RethickenError::Empty(_) => Failure::fruitless(file, error),
        _ => Failure::refused(file, error),
    }
}
