//! `midsurf offset`: a closed part grown or shrunk.

use std::process::ExitCode;

use midsurf::thicken::Side;

use super::closed_part::{self, ClosedPartArgs};
use super::{rethicken, thicken};
use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf offset part.stl --distance 2 --cell 0.5 -o grown.stl
  midsurf offset part.stl --distance=-2 -o shrunk.obj --json report.json
  midsurf offset surface.obj --distance 2 --open both -o around.stl

The result is closed, manifold and free of self-intersections, with the true
offset's sharp edges and corners. What is thinner than a cell may be missed:
gaps narrower than that close, walls thinner than that vanish.

With --open the part is a surface without thickness, open or closed. Both sides:
all that is within the distance of it, round along its boundary. One side: all
that is that near on it, flat along the boundary, as `midsurf thicken` makes it.

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
    /// Take the part for a surface without thickness, and offset it to this side
    #[arg(long, value_name = "SIDE", value_enum, conflicts_with_all = ["weld", "repair", "scale", "unit", "cad_sag", "solid", "voids"])]
    open: Option<OpenSide>,
    #[command(flatten)]
    part: ClosedPartArgs,
}

/// Side of an open surface.
#[derive(Clone, Copy, clap::ValueEnum)]
enum OpenSide {
    /// To both sides, round along the boundary
    Both,
    /// Along the normals, flat along the boundary
    Front,
    /// Against the normals, flat along the boundary
    Back,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let distance = args.distance;
    if let Some(side) = args.open {
        if !(distance > 0.0 && distance.is_finite()) {
            return Err(Failure::usage(
                format!(
                    "an open surface has no inside to shrink: the distance {distance} is not a positive length"
                ),
                "give --distance a positive length; --open front or back tells the side",
            ));
        }
        let patch = args.part.surface(distance);
        return match side {
            OpenSide::Both => rethicken::run_as("offset", patch.around(distance)),
            OpenSide::Front => thicken::one_sided("offset", &patch, Side::Outer),
            OpenSide::Back => thicken::one_sided("offset", &patch, Side::Inner),
        };
    }
    closed_part::run(&args.part, "offset", args.distance, |_, mesh| Ok(mesh))
}
