//! What the commands that offset a closed part have in common: flags, the
//! run, the report.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use midsurf::intake::{CopingSource, Input};
use midsurf::mesh::{Part, TriMesh};
use midsurf::offset::Work;
use midsurf::offset::{Offset, OffsetError, Settings, Voids, offset};
use midsurf::report::bodies::Bodies;
use midsurf::settings::cell::{CellSize, Scale};
use midsurf::settings::precision::Precision;
use midsurf::settings::quote::figure;
use serde_json::{Value, json};

use super::thicken::{self, SideArg};
use crate::cli::shared::console::say;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::solid::{SimplifyArgs, SolidArgs, summary};

/// Flags of `offset` and `hollow`.
#[derive(clap::Args)]
pub(crate) struct ClosedPartArgs {
    /// The part: a closed triangle or polygon mesh (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// Cell size: a length, `1%` (of the part's diagonal), or auto (256 cells along the result)
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    cell: CellSize,
    /// Split chords that stray farther than this from the offset [default: 0.2% of the distance]
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    solid: SolidArgs,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
    #[command(flatten)]
    fewer: SimplifyArgs,
    /// What to do with cavities that the part has
    #[arg(long, value_enum, default_value_t = VoidsName::Keep)]
    voids: VoidsName,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// What becomes of cavities.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum VoidsName {
    /// They stay, and the solid is offset from them too
    Keep,
    /// They are filled first
    Fill,
}

