//! `midsurf roundtrip`: part to mid-surface to solid, and how close it comes.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use midsurf::extract::{self, DEFAULT_ANGLE};
use midsurf::intake::{CopingSource, Input};
use midsurf::io::write::{SolidFormat, stage_deviation, stage_solid};
use midsurf::roundtrip::{
    Comparison, RoundTrip, RoundTripError, Settings, deviation_map, roundtrip,
};
use midsurf::settings::cell::CellSize;
use midsurf::settings::quote::figure;
use serde_json::json;

use super::closed_part::work_json;
use super::rethicken;
use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::reading::{BodyArgs, ReadingArgs, SelectArgs};
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;

/// Deviation that is painted in full colour, over the thickness.
const FULL_COLOUR: f64 = 0.1;

const EXAMPLES: &str = "\
Examples:
  midsurf roundtrip part.obj --coping part.coping.txt --json -
  midsurf roundtrip part.obj --coping part.coping.txt --cell 0.33t -o deviation.ply --solid back.stl

Extracts the mid-surface, thickens it again by its maximal balls, and measures
how far the solid is from the part. Balls do not reach into convex corners whose
fins the extraction leaves out: figures are given everywhere, and away from those.

-o writes the part with the scalar `deviation` (positive where the solid sticks
out), blue at -0.1 thicknesses, green at zero, red at 0.1.

Exit codes: 0 done, 1 done but the mid-surface has cracks, 2 wrong usage or bad
input, 4 no usable result.";

/// Extract, thicken again, and compare with the part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part: a closed triangle or polygon mesh (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// Coping tags: a file (text, or TOML if the name ends in .toml), `auto` to
    /// find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    coping: CopingSource,
    /// Cell size of the extraction: a length, `0.5t` (wall thicknesses), `1%` (of the diagonal), or auto
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    cell: CellSize,
    /// Smallest object angle of a sheet in degrees, between 0 and 180
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = DEFAULT_ANGLE,
        value_parser = crate::cli::shared::numbers::angle,
        allow_negative_numbers = true
    )]
    angle: f64,
    /// Cell size of the solid: a length, `0.2t` (of the median thickness), `1%` (of the diagonal), or auto (a quarter of the least thickness)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    solid_cell: CellSize,
    /// Write the part painted with its deviation (.ply)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the solid (.stl, .obj, .ply)
    #[arg(long, value_name = "FILE")]
    solid: Option<PathBuf>,
    #[command(flatten)]
    select: BodyArgs,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    if let Some(file) = &args.solid {
        SolidFormat::of(file).map_err(Failure::input)?;
    }
    let mut inputs = vec![(args.part.as_path(), "part")];
    inputs.extend(args.coping.file().map(|file| (file, "coping tags")));
    let files = args.output.iter().chain(&args.solid).cloned().collect();
    args.run.check_names(&inputs, files)?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let select = SelectArgs::from(&args.select);
    let reading = args.reading.with(Some(&select));
    let mut input = Input::read(&args.part, &args.coping, &reading, false)?;
    let settings = Settings {
        extract: extract::Settings {
            cell: args.cell,
            min_angle: args.angle,
            keep_fins: false,
            memory_limit: args.memory.allowed(),
            elements: None,
        },
        solid_cell: args.solid_cell,
        memory_limit: args.memory.allowed(),
    };
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let result = roundtrip(&input.part, &settings, &show).map_err(|error| match &error {
        RoundTripError::Rethicken(error) => {
            rethicken::failure(error, &args.part).calling("--cell", "--solid-cell")
        }
        error => Failure::refused(&args.part, error),
    })?;
    let mut warnings = std::mem::take(&mut input.warnings);
    warnings.extend(result.solid.warnings.iter().map(|w| w.explained()));

    progress.show("writing", 0, 0);
    let thickness = result.comparison.thickness;
    let mut staged = Vec::new();
    if let Some(file) = &args.output {
        let size = result.extraction.work.cell.min(0.5 * thickness);
        let map = deviation_map(input.part.mesh(), &result.solid.mesh, size);
        let full = FULL_COLOUR * thickness;
        staged
            .push(stage_deviation(&map.mesh, &map.deviation, full, file).map_err(Failure::output)?);
    }
    if let Some(file) = &args.solid {
        staged.push(stage_solid(&result.solid.mesh, None, file).map_err(Failure::output)?);
    }
    let report = Envelope {
        command: "roundtrip",
        input: json!({
            "part": named(&input.file),
            "sha256": input.sha256,
            "triangles": input.part.triangle_count(),
            "volume": input.part.volume(),
            "area": input.part.area(),
        }),
        settings: args.reading.beside(
            Some(&select),
            json!({
                "cell": args.cell,
                "cell_length": result.extraction.work.cell,
                "angle": args.angle,
                "solid_cell_length": result.solid_settings.cell,
                "solid_tolerance": result.solid_settings.tolerance,
                "memory_limit": args.memory.memory_limit,
            }),
        ),
        seconds: json!(start.elapsed().as_secs_f64()),
        outputs: args
            .output
            .iter()
            .chain(&args.solid)
            .map(PathBuf::as_path)
            .collect(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "surface": {
            "vertices": result.extraction.surface.vertices().len(),
            "triangles": result.extraction.surface.triangles().len(),
            "cracks": result.extraction.graph.cracks().len(),
        },
        "solid": {
            "vertices": result.solid.mesh.positions.len(),
            "triangles": result.solid.mesh.triangles.len(),
            "volume": result.solid.mesh.volume(),
            "area": result.solid.mesh.area(),
            "work": work_json(&result.solid.work),
        },
        "comparison": result.comparison,
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(&result);
    }
    Ok(if result.extraction.graph.cracks().is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn summary(result: &RoundTrip) {
    let Comparison {
        thickness: t,
        volume_ratio,
        iou,
        all,
        away,
        pruned_area,
        ..
    } = result.comparison;
    say(format_args!(
        "solid: {} triangles, volume {:.3}% of the part's, {:.3}% in common",
        result.solid.mesh.triangles.len(),
        100.0 * volume_ratio,
        100.0 * iou
    ));
    let off = |distance: f64| format!("{} ({:.3}% of t)", figure(distance), 100.0 * distance / t);
    say(format_args!(
        "deviation: mean {}, greatest {}",
        off(all.mean),
        off(all.hausdorff)
    ));
    say(format_args!(
        "away from pruned corners ({:.2}% of the area): mean {}, greatest {}",
        100.0 * pruned_area,
        off(away.mean),
        off(away.hausdorff)
    ));
}
