//! What `midsurf extract` is told.

use std::path::PathBuf;

use midsurf::extract::{DEFAULT_ANGLE, Settings};
use midsurf::intake::CopingSource;
use midsurf::settings::cell::CellSize;
use midsurf::shard::ShardOf;

use crate::cli::shared::elements::ElementArgs;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::numbers::angle;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::shell::ShellArgs;

const EXAMPLES: &str = "\
Examples:
  midsurf extract bracket.obj --coping bracket.coping.txt -o mid.obj
  midsurf extract part.stl --coping part.toml --cell 0.5t -o mid.vtu -o mid.ply
  midsurf extract part.obj --coping part.coping.txt --cell 1.0 -o mid.obj --json report.json
  midsurf extract part.obj --coping part.coping.txt -o part.inp --template cantilever

The suffix of -o tells the format: .obj (one group a sheet, with NAME.thickness.csv
beside it), .ply and .vtu (with thickness), .stl, .html (a page to look at part and
mid-surface in any browser, in one file); .inp (CalculiX, Abaqus), .bdf (Nastran),
.msh (Gmsh) and .glb: shell models, with sets for sheets, seams, borders and coping
faces. Without -o only the summary is printed.

A sheet ends where the angle between its two footpoints falls below --angle: a
web a quarter as thick as the wall that it stands on still has 28 degrees there.
Fins into sharp outer corners are dropped at any angle, unless --keep-fins.

Features smaller than two cells (a vent, a small hole) may be closed over; the
report says which. A cell so small that the result would need more than
--memory-limit is refused, with the smallest cell that fits; --shard and
`midsurf merge` spread the work over machines.

An open part is refused;
--allow-open goes on all the same, but inside and outside are then guesses near
the gaps, and sheets may be missing or cut short there.

Exit codes: 0 done, 1 done but the result has cracks, 2 wrong usage or bad input,
4 no usable result, 130 interrupted.";

/// Extract the mid-surface of a part.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part: a closed triangle or polygon mesh (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    pub(crate) part: PathBuf,
    /// Coping tags: a file (text, or TOML if the name ends in .toml), `auto` to
    /// find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    pub(crate) coping: CopingSource,
    /// Cell size: a length, `0.5t` (wall thicknesses), `1%` (of the diagonal), or auto
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    pub(crate) cell: CellSize,
    /// Smallest object angle of a sheet in degrees, between 0 and 180
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = DEFAULT_ANGLE,
        value_parser = angle,
        allow_negative_numbers = true
    )]
    pub(crate) angle: f64,
    /// Output file; repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Compute one of several shards and write it to -o FILE.shard, to be joined by `midsurf merge`
    #[arg(long, value_name = "N/COUNT")]
    pub(crate) shard: Option<ShardOf>,
    /// Print all sheets, seams, borders and junctions to stdout, sorted by place
    #[arg(long)]
    pub(crate) list: bool,
    /// Keep the fins that run into convex edges of one wall
    #[arg(long)]
    pub(crate) keep_fins: bool,
    /// Go on when the part has gaps
    #[arg(long)]
    pub(crate) allow_open: bool,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) select: SelectArgs,
    #[command(flatten)]
    pub(crate) elements: ElementArgs,
    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
    /// Write seams and borders into OBJ files too, as lines
    #[arg(long)]
    pub(crate) obj_lines: bool,
    #[command(flatten)]
    pub(crate) shell: ShellArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

impl Args {
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            cell: self.cell,
            min_angle: self.angle,
            keep_fins: self.keep_fins,
            memory_limit: self.memory.allowed(),
            elements: self.elements.settings(),
        }
    }
}
