//! `midsurf subdivide`: control mesh in, hollow solid and report out.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use midsurf::intake::ControlInput;
use midsurf::offset::OffsetError;
use midsurf::settings::cell::CellSize;
use midsurf::settings::quote::figure;
use midsurf::settings::warning::Warning;
use midsurf::subdivide::{
    Boundary, Cage, ContourError, ContourSettings, Hollow, HollowSolid, Level, MOST_LEVELS,
    MOST_SAMPLES, Scheme, Settings, SubdivideError, check_memory, contour, hollow_out, interpolate,
    level_and_samples,
};
use serde_json::{Value, json};

use super::subdivide_report::{figures, mean, range, shade, summary};
use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::groups::{Group, pairs};
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::numbers::positive;
use crate::cli::shared::progress::Progress;
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::solid::SolidArgs;

const EXAMPLES: &str = "\
Examples:
  midsurf subdivide control.obj --thickness 0.2 --samples 6 --levels 1 -o hollow.stl --json report.json
  midsurf subdivide control.obj --thickness 0.2 --tolerance 0.01 -o hollow.obj -o thickness.ply
  midsurf subdivide control.obj --thickness 0.2 --scheme direct -o direct.stl
  midsurf subdivide control.obj --interpolate -o through.obj

The control mesh is a Catmull-Clark cage of polygons, closed or with a boundary.
The outer surface of the solid is its limit surface; the inner one lies a
thickness below, exactly at the corners of the faces, less between them. --levels
subdivides first: with each level the thickness comes nearer to the one asked
for, but the inner surface folds at a smaller one. --tolerance takes the first
level that is good enough and free of folds; where there is none, it says what
each level gives.

The suffix of -o tells the format: .stl, .obj, or .ply with the thickness at
every vertex as a number and a colour, red thin, blue thick.

Exit codes: 0 done, 1 done but the solid has folded triangles or cuts itself, 2
wrong usage or bad input, 4 no usable result, 130 interrupted.";

