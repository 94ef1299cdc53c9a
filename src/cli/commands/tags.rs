//! `midsurf tags`: what a tag file selects, and tags found by the program.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use midsurf::coping::{Coping, RuleResult};
use midsurf::intake::{CopingSource, load_tags};
use midsurf::io::LoadedMesh;
use midsurf::io::write::stage;
use midsurf::mesh::FaceId;
use midsurf::settings::quote::{figure, shown};
use serde_json::json;

use super::{detect, explain};
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::pool;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::named;
use crate::cli::shared::run::{check_names, check_suffix};

const EXAMPLES: &str = "\
Examples:
  midsurf tags bracket.obj bracket.coping.txt
  midsurf tags bracket.stl bracket.toml -o split.obj
  midsurf tags detect bracket.stl -o bracket.coping.toml
  midsurf tags explain bracket.stl bracket.coping.toml

The text form of tags has one item a line: a triangle index `12` (from 0, in the
order of the file), a range `40-57`, or `group: rim_*`, which stands for all
triangles with a group, object or material name that fits (`*` any characters,
`?` one). `#` starts a comment. The TOML form selects by index, name, plane, box
and flood fill and can carry a checksum of its mesh.

Exit codes: 0 done, 2 wrong usage or bad input.";

/// Show what a tag file selects: count, area and box of each rule.
#[derive(clap::Args)]
#[command(
    after_help = EXAMPLES,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
pub(crate) struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    show: Option<ShowArgs>,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
}

/// What to do with tags, besides showing them.
#[derive(clap::Subcommand)]
enum Action {
    Detect(detect::Args),
    Explain(explain::Args),
}

#[derive(clap::Args)]
struct ShowArgs {
    /// The part (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// The tag file: text, or TOML if its name ends in .toml
    tags: PathBuf,
    /// Write the part as OBJ with the groups `coping` and `wall`, to look at
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    match (args.action, args.show) {
        (Some(Action::Detect(args)), _) => detect::run(&args),
        (Some(Action::Explain(args)), _) => explain::run(&args),
        (None, Some(show_args)) => show(show_args, &args.reading, &args.select),
        (None, None) => Err(Failure::usage(
            "a part and a tag file are needed",
            "`midsurf tags PART TAGS`, or `midsurf tags detect PART`",
        )),
    }
}

fn show(args: ShowArgs, reading: &ReadingArgs, select: &SelectArgs) -> Result<ExitCode, Failure> {
    pool::start(None);
    if let Some(file) = &args.output {
        check_output(&args, file)?;
    }
    let (loaded, mut warnings) = reading.with(Some(select)).load(&args.part)?;
    let (coping, more) = load_tags(&CopingSource::File(args.tags.clone()), &loaded, &args.part)?;
    warnings.extend(more);
    print_warnings(&warnings);
    if let Some(file) = &args.output {
        let staged = stage(file, |out| split(&loaded, &coping, out)).map_err(Failure::output)?;
        staged.commit().map_err(Failure::output)?;
    }

    let totals = [("all coping", true), ("all wall", false)].map(|(name, wanted)| {
        let chosen = |face: FaceId| coping.flags[face.index()] == wanted;
        RuleResult::of(&loaded.mesh, chosen, name, wanted)
    });
    let mut out = io::stdout().lock();
    if args.json {
        let rules: Vec<_> = coping.rules.iter().map(as_json).collect();
        let report = json!({
            "part": named(&args.part),
            "tags": named(&args.tags),
            "rules": rules,
            "coping": as_json(&totals[0]),
            "wall": as_json(&totals[1]),
            "warnings": warnings,
        });
        writeln!(out, "{report:#}")?;
    } else {
        print(&coping.rules, &totals, &mut out)?;
    }
    out.flush()?;
    Ok(ExitCode::SUCCESS)
}

fn check_output(args: &ShowArgs, file: &Path) -> Result<(), Failure> {
    check_suffix(file, ".obj")?;
    let inputs = [(&*args.part, "part"), (&*args.tags, "coping tags")];
    check_names(&inputs, [(file.to_owned(), "output")])
}

fn as_json(rule: &RuleResult) -> serde_json::Value {
    let corner = |p: glam::DVec3| (!rule.bounds.is_empty()).then(|| p.to_array());
    json!({
        "name": rule.name,
        "coping": rule.coping,
        "triangles": rule.count,
        "area": rule.area,
        "min": corner(rule.bounds.min),
        "max": corner(rule.bounds.max),
    })
}

fn print(rules: &[RuleResult], totals: &[RuleResult], out: &mut impl Write) -> io::Result<()> {
    let rows = || rules.iter().chain(totals);
    let name = rows().map(|rule| shown(&rule.name).chars().count()).max();
    let name = name.unwrap_or(0).max(4);
    writeln!(
        out,
        "{:<name$}  {:<6}  {:>9}  {:>12}  box",
        "rule", "makes", "triangles", "area"
    )?;
    for rule in rows() {
        let makes = if rule.coping { "coping" } else { "wall" };
        let area = figure(rule.area);
        write!(
            out,
            "{:<name$}  {makes:<6}  {:>9}  {area:>12}  ",
            shown(&rule.name),
            rule.count
        )?;
        if rule.bounds.is_empty() {
            writeln!(out, "empty")?;
        } else {
            let [a, b] = [rule.bounds.min, rule.bounds.max].map(|p| {
                let [x, y, z] = p.to_array().map(figure);
                format!("({x}, {y}, {z})")
            });
            writeln!(out, "{a} to {b}")?;
        }
    }
    Ok(())
}

/// The part as OBJ in two groups.
fn split(loaded: &LoadedMesh, coping: &Coping, out: &mut dyn Write) -> io::Result<()> {
    let mesh = &loaded.mesh;
    for p in &mesh.positions {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for (group, wanted) in [("coping", true), ("wall", false)] {
        writeln!(out, "g {group}")?;
        for (index, flag) in coping.flags.iter().enumerate() {
            if *flag == wanted {
                let [a, b, c] = mesh.triangles[index].map(|v| u64::from(v) + 1);
                writeln!(out, "f {a} {b} {c}")?;
            }
        }
    }
    Ok(())
}
