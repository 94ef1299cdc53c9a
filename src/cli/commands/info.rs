//! `midsurf info`: what a part is.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use midsurf::inspect::Walls;
use midsurf::intake::{CopingSource, Input};
use midsurf::io::write::{Scalars, stage_scalars};
use midsurf::report::info::Info;
use midsurf::settings::quote::{figure, shown, shown_path};

use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::pool;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::run::{check_names, check_suffix};

const EXAMPLES: &str = "\
Examples:
  midsurf info bracket.stl
  midsurf info bracket.obj --coping bracket.coping.txt --json
  midsurf info bracket.stl --min-wall 1.2 -o thickness.ply

Wall thickness is measured from the wall triangles, weighted by area. The two
checksums can be put under [mesh] in a TOML tag file, so that the tags are
refused for another mesh: sha256 is that of the file, geometry stays the same
when the mesh is converted between formats or its triangles are reordered.

Exit codes: 0 done, 1 a wall is thinner than --min-wall, 2 wrong usage or bad
input.";

/// Names shown before the list is cut short.
const NAMES_SHOWN: usize = 20;

/// Show what a part is: triangles, closedness, volume, box, names, thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// Coping tags: a file (text, or TOML if the name ends in .toml), `auto` to
    /// find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    coping: CopingSource,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
    /// Fail, with exit code 1, if a wall is thinner than this
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive)]
    min_wall: Option<f64>,
    /// Write a map of the wall thickness, coloured (.ply, .vtu)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let inputs = [(&*args.part, "part")];
    let tags = args.coping.file().map(|file| (file, "coping tags"));
    let inputs: Vec<_> = inputs.into_iter().chain(tags).collect();
    if let Some(file) = &args.output {
        check_suffix(file, ".ply, .vtu")?;
    }
    check_names(
        &inputs,
        args.output.iter().map(|file| (file.clone(), "map")),
    )?;
    pool::start(None);
    let reading = args.reading.with(Some(&args.select));
    let mut input = Input::read(&args.part, &args.coping, &reading, true)?;
    input.keep_for_info(&args.coping);
    let walls = Walls::of(&input.part);
    let thickness = walls.thickness(args.min_wall);
    if let Some(file) = &args.output {
        let Some(thickness) = &thickness else {
            return Err(Failure::no_result(
                format!(
                    "{}: no wall faces another, so there is no thickness to map",
                    shown_path(&args.part)
                ),
                "check the coping tags with `midsurf tags explain PART TAGS`",
            ));
        };
        let map = walls.map();
        let scalars = Scalars {
            name: "thickness",
            values: &map.thickness,
            range: thickness.range(),
        };
        let staged = stage_scalars(&map.mesh, scalars, file).map_err(Failure::output)?;
        staged.commit().map_err(Failure::output)?;
    }
    let info = Info::of(&input, thickness);
    print_warnings(&info.warnings);
    let mut out = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &info).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        print(&info, &mut out)?;
    }
    out.flush()?;
    let check = info.thickness.and_then(|thickness| thickness.check);
    Ok(match check {
        Some(check) if !check.passed => ExitCode::from(1),
        _ => ExitCode::SUCCESS,
    })
}

/// Tells people.
fn print(info: &Info, out: &mut impl Write) -> io::Result<()> {
    let shape = &info.shape;
    let [a, b] = [shape.min, shape.max];
    writeln!(out, "part         {}", shown(&info.part))?;
    write!(out, "triangles    {}", shape.triangles)?;
    if info.facets != shape.triangles {
        write!(out, " from {} faces", info.facets)?;
    }
    writeln!(out, ", {} of them coping", shape.coping_triangles)?;
    writeln!(out, "vertices     {}", shape.vertices)?;
    if shape.watertight {
        writeln!(out, "watertight   yes")?;
    } else {
        writeln!(out, "watertight   no, {} open edges", shape.open_edges)?;
    }
    if shape.non_manifold_edges > 0 {
        writeln!(
            out,
            "non-manifold {} edges with more than two triangles",
            shape.non_manifold_edges
        )?;
    }
    writeln!(out, "components   {}", shape.components)?;
    writeln!(out, "euler        {}", shape.euler)?;
    writeln!(out, "volume       {}", figure(shape.volume))?;
    writeln!(
        out,
        "area         {}, of it wall {}",
        figure(shape.area),
        figure(shape.wall_area)
    )?;
    writeln!(
        out,
        "box          ({}, {}, {}) to ({}, {}, {})",
        a[0], a[1], a[2], b[0], b[1], b[2]
    )?;
    writeln!(
        out,
        "size         {} x {} x {}, diagonal {}",
        figure(b[0] - a[0]),
        figure(b[1] - a[1]),
        figure(b[2] - a[2]),
        figure(shape.diagonal)
    )?;
    if let Some(unit) = info.unit {
        writeln!(out, "unit         {unit}")?;
    }
    match &info.thickness {
        Some(t) => writeln!(
            out,
            "thickness    5 % {}, 25 % {}, median {}, 75 % {}, 95 % {}",
            figure(t.p5),
            figure(t.p25),
            figure(t.p50),
            figure(t.p75),
            figure(t.p95)
        )?,
        None => writeln!(out, "thickness    unknown, no wall faces another")?,
    }
    if let Some(t) = &info.thickness {
        let [x, y, z] = t.thinnest_at.map(figure);
        writeln!(
            out,
            "thinnest     {} at ({x}, {y}, {z}), triangle {}",
            figure(t.thinnest),
            t.thinnest_triangle
        )?;
        if let Some(check) = t.check {
            let passed = if check.passed { "passed" } else { "failed" };
            writeln!(
                out,
                "min wall     {}: {passed}, {:.1} % of the wall is thinner",
                figure(check.min_wall),
                100.0 * check.share_below
            )?;
        }
    }
    for (kind, names) in [
        ("groups", &info.groups),
        ("objects", &info.objects),
        ("materials", &info.materials),
    ] {
        if !names.is_empty() {
            let names_shown = names.iter().take(NAMES_SHOWN).map(|name| shown(name));
            let list = names_shown.collect::<Vec<_>>().join(", ");
            let more = if names.len() > NAMES_SHOWN {
                ", …"
            } else {
                ""
            };
            writeln!(out, "{kind:<12} {}: {list}{more}", names.len())?;
        }
    }
    writeln!(out, "sha256       {}", info.sha256)?;
    writeln!(out, "geometry     {}", info.geometry)
}
