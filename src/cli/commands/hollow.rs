//! `midsurf hollow`: a closed part with a cavity.

use std::process::ExitCode;

use midsurf::offset::{Cut, Drain, hollowed, opened};

use super::closed_part::{self, ClosedPartArgs};
use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf hollow part.stl --thickness 2 -o shell.stl
  midsurf hollow part.obj --thickness 2 --cell 0.5 -o shell.obj
  midsurf hollow part.stl --thickness 2 --drain 4@10,0,0 --drain 4@-10,0,0 -o shell.stl
  midsurf hollow part.stl --thickness 2 --open +z=30 -o cup.stl

The outer surface is the part itself, triangle for triangle; the cavity is its
offset inwards, with walls of the same thickness everywhere. The cavity is
closed: a part to be printed needs a hole to let material out. --drain makes
one, square to the surface at the point nearest to the one that is given, and
checks that it opens the cavity; --open cuts all away that lies beyond a plane.

Exit codes: 0 done, 2 wrong usage or bad input, 4 the part is too thin for a cavity.";

/// Hollow a closed part out, leaving walls of one thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Thickness of the walls
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    thickness: f64,
    /// Round hole into the cavity: diameter and a place on the surface; repeat for several
    #[arg(long, value_name = "D@X,Y,Z", allow_hyphen_values = true)]
    drain: Vec<Drain>,
    /// Plane beyond which all is cut away: `+z=10`, `-x=3`, or `NX,NY,NZ=DISTANCE`
    #[arg(long, value_name = "PLANE", allow_hyphen_values = true)]
    open: Vec<Cut>,
    #[command(flatten)]
    part: ClosedPartArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let Args {
        thickness,
        drain,
        open,
        part: flags,
    } = &args;
    closed_part::run(flags, "hollow", -thickness, |part, cavity| {
        let hollow = hollowed(part, &cavity);
        if drain.is_empty() && open.is_empty() {
            return Ok(hollow);
        }
        opened(
            &hollow,
            [part.mesh(), &cavity],
            drain,
            open,
            flags.precision(),
        )
        .map_err(|error| Failure::fruitless(flags.file(), &error))
    })
}
