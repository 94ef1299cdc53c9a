//! `midsurf rethicken`: a mid-surface with its thickness back to a solid.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;
use std::time::Instant;

use midsurf::intake::balls::{doubts, thickness_by_group};
use midsurf::intake::{load, read_warning};
use midsurf::io::write::thickness_file;
use midsurf::io::{RadiusSource, read_surface};
use midsurf::mesh::simplify;
use midsurf::rethicken::{BallSurface, RethickenError, Settings, rethicken};
use midsurf::settings::cell::{CellSize, Scale};
use midsurf::settings::quote::shown_path;
use midsurf::settings::warning::Warning;
use serde_json::json;

use super::closed_part::work_json;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::groups::{Group, pairs};
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::numbers::positive;
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::solid::{SimplifyArgs, SolidArgs, summary};

const EXAMPLES: &str = "\
Examples:
  midsurf rethicken mid.ply -o solid.stl
  midsurf rethicken mid.obj --cell 0.2t -o solid.obj --json report.json
  midsurf rethicken shell.obj --thickness 2 --group ribs=3 -o solid.stl

The solid is the union of balls around all points of the mid-surface, their
radius linear over each triangle. It comes from the property `radius` of a .ply
or from NAME.thickness.csv beside an .obj; with a thickness alone, half of that
is taken, which is a little small near seams.

With --thickness LENGTH any shell mesh becomes a solid, non-manifold or not,
half of the thickness to either side; --group gives facets of a group, object or
material another one. Free edges end flat then.

At coping borders the solid ends flat, square to the mid-surface; at fading
borders it ends round. Only a .ply tells them apart: of other files all free
borders end flat, unless --round-borders is given.

Where the solid has features that cells of the given length miss, smaller ones
are tried.

Exit codes: 0 done, 1 some of the solid is missing, 2 wrong usage or bad input, 4 the solid is thinner than a cell.";

/// Thicken a mid-surface by its own thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The mid-surface, non-manifold or not: .ply, or .obj with its table of thickness; with --thickness LENGTH any mesh
    pub(super) surface: PathBuf,
    /// One thickness for all, or a table of thickness or radius (CSV), instead of that in or beside the file
    #[arg(long, value_name = "LENGTH|FILE")]
    pub(super) thickness: Option<Thickness>,
    /// Another thickness for a group, object or material of the file; repeat for several
    #[arg(long, value_name = "NAME=LENGTH", requires = "thickness")]
    pub(super) group: Vec<Group>,
    /// End round at all free borders
    #[arg(long)]
    pub(super) round_borders: bool,
    /// Cell size: a length, `0.2t` (of the median thickness), `1%` (of the diagonal), or auto (a quarter of the least thickness)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    pub(super) cell: CellSize,
    /// Split chords that stray farther than this from the solid [default: 0.1% of the median thickness]
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
    #[command(flatten)]
    pub(super) fewer: SimplifyArgs,
    #[command(flatten)]
    pub(super) solid: SolidArgs,
    #[command(flatten)]
    pub(super) memory: MemoryArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// `--thickness`.
#[derive(Clone)]
pub(super) enum Thickness {
    Length(f64),
    Table(PathBuf),
}

impl FromStr for Thickness {
    type Err = String;

    fn from_str(text: &str) -> Result<Thickness, String> {
        match text.parse::<f64>() {
            Ok(_) => positive(text).map(Thickness::Length),
            Err(_) => Ok(Thickness::Table(text.into())),
        }
    }
}

/// What is thickened, and what is known of its file.
struct Source {
    surface: BallSurface,
    sha256: String,
    vertices: usize,
    triangles: usize,
    radius_from: Option<PathBuf>,
    radius_given: bool,
    warnings: Vec<Warning>,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    run_as("rethicken", args)
}

