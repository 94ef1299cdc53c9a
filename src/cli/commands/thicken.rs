//! `midsurf thicken`: a solid on one side of a surface.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::ValueEnum;
use midsurf::intake::load;
use midsurf::mesh::{TriMesh, simplify_beside};
use midsurf::settings::cell::{CellSize, Scale};
use midsurf::settings::quote::figure;
use midsurf::thicken::{Settings, Side, ThickenError, Thickened, thicken};
use serde_json::{Value, json};

use super::rethicken;
use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::solid::{SimplifyArgs, SolidArgs};

const EXAMPLES: &str = "\
Examples:
  midsurf thicken patch.obj --thickness 2.5 --side inner -o solid.stl
  midsurf thicken patch.ply --thickness 2 --side outer --cell 0.25 -o solid.obj
  midsurf thicken patch.ply --side both -o solid.stl

The solid has one thickness all over and ends flat at the surface's boundary.
The surface itself is part of the result, triangle for triangle. A closed
surface gives a shell.

With --side both half of the thickness lies on either side, so the surface is
inside; folds come out round. Without --thickness that of every vertex is taken
then: the property `thickness` or `radius` of a .ply, or NAME.thickness.csv
beside an .obj.

An .stl holds single precision; .obj and .ply keep the surface's numbers as
they are.

Exit codes: 0 done, 1 done but the result is not sound (said on stderr),
2 wrong usage or bad input, 4 the cell is too large for the surface's boundary.";

/// Thicken a surface into a solid on one side of it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The surface: an open or closed triangle or polygon mesh (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    pub(super) patch: PathBuf,
    /// Thickness of the solid
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    pub(super) thickness: Option<f64>,
    /// Side of the surface on which the solid lies
    #[arg(long, value_name = "SIDE", value_enum, default_value = "inner")]
    pub(super) side: SideArg,
    /// Cell size: a length, `1%` (of the surface's diagonal), or auto (a quarter of the thickness)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    pub(super) cell: CellSize,
    /// Split chords that stray farther than this from the solid [default: 0.2% of the thickness]
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
    /// Close holes of the surface whose edge is no longer than this
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    pub(super) fill: Option<f64>,
    #[command(flatten)]
    pub(super) fewer: SimplifyArgs,
    #[command(flatten)]
    pub(super) solid: SolidArgs,
    #[command(flatten)]
    pub(super) memory: MemoryArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// `--side`.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum SideArg {
    /// Against the normals
    Inner,
    /// Along the normals
    Outer,
    /// Half of the thickness on either side
    Both,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.side {
        SideArg::Inner => one_sided("thicken", &args, Side::Inner),
        SideArg::Outer => one_sided("thicken", &args, Side::Outer),
        SideArg::Both => rethicken::run_as("thicken", args.two_sided()?),
    }
}

