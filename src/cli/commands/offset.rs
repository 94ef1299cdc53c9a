//! `midsurf offset`: a closed part grown or shrunk.

use std::process::ExitCode;

use super::closed_part::{self, ClosedPartArgs};
use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf offset part.stl --distance 2 --cell 0.5 -o grown.stl
  midsurf offset part.stl --distance=-2 -o shrunk.obj --json report.json

The result is closed, manifold and free of self-intersections, with the true
offset's sharp edges and corners. What is thinner than a cell may be missed:
gaps narrower than that close, walls thinner than that vanish.

Vertices of an .stl are chosen among the numbers of single precision, so that
rounding cannot make triangles cut each other; .obj and .ply keep full precision.

Exit codes: 0 done, 2 wrong usage or bad input, 4 nothing is left of the part.";

/// Grow or shrink a closed part by a distance.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Distance: positive grows the part, negative shrinks it
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    distance: f64,
    #[command(flatten)]
    part: ClosedPartArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    closed_part::run(&args.part, "offset", args.distance, |_, mesh| Ok(mesh))
}