/// Make a hollow solid of a Catmull-Clark control mesh.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The control mesh (.obj): polygons, best quadrilaterals
    control: PathBuf,
    /// Wall thickness
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true, required_unless_present = "interpolate")]
    thickness: Option<f64>,
    /// Another thickness for the faces of a group, object or material; repeat for several
    #[arg(long, value_name = "NAME=LENGTH", requires = "thickness")]
    group: Vec<Group>,
    /// Steps along each side of a face [default: 8, fewer where semi-sharp tags ask for more levels]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_SAMPLES as i64))]
    samples: Option<u16>,
    /// Subdivision steps before the inner surface is laid, all counted [default: 1]
    #[arg(long, value_name = "N", conflicts_with = "tolerance", value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_LEVELS)))]
    levels: Option<u32>,
    /// Take the first level whose wall is nowhere thinner by more than this and has no fold
    #[arg(long, value_name = "LENGTH", value_parser = positive, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// How the inner surface follows from the outer one
    #[arg(long, value_enum, default_value_t = SchemeName::Crust)]
    scheme: SchemeName,
    /// Cell size of --scheme contour's grid: a length, `0.5t` (wall thicknesses), `1%` (of the diagonal), or auto (256 cells along the surface)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    cell: CellSize,
    /// What becomes of the boundary [default: what the file's interpolateboundary tag says, else corner]
    #[arg(long, value_enum)]
    boundary: Option<BoundaryName>,
    /// Instead of a solid, the surface that passes through the control vertices
    #[arg(long, conflicts_with_all = ["thickness", "tolerance", "scheme"])]
    interpolate: bool,
    #[command(flatten)]
    solid: SolidArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    run: RunArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SchemeName {
    /// Bezier crust: smooth as the surface itself
    Crust,
    /// Along the normal of every sample
    Direct,
    /// All that is deeper than the thickness: never folds, at any thickness
    Contour,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum BoundaryName {
    /// Curves, and vertices of a single face held in place (edge and corner)
    Corner,
    /// Curves, smooth at such vertices too (edge only)
    Edge,
    /// Faces at the boundary have no surface, but shape that of the others
    None,
}

impl Args {
    fn scheme(&self) -> Option<Scheme> {
        match self.scheme {
            SchemeName::Crust => Some(Scheme::Crust),
            SchemeName::Direct => Some(Scheme::Direct),
            SchemeName::Contour => None,
        }
    }

    /// Steps a side where none are asked for: about eight along a side of a face
    /// at the level asked for.
    fn samples(&self, cage: &Cage) -> usize {
        match self.samples {
            Some(samples) => usize::from(samples),
            None => level_and_samples(cage, self.levels.unwrap_or(1), 8).1,
        }
    }

    fn level(&self) -> Level {
        match self.tolerance {
            Some(tolerance) => Level::Tolerance(tolerance),
            None => Level::Fixed(self.levels.unwrap_or(1)),
        }
    }
}

/// A control mesh, and when reading it began and the seconds that took.
struct Control {
    cage: Cage,
    boundary: BoundaryName,
    sha256: String,
    warnings: Vec<Warning>,
    started: Instant,
    read_seconds: f64,
}

impl Control {
    fn read(args: &Args) -> Result<Control, Failure> {
        let started = Instant::now();
        let groups = pairs(&args.group);
        let input = ControlInput::read(&args.control, args.thickness, &groups)?;
        Ok(Control {
            boundary: args.boundary.unwrap_or(BoundaryName::of(input.boundary)),
            cage: input.cage,
            sha256: input.sha256,
            warnings: input.warnings,
            started,
            read_seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// Seconds up to now.
    fn seconds(&self) -> Value {
        json!({ "read": self.read_seconds, "total": self.started.elapsed().as_secs_f64() })
    }
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let inputs = [(args.control.as_path(), "control mesh")];
    args.solid.check_names(&inputs, &args.run)?;
    let progress = args.run.start()?;
    let control = Control::read(&args)?;
    let level = args.levels.unwrap_or(1);
    let samples = args.samples(&control.cage);
    check_memory(&control.cage, level, samples, args.memory.allowed())
        .map_err(|error| failed(&error, &args.control))?;
    if !args.run.quiet {
        progress.aside(|| print_warnings(&control.warnings));
    }
    if args.interpolate {
        return through(&args, &control, &progress);
    }
    let Some(scheme) = args.scheme() else {
        return contoured(&args, &control, &progress);
    };
    let settings = Settings {
        // Clap asks for it unless --interpolate is given.
        thickness: args.thickness.unwrap_or_default(),
        samples: args.samples(&control.cage),
        level: args.level(),
        scheme,
        boundary: control.boundary.rule(),
    };
    let stages = RefCell::new(Vec::new());
    let show = |stage| {
        progress.show(stage, 0, 0);
        stages.borrow_mut().push((stage, Instant::now()));
    };
    let solid = hollow_out(&control.cage, &settings, &show)
        .map_err(|error| failed(&error, &args.control))?;

    show("writing");
    let thickness = [solid.thickness.as_slice(), &solid.thickness].concat();
    let normals = Hollow::normals(&solid.samples);
    let staged = (args.solid).stage(&solid.hollow.mesh, shade(&thickness, &normals))?;
    let warnings = solid.warnings(&settings);
    show("report");
    let mut seconds = control.seconds();
    seconds["stages"] = by_stage(&stages.borrow());
    let report = report(&args, &control, &settings, &solid, (seconds, &warnings));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(&solid, &settings, args.run.verbose);
    }
    let sound = solid.folded.is_empty() && solid.intersections.is_empty();
    Ok(if sound {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

/// Seconds by stage, those of the same name together.
fn by_stage(stages: &[(&'static str, Instant)]) -> Value {
    let mut seconds = serde_json::Map::new();
    for pair in stages.windows(2) {
        let before = seconds.get(pair[0].0).and_then(Value::as_f64);
        let this = pair[1].1.duration_since(pair[0].1).as_secs_f64();
        seconds.insert(pair[0].0.to_owned(), json!(before.unwrap_or(0.0) + this));
    }
    Value::Object(seconds)
}

fn failed(error: &SubdivideError, file: &Path) -> Failure {
    match error {
        SubdivideError::NoLevel { .. } => Failure::fruitless(file, error),
        _ => Failure::refused(file, error),
    }
}

/// `--scheme contour`: the inner wall from the offset of the surface.
fn contoured(args: &Args, control: &Control, progress: &Progress) -> Result<ExitCode, Failure> {
    if args.tolerance.is_some() {
        return Err(Failure::usage(
            "--tolerance chooses a level for the crust, and --scheme contour lays none",
            "say with --levels and --samples how finely to divide the surface",
        ));
    }
    let settings = ContourSettings {
        // Clap asks for it unless --interpolate is given.
        thickness: args.thickness.unwrap_or_default(),
        samples: args.samples(&control.cage),
        level: args.levels.unwrap_or(1),
        boundary: control.boundary.rule(),
        cell: args.cell,
        precision: args.solid.precision(),
    };
    let show = |stage, done, total| progress.show(stage, done, total);
    let solid = contour(&control.cage, &settings, &show).map_err(|error| match &error {
        ContourError::Surface(error) => failed(error, &args.control),
        ContourError::Offset(OffsetError::Empty(_)) => Failure::fruitless(&args.control, &error),
        _ => Failure::refused(&args.control, &error),
    })?;
    progress.show("writing", 0, 0);
    let staged = args
        .solid
        .stage(&solid.mesh, shade(&solid.thickness, &[]))?;
    let [least, most] = range(&solid.thickness);
    let report = Envelope {
        command: "subdivide",
        input: input(args, control),
        settings: json!({
            "scheme": "contour",
            "thickness": settings.thickness,
            "samples": settings.samples,
            "boundary": control.boundary.name(),
        }),
        seconds: control.seconds(),
        outputs: args.solid.outputs(),
        warnings: control.warnings.iter().collect(),
    }
    .around(json!({
        "result": {
            "levels": solid.level,
            "vertices": solid.mesh.positions.len(),
            "triangles": solid.mesh.triangles.len(),
            "shell_triangles": solid.outer,
            "volume": solid.mesh.volume(),
            "thickness": { "min": least, "mean": mean(&solid.thickness), "max": most },
            "intersections": solid.intersections.len(),
        },
    }));
    args.run.finish(staged, &report)?;
    if !args.run.quiet {
        say(format_args!("levels       {}", solid.level));
        say(format_args!(
            "solid        {} vertices, {} triangles, volume {}",
            solid.mesh.positions.len(),
            solid.mesh.triangles.len(),
            figure(solid.mesh.volume())
        ));
        say(format_args!(
            "thickness    {} to {}",
            figure(least),
            figure(most)
        ));
    }
    Ok(if solid.intersections.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

/// `--interpolate`: writes the surface through the control vertices.
fn through(args: &Args, control: &Control, progress: &Progress) -> Result<ExitCode, Failure> {
    progress.show("surface", 0, 0);
    let samples = args.samples(&control.cage);
    let level = args.levels.unwrap_or(0);
    let (mesh, level) = interpolate(&control.cage, level, samples, control.boundary.rule())
        .map_err(|error| failed(&error, &args.control))?;
    let staged = args.solid.stage(&mesh, None)?;
    let report = Envelope {
        command: "subdivide",
        input: input(args, control),
        settings: json!({ "interpolate": true, "samples": samples, "boundary": control.boundary.name() }),
        seconds: control.seconds(),
        outputs: args.solid.outputs(),
        warnings: control.warnings.iter().collect(),
    }
    .around(json!({
        "result": {
            "levels": level,
            "vertices": mesh.positions.len(),
            "triangles": mesh.triangles.len(),
        },
    }));
    args.run.finish(staged, &report)?;
    if !args.run.quiet {
        say(format_args!("levels       {level}"));
        say(format_args!(
            "mesh         {} vertices, {} triangles",
            mesh.positions.len(),
            mesh.triangles.len()
        ));
    }
    Ok(ExitCode::SUCCESS)
}

impl BoundaryName {
    fn of(rule: Boundary) -> BoundaryName {
        match rule {
            Boundary::EdgeAndCorner => BoundaryName::Corner,
            Boundary::EdgeOnly => BoundaryName::Edge,
            Boundary::None => BoundaryName::None,
        }
    }

    fn rule(self) -> Boundary {
        match self {
            BoundaryName::Corner => Boundary::EdgeAndCorner,
            BoundaryName::Edge => Boundary::EdgeOnly,
            BoundaryName::None => Boundary::None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            BoundaryName::Corner => "corner",
            BoundaryName::Edge => "edge",
            BoundaryName::None => "none",
        }
    }
}

fn input(args: &Args, control: &Control) -> Value {
    let cage = &control.cage;
    json!({
        "control": named(&args.control),
        "sha256": control.sha256,
        "vertices": cage.positions().len(),
        "faces": cage.face_count(),
        "quads": cage.is_quads(),
        "closed": cage.is_closed(),
        "euler": cage.euler(),
        "diagonal": cage.diagonal(),
    })
}

fn report(
    args: &Args,
    control: &Control,
    settings: &Settings,
    solid: &HollowSolid,
    (seconds, warnings): (Value, &[Warning]),
) -> Value {
    Envelope {
        command: "subdivide",
        input: input(args, control),
        settings: json!({
            "thickness": settings.thickness,
            "groups": args.group.iter().map(|g| json!([g.name, g.thickness])).collect::<Vec<_>>(),
            "samples": settings.samples,
            "levels": args.levels,
            "tolerance": args.tolerance,
            "scheme": settings.scheme.name(),
            "boundary": control.boundary.name(),
        }),
        seconds,
        outputs: args.solid.outputs(),
        warnings: control.warnings.iter().chain(warnings).collect(),
    }
    .around(figures(solid, settings))
}