/// The solid on one side, as the work of a command.
pub(super) fn one_sided(command: &str, args: &Args, side: Side) -> Result<ExitCode, Failure> {
    let inputs = [(args.patch.as_path(), "surface")];
    args.solid.check_names(&inputs, &args.run)?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let (loaded, mut warnings) = load(&args.patch)?;
    let read_seconds = start.elapsed().as_secs_f64();

    let settings = args.settings(&loaded.mesh, side)?;
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let mut result = thicken(&loaded.mesh, &settings, &show).map_err(|error| match error {
        ThickenError::Unresolved { .. } => Failure::fruitless(&args.patch, &error),
        _ => Failure::refused(&args.patch, &error),
    })?;
    warnings.extend(result.warnings(&loaded.mesh, &settings));
    // A solid that is not sound stays as it is: what it lacks is lacking there.
    let fewer = args.fewer.within(settings.tolerance);
    let simplified = fewer.filter(|_| result.is_sound()).map(|how| {
        progress.show("simplify", 0, 0);
        let fewer = simplify_beside(&result.mesh, result.patch_triangles, &how);
        result.mesh = fewer.mesh;
        fewer.tolerance
    });

    progress.show("writing", 0, 0);
    let begin = Instant::now();
    let staged = args.solid.stage(&result.mesh, None)?;
    let seconds = json!({
        "read": read_seconds,
        "field": result.field_seconds,
        "band": result.work.band_seconds,
        "contour": result.work.contour_seconds,
        "join": result.join_seconds,
        "sharpen": result.sharpen_seconds,
        "write": begin.elapsed().as_secs_f64(),
        "total": start.elapsed().as_secs_f64(),
    });
    let report = Envelope {
        command,
        input: json!({
            "patch": named(&args.patch),
            "sha256": loaded.sha256,
            "triangles": loaded.mesh.triangles.len(),
            "area": loaded.mesh.area(),
            "boundaries": result.boundaries,
            "repairs": result.repairs,
        }),
        settings: args.settings_json(&settings),
        seconds: json!(seconds),
        outputs: args.solid.outputs(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "result": {
            "vertices": result.mesh.positions.len(),
            "triangles": result.mesh.triangles.len(),
            "patch_triangles": result.patch_triangles,
            "volume": result.mesh.volume(),
            "area": result.mesh.area(),
            "way": result.way,
            "shell_deviation": result.deviation,
            "missing": result.missing,
            "self_intersections": result.self_intersections,
            "bad_edges": result.bad_edges,
            "cell": result.cell,
            "attempts": result.attempts,
            "sharpened": result.sharpened,
            "simplified_within": simplified,
        },
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(&result, settings.thickness);
    }
    if args.run.verbose > 0 {
        details(&result);
    }
    Ok(if result.is_sound() && result.missing.is_none() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

impl Args {
    /// The solid on both sides, by balls around the surface.
    fn two_sided(self) -> Result<rethicken::Args, Failure> {
        if self.fill.is_some() {
            return Err(Failure::usage(
                "--fill closes holes before a surface is thickened on one side",
                "leave --fill away, or take --side inner or outer",
            ));
        }
        let thickness = self.thickness.map(checked).transpose()?;
        Ok(self.balls(thickness, false))
    }

    /// All that is within a distance of the surface.
    pub(super) fn around(self, distance: f64) -> rethicken::Args {
        self.balls(Some(2.0 * distance), true)
    }

    fn balls(self, thickness: Option<f64>, round_borders: bool) -> rethicken::Args {
        rethicken::Args {
            surface: self.patch,
            thickness: thickness.map(rethicken::Thickness::Length),
            group: Vec::new(),
            round_borders,
            cell: self.cell,
            tolerance: self.tolerance,
            fewer: self.fewer,
            solid: self.solid,
            memory: self.memory,
            run: self.run,
        }
    }

    fn settings(&self, surface: &TriMesh, side: Side) -> Result<Settings, Failure> {
        let Some(thickness) = self.thickness else {
            return Err(Failure::usage(
                "--side inner and outer take one thickness all over",
                "give --thickness a length; --side both takes that of every vertex from the file",
            ));
        };
        let mut settings = Settings::new(thickness, side).fitted(surface);
        let scale = Scale {
            auto: Some(settings.cell),
            thickness: Some(thickness),
            diagonal: surface.bounds().diagonal(),
        };
        settings.cell = self.cell.resolve(&scale).map_err(Failure::input)?;
        if let Some(tolerance) = self.tolerance {
            settings.tolerance = tolerance;
        }
        settings.holes = self.fill.unwrap_or_default();
        settings.memory_limit = self.memory.allowed();
        settings.precision = self.solid.precision();
        Ok(settings)
    }

    fn settings_json(&self, settings: &Settings) -> Value {
        json!({
            "thickness": settings.thickness,
            "side": settings.side,
            "cell": self.cell,
            "cell_length": settings.cell,
            "tolerance": settings.tolerance,
            "fill": self.fill,
            "simplify": self.fewer.wanted(),
            "wanted_triangles": self.fewer.triangles,
            "precision": settings.precision,
            "memory_limit": self.memory.memory_limit,
        })
    }
}

/// Refuses what is no thickness.
fn checked(thickness: f64) -> Result<f64, Failure> {
    let error = ThickenError::BadThickness(thickness);
    if thickness > 0.0 && thickness.is_finite() {
        Ok(thickness)
    } else {
        Err(Failure::usage(
            error.to_string(),
            "give --thickness a positive length",
        ))
    }
}

fn summary(result: &Thickened, thickness: f64) {
    say(format_args!(
        "{} vertices, {} triangles ({} of the surface), volume {}, area {}",
        result.mesh.positions.len(),
        result.mesh.triangles.len(),
        result.patch_triangles,
        figure(result.mesh.volume()),
        figure(result.mesh.area())
    ));
    // Both ways: from the solid to the true shell, and from the true shell and
    // cross-section to the solid.
    let max = result.deviation.max.max(result.missing.max);
    let mean = result.deviation.mean.max(result.missing.mean);
    say(format_args!(
        "off the true solid by {} at most, {} in the mean (of the thickness: {} and {})",
        figure(max),
        figure(mean),
        figure(max / thickness),
        figure(mean / thickness),
    ));
}

/// What each stage took, for `--verbose`.
fn details(result: &Thickened) {
    let f = &result.work.filters;
    say(format_args!(
        "nodes: {} in the grid, {} distances, {} within reach",
        f.nodes, f.distances, f.valid
    ));
    let [cells, faces, edges] = result.work.vertices;
    say(format_args!(
        "vertices of the whole contour: {cells} in cells, {faces} on faces, {edges} on edges"
    ));
    say(format_args!(
        "boundaries: {}; ways tried to lay grid and cut: {}; vertices moved to sharp edges: {}",
        result.boundaries, result.attempts, result.sharpened
    ));
    say(format_args!(
        "seconds: field {:.3}, band {:.3}, contour {:.3}, cut and join {:.3}, sharp edges {:.3}",
        result.field_seconds,
        result.work.band_seconds,
        result.work.contour_seconds,
        result.join_seconds,
        result.sharpen_seconds
    ));
}
