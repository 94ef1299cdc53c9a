//! `midsurf thicken`: a solid on one side of a surface.

use std::path::PathBuf;
use std::process::ExitCode;

use midsurf::dual_contour::Precision;
use midsurf::io::write::{SolidFormat, stage_solid};
use midsurf::thicken::{Settings, Side, thicken};
use serde_json::json;

use super::failure::Failure;
use super::info::figure;
use super::input::load;
use super::outputs;
use super::progress::Progress;
use super::say;

/// Thicken a surface into a solid on one side of it.
#[derive(clap::Args)]
pub(super) struct Args {
    /// The surface: an open or closed triangle or polygon mesh
    patch: PathBuf,
    /// Thickness of the solid
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    thickness: f64,
    /// Side of the patch
    #[arg(long, value_name = "SIDE", default_value = "inner")]
    side: String,
    /// Cell
    #[arg(long)]
    cell: Option<f64>,
    /// Output file (.stl, .obj, .ply); repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
}

pub(super) fn run(args: Args) -> Result<ExitCode, Failure> {
    let (loaded, _) = load(&args.patch)?;
    let side = if args.side == "inner" {
        Side::Inner
    } else {
        Side::Outer
    };
    let mut settings = Settings::new(args.thickness, side);
    if let Some(cell) = args.cell {
        settings.cell = cell;
    }
    let progress = Progress::new(true);
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let result =
        thicken(&loaded.mesh, &settings, &show).map_err(|e| Failure::usage(e.to_string(), ""))?;
    let mut staged = Vec::new();
    for file in &args.output {
        let _ = SolidFormat::of(file).map_err(Failure::input)?;
        staged.push(stage_solid(&result.mesh, file).map_err(Failure::output)?);
    }
    let _ = Precision::Double;
    outputs::finish(None, staged, &json!({}))?;
    say(format_args!(
        "{} triangles, {} pairs, volume {} band {:.2} contour {:.2} join {:.2}",
        result.mesh.triangles.len(),
        result.self_intersections,
        figure(result.mesh.volume()),
        result.work.band_seconds,
        result.work.contour_seconds,
        result.join_seconds,
    ));
    Ok(ExitCode::SUCCESS)
}