/// Offsets the part, makes the result of it and writes that.
pub(crate) fn run(
    args: &ClosedPartArgs,
    command: &str,
    distance: f64,
    finish: impl Fn(&Part, TriMesh) -> Result<TriMesh, Failure>,
) -> Result<ExitCode, Failure> {
    let inputs = [(args.part.as_path(), "part")];
    args.solid.check_names(&inputs, &args.run)?;
    let start = Instant::now();
    let progress = args.run.start()?;
    let reading = args.reading.with(Some(&args.select));
    let mut input = Input::read(&args.part, &CopingSource::None, &reading, false)?;
    // Tags have no meaning here, so none are missing.
    input.warnings.retain(|warning| warning.code != "no_coping");
    let read_seconds = start.elapsed().as_secs_f64();

    let settings = args.settings(&input, distance)?;
    let show = |stage, done, expected| progress.show(stage, done, expected);
    let mut result = offset(&input.part, &settings, &show).map_err(|error| match error {
        OffsetError::Empty(_) => Failure::fruitless(&args.part, &error),
        _ => Failure::refused(&args.part, &error),
    })?;
    let mut warnings = std::mem::take(&mut input.warnings);
    warnings.extend(result.warnings.iter().map(|w| w.explained(distance)));

    progress.show("writing", 0, 0);
    let begin = Instant::now();
    let solid = result.solid.as_ref().unwrap_or(&input.part);
    let mesh = finish(solid, std::mem::take(&mut result.mesh))?;
    let bodies = Bodies::of(&mesh, command == "hollow");
    warnings.extend(bodies.warnings(&result.voids, solid));
    let staged = args.solid.stage(&mesh, None)?;
    let seconds = json!({
        "read": read_seconds,
        "field": result.field_seconds,
        "band": result.work.band_seconds,
        "contour": result.work.contour_seconds,
        "write": begin.elapsed().as_secs_f64(),
        "total": start.elapsed().as_secs_f64(),
    });
    let report = Envelope {
        command,
        input: json!({
            "part": named(&input.file),
            "sha256": input.sha256,
            "geometry": input.geometry,
            "triangles": input.part.triangle_count(),
            "volume": input.part.volume(),
            "area": input.part.area(),
            "voids": result.voids,
        }),
        settings: args.reading.beside(
            Some(&args.select),
            json!({
                "distance": distance,
                "cell": args.cell,
                "cell_length": settings.cell,
                "tolerance": settings.tolerance,
                "precision": settings.precision,
                "memory_limit": args.memory.memory_limit,
                "voids": settings.voids,
                "simplify": args.fewer.wanted(),
                "wanted_triangles": args.fewer.triangles,
            }),
        ),
        seconds: json!(seconds),
        outputs: args.solid.outputs(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "result": {
            "vertices": mesh.positions.len(),
            "triangles": mesh.triangles.len(),
            "volume": mesh.volume(),
            "area": mesh.area(),
            "simplified_within": result.simplified,
            "pieces": bodies.pieces,
            "cavities": bodies.cavities,
            "self_intersections": bodies.self_intersections,
            "non_manifold_edges": bodies.non_manifold_edges,
            "corner_deviation": result.corner_deviation,
            "centre_deviation": result.centre_deviation,
        },
        "work": work_json(&result.work),
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        summary(&mesh);
        say_bodies(&bodies);
        say(format_args!(
            "off the offset by {} at most, {} in the mean (of the distance: {} and {})",
            figure(result.centre_deviation.max),
            figure(result.centre_deviation.mean),
            figure(result.centre_deviation.max / distance.abs()),
            figure(result.centre_deviation.mean / distance.abs()),
        ));
    }
    if args.run.verbose > 0 {
        details(&result);
    }
    Ok(if bodies.is_solid() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

impl ClosedPartArgs {
    pub(crate) fn file(&self) -> &Path {
        &self.part
    }

    /// Numbers that the files can hold.
    pub(crate) fn precision(&self) -> Precision {
        self.solid.precision()
    }

    /// The same files and grid for a surface without thickness.
    pub(crate) fn surface(self, thickness: f64) -> thicken::Args {
        thicken::Args {
            patch: self.part,
            thickness: Some(thickness),
            side: SideArg::Inner,
            cell: self.cell,
            tolerance: self.tolerance,
            fill: None,
            fewer: self.fewer,
            solid: self.solid,
            memory: self.memory,
            run: self.run,
        }
    }

    fn settings(&self, input: &Input, distance: f64) -> Result<Settings, Failure> {
        let mut settings = Settings::new(&input.part, distance);
        let scale = Scale {
            auto: Some(settings.cell),
            thickness: None,
            diagonal: input.part.bounds().diagonal(),
        };
        settings.cell = self.cell.resolve(&scale).map_err(Failure::input)?;
        if let Some(tolerance) = self.tolerance {
            settings.tolerance = tolerance;
        }
        settings.simplify = self.fewer.within(settings.tolerance);
        settings.memory_limit = self.memory.allowed();
        settings.voids = match self.voids {
            VoidsName::Keep => Voids::Keep,
            VoidsName::Fill => Voids::Fill,
        };
        settings.precision = self.solid.precision();
        Ok(settings)
    }
}

/// Tells people of pieces and cavities.
fn say_bodies(bodies: &Bodies) {
    let count =
        |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
    say(format_args!(
        "{}, {} of volume {}",
        count(bodies.pieces, "piece", "pieces"),
        count(bodies.cavities.len(), "cavity", "cavities"),
        // The sum of none is -0.
        figure(bodies.cavities.iter().sum::<f64>() + 0.0),
    ));
}

/// What each stage took and left, for `--verbose`.
fn details(result: &Offset) {
    let f = &result.work.filters;
    let c = &result.work.crossings;
    say(format_args!(
        "nodes: {} in the grid, {} after boxes, {} after signs; {} distances ({} of them for boxes), {} valid",
        f.nodes, f.after_boxes, f.after_signs, f.distances, f.box_tests, f.valid
    ));
    let share = |n: u64| 100.0 * n as f64 / c.edges.max(1) as f64;
    let upto: u64 = c.by_splits[..=6].iter().sum();
    say(format_args!(
        "crossings: {}; {:.1}% at once, {:.1}% after one split, {:.1}% after two, {:.1}% within six",
        c.edges,
        share(c.by_splits[0]),
        share(c.by_splits[1]),
        share(c.by_splits[2]),
        share(upto)
    ));
    let [cells, faces, edges] = result.work.vertices;
    say(format_args!(
        "vertices: {cells} in cells, {faces} on faces, {edges} on edges, {} mended; {} closest-point queries",
        result.work.mends.split, result.work.queries
    ));
    say(format_args!(
        "seconds: field {:.3}, band {:.3}, contour {:.3}",
        result.field_seconds, result.work.band_seconds, result.work.contour_seconds
    ));
}

/// The grid's work, for reports.
pub(crate) fn work_json(work: &Work) -> Value {
    json!({
        "filters": work.filters,
        "crossings": work.crossings,
        "cell_vertices": work.vertices[0],
        "face_vertices": work.vertices[1],
        "edge_vertices": work.vertices[2],
        "rings": work.rings,
        "mends": work.mends,
        "queries": work.queries,
    })
}
