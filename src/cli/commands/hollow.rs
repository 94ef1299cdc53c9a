//! `midsurf hollow`: a closed part with a cavity.

use std::process::ExitCode;

use midsurf::offset::hollowed;

use super::closed_part::{self, ClosedPartArgs};
use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf hollow part.stl --thickness 2 -o shell.stl
  midsurf hollow part.obj --thickness 2 --cell 0.5 -o shell.obj

The outer surface is the part itself, triangle for triangle; the cavity is its
offset inwards, with walls of the same thickness everywhere. The cavity is
closed: a part to be printed needs a hole to let material out.

Exit codes: 0 done, 2 wrong usage or bad input, 4 the part is too thin for a cavity.";

/// Hollow a closed part out, leaving walls of one thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Thickness of the walls
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    thickness: f64,
    #[command(flatten)]
    part: ClosedPartArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    closed_part::run(&args.part, "hollow", -args.thickness, |part, mesh| {
        hollowed(part, &mesh)
    })
}