/// The work of this command under the name of another that means the same
/// solid.
pub(super) fn run_as(command: &str, args: Args) -> Result<ExitCode, Failure> {
    let mut inputs = vec![(args.surface.as_path(), "mid-surface")];
    let beside = thickness_file(&args.surface);
    match &args.thickness {
        Some(Thickness::Table(file)) => inputs.push((file, "thickness")),
        None if beside.is_file() => inputs.push((&beside, "thickness")),
        _ => {}
    }
    args.solid.check_names(&inputs, &args.run)?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let source = args.source()?;
    let surface = &source.surface;
    let read_seconds = start.elapsed().as_secs_f64();
    let settings = args.settings(surface)?;
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let mut result =
        rethicken(surface, &settings, &show).map_err(|error| failure(&error, &args.surface))?;
    let simplified = args.fewer.within(settings.tolerance).map(|how| {
        progress.show("simplify", 0, 0);
        let fewer = simplify(&result.mesh, &how);
        result.mesh = fewer.mesh;
        fewer.tolerance
    });
    let found = result.warnings.iter().map(|found| {
        let found = found.explained();
        args.warning(found.code, &found.message)
    });
    let warnings: Vec<Warning> = source.warnings.iter().cloned().chain(found).collect();

    progress.show("writing", 0, 0);
    let begin = Instant::now();
    let mesh = &result.mesh;
    let staged = args.solid.stage(mesh, None)?;
    let report = Envelope {
        command,
        input: json!({
            "surface": named(&args.surface),
            "sha256": source.sha256,
            "vertices": source.vertices,
            "triangles": source.triangles,
            "area": surface.area(),
            "flat_border_edges": surface.flat_edges(),
            "median_thickness": surface.median_thickness(),
            "least_thickness": surface.least_thickness(),
            "radius_from": source.radius_from.as_deref().map(named),
            "radius_given": source.radius_given,
        }),
        settings: json!({
            "cell": args.cell,
            "cell_length": settings.cell,
            "tolerance": settings.tolerance,
            "precision": settings.precision,
            "round_borders": args.round_borders,
            "thickness": args.length(),
            "groups": args.group.iter().map(|g| json!([g.name, g.thickness])).collect::<Vec<_>>(),
            "simplify": args.fewer.wanted(),
            "wanted_triangles": args.fewer.triangles,
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
            "cell": result.cell,
            "missing": result.missing,
            "simplified_within": simplified,
        },
        "work": work_json(&result.work),
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(mesh);
    }
    Ok(if result.missing.is_none() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

impl Args {
    fn length(&self) -> Option<f64> {
        match self.thickness {
            Some(Thickness::Length(length)) => Some(length),
            _ => None,
        }
    }

    fn warning(&self, code: &'static str, message: &str) -> Warning {
        Warning::new(code, format!("{}: {message}", shown_path(&self.surface)))
    }

    fn source(&self) -> Result<Source, Failure> {
        let mut source = match &self.thickness {
            Some(Thickness::Length(length)) => self.shell(*length)?,
            Some(Thickness::Table(table)) => self.mid_surface(Some(table))?,
            None => self.mid_surface(None)?,
        };
        if self.round_borders {
            source.surface = source.surface.rounded();
        }
        Ok(source)
    }

    /// Any mesh with a thickness by group.
    fn shell(&self, length: f64) -> Result<Source, Failure> {
        let (loaded, warnings) = load(&self.surface)?;
        let thickness = thickness_by_group(&loaded, length, &pairs(&self.group))
            .map_err(|error| Failure::refused(&self.surface, &error))?;
        let surface = BallSurface::of_shell(&loaded.mesh, &thickness)
            .map_err(|error| failure(&error, &self.surface))?;
        Ok(Source {
            surface,
            vertices: loaded.mesh.positions.len(),
            triangles: loaded.mesh.triangles.len(),
            sha256: loaded.sha256,
            radius_from: None,
            radius_given: false,
            warnings,
        })
    }

    /// A mid-surface with its own thickness.
    fn mid_surface(&self, table: Option<&Path>) -> Result<Source, Failure> {
        if !self.group.is_empty() {
            return Err(Failure::usage(
                "--group goes with one thickness for all others",
                "give --thickness a length",
            ));
        }
        let loaded = read_surface(&self.surface, table).map_err(Failure::input)?;
        let surface = BallSurface::of(&loaded.surface)
            .map_err(|error| failure(&error, loaded.radius.file()))?;
        let mut warnings: Vec<Warning> = (loaded.warnings.iter())
            .map(|w| read_warning(&self.surface, w))
            .collect();
        warnings.extend(doubts(&self.surface, &loaded, &surface, self.round_borders));
        Ok(Source {
            surface,
            vertices: loaded.vertices,
            triangles: loaded.triangles,
            sha256: loaded.sha256,
            radius_from: Some(loaded.radius.file().to_owned()),
            radius_given: matches!(loaded.radius, RadiusSource::Radius(_)),
            warnings,
        })
    }

    fn settings(&self, surface: &BallSurface) -> Result<Settings, Failure> {
        let mut settings = Settings::new(surface);
        let scale = Scale {
            auto: Some(settings.cell),
            thickness: Some(surface.median_thickness()),
            diagonal: surface.diagonal(),
        };
        settings.cell = self.cell.resolve(&scale).map_err(Failure::input)?;
        settings.tolerance = self.tolerance.unwrap_or(settings.tolerance);
        settings.memory_limit = self.memory.allowed();
        settings.precision = self.solid.precision();
        Ok(settings)
    }
}

/// A mid-surface that gives no solid.
pub(crate) fn failure(error: &RethickenError, file: &Path) -> Failure {
    match error {
        RethickenError::Empty(_) => Failure::fruitless(file, error),
        _ => Failure::refused(file, error),
    }
}
