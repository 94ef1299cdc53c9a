//! `midsurf mesh`: a written mid-surface remeshed to elements.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use midsurf::extract::DEFAULT_ANGLE;
use midsurf::intake::{CopingSource, Input, check_size};
use midsurf::io::write::{
    ShellFormat, Staged, SurfaceOptions, files_for, stage_surface, thickness_file,
};
use midsurf::io::{MeshFormat, read_any_surface, read_surface};
use midsurf::report::extraction::account;
use midsurf::report::words::{counted, listed};
use midsurf::reshape::written::{RemeshError, Remeshed, WrittenSettings, remesh_written};
use midsurf::settings::quote::figure;
use midsurf::settings::warning::Warning;
use midsurf::shell::Faces;
use midsurf::surface::MidSurface;
use serde_json::json;

use crate::cli::shared::console::say;
use crate::cli::shared::elements::ElementArgs;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::figures::Figures;
use crate::cli::shared::input::print_warnings;
use crate::cli::shared::memory::MemoryArgs;
use crate::cli::shared::numbers::angle;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::{Envelope, named};
use crate::cli::shared::run::RunArgs;
use crate::cli::shared::shell::ShellArgs;

const EXAMPLES: &str = "\
Examples:
  midsurf extract part.stl -o mid.ply
  midsurf mesh mid.ply --part part.stl --element-size 2t --quads -o model.bdf
  midsurf mesh mid.ply --element-size 4 -o model.inp -o model.vtu
  midsurf mesh mid.ply --part part.stl --element-size 4 --junctions straight -o model.inp

MID is a mid-surface with its thickness: .ply, or .obj with NAME.thickness.csv beside
it, as `midsurf extract` writes them. With --part it may be of any program and format,
and needs no thickness.

With --part every vertex goes onto the exact mid-surface of the part, coping faces
give sets to support and load, and walls can be carried on (--junctions straight).
Without, vertices stay on the triangles and lines that were written.

Exit codes: 0 done, 1 done but the mid-surface has cracks, 2 wrong usage or bad input,
4 no usable result, 130 interrupted.";

/// Remesh a written mid-surface to elements of a size.
#[derive(clap::Args)]
#[command(
    after_help = EXAMPLES,
    mut_arg("element_size", |size| size.required(true))
)]
pub(crate) struct Args {
    /// The mid-surface
    surface: PathBuf,
    /// The part that it was extracted from: a closed triangle or polygon mesh
    #[arg(long, value_name = "PART")]
    part: Option<PathBuf>,
    /// Coping tags of the part: a file (text, or TOML if the name ends in .toml), `auto` to find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto", requires = "part")]
    coping: CopingSource,
    /// Smallest object angle that the mid-surface was extracted with, in degrees
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = DEFAULT_ANGLE,
        value_parser = angle,
        requires = "part",
        allow_negative_numbers = true
    )]
    angle: f64,
    /// The mid-surface holds the fins that run into convex edges
    #[arg(long, requires = "part")]
    keep_fins: bool,
    /// Output file; repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    elements: ElementArgs,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Write seams and borders into OBJ files too, as lines
    #[arg(long)]
    obj_lines: bool,
    #[command(flatten)]
    shell: ShellArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    args.check_names()?;
    let Some(elements) = args.elements.settings() else {
        return Err(Failure::usage(
            "no element size is given",
            "give --element-size",
        ));
    };
    let start = Instant::now();
    let progress = args.run.start()?;
    let input = args.input()?;
    let written = args.read(input.as_ref())?;
    let read = start.elapsed().as_secs_f64();
    progress.show("remesh", 0, 0);
    let settings = WrittenSettings {
        elements,
        min_angle: args.angle,
        keep_fins: args.keep_fins,
        memory_limit: args.memory.allowed(),
    };
    let part = input.as_ref().map(|i| &i.part);
    let result = remesh_written(&written, part, &settings).map_err(|error| match error {
        RemeshError::BadSize(_) => {
            Failure::refused(&args.surface, &error).calling("--cell", "--element-size")
        }
        _ => Failure::refused(&args.surface, &error),
    })?;
    if result.surface.triangles().is_empty() {
        return Err(Failure::no_result(
            format!("{}: has no triangle with an area", named(&args.surface)),
            "extract the mid-surface again",
        ));
    }

    progress.show("writing", 0, 0);
    let faces = Faces {
        quads: result.quads.clone(),
        middles: result.middles.iter().copied().collect(),
    };
    let mut staged = args.stage(&result.surface)?;
    let (models, model) =
        (args.shell).stage(input.as_ref(), &result.surface, &faces, &args.output)?;
    staged.extend(models);
    let total = start.elapsed().as_secs_f64();
    let figures = Figures::of(&result.surface, &result.graph);
    let mut warnings = input.map_or_else(Vec::new, |i| i.warnings);
    warnings.extend(cracks(&result));
    let report = Envelope {
        command: "mesh",
        input: json!({
            "surface": named(&args.surface),
            "part": args.part.as_deref().map(named),
            "coping": args.coping,
            "vertices": written.vertices().len(),
            "triangles": written.triangles().len(),
        }),
        settings: args.reading.beside(
            Some(&args.select),
            json!({
                "elements": elements,
                "element_length": result.size,
                "angle": args.angle,
                "keep_fins": args.keep_fins,
                "memory_limit": args.memory.memory_limit,
                "obj_lines": args.obj_lines,
            }),
        ),
        seconds: json!({
            "read": read,
            "remesh": result.seconds,
            "write": total - read - result.seconds,
            "total": total,
        }),
        outputs: args.output.iter().map(PathBuf::as_path).collect(),
        warnings: warnings.iter().collect(),
    }
    .around(json!({
        "result": account(&result.surface, &result.graph),
        "quads": result.quads.len(),
        "cracks": result.graph.cracks().len(),
        "work": { "remeshing": result.edits },
        "shell": model,
    }));
    args.run.finish(staged, &report)?;
    drop(progress);
    if !args.run.quiet {
        print_warnings(&warnings);
        for line in figures.lines(&result.graph) {
            say(format_args!("{line}"));
        }
        say(format_args!(
            "elements     {} long, {}, {} alone",
            figure(result.size),
            counted(result.quads.len(), "quadrilateral"),
            counted(
                result.surface.triangles().len() - 2 * result.quads.len(),
                "triangle"
            ),
        ));
        say(format_args!(
            "seconds      {total:.3}: read {read:.3}, remesh {:.3}",
            result.seconds
        ));
    }
    Ok(ExitCode::from(u8::from(!result.graph.cracks().is_empty())))
}

/// A warning of edges that end without a border.
fn cracks(result: &Remeshed) -> Option<Warning> {
    let cracks = result.graph.cracks();
    (!cracks.is_empty()).then(|| {
        Warning::new(
            "cracks",
            format!(
                "the mid-surface has {}, at {}: something is missing there; extract it with another --cell",
                counted(cracks.len(), "crack"),
                listed(cracks.iter().map(|crack| crack.at)),
            ),
        )
    })
}

impl Args {
    /// Refuses file names that could not be written or are named twice.
    fn check_names(&self) -> Result<(), Failure> {
        let beside = thickness_file(&self.surface);
        let mut inputs = vec![(self.surface.as_path(), "mid-surface")];
        inputs.extend(self.part.as_deref().map(|file| (file, "part")));
        inputs.extend(self.coping.file().map(|file| (file, "coping tags")));
        if MeshFormat::of(&self.surface) != Some(MeshFormat::Ply) && beside.is_file() {
            inputs.push((&beside, "thickness"));
        }
        let mut files = Vec::new();
        for output in &self.output {
            files.extend(files_for(output).map_err(Failure::input)?);
        }
        self.run.check_names(&inputs, files)
    }

    fn input(&self) -> Result<Option<Input>, Failure> {
        let reading = self.reading.with(Some(&self.select));
        let read = |part| Input::read(part, &self.coping, &reading, false);
        Ok(self.part.as_deref().map(read).transpose()?)
    }

    /// The mid-surface; its thickness is that of the part where there is one.
    fn read(&self, input: Option<&Input>) -> Result<MidSurface, Failure> {
        check_size(&self.surface)?;
        match input {
            Some(input) => {
                let (surface, _) = read_any_surface(&self.surface).map_err(Failure::input)?;
                input.owns(&self.surface, &surface)?;
                Ok(surface)
            }
            None => {
                let loaded = read_surface(&self.surface, None).map_err(Failure::input)?;
                Ok(loaded.surface)
            }
        }
    }

    /// Writes the surface under passing names.
    fn stage(&self, surface: &MidSurface) -> Result<Vec<Staged>, Failure> {
        let options = SurfaceOptions {
            obj_lines: self.obj_lines,
        };
        let mut staged = Vec::new();
        for file in (self.output.iter()).filter(|file| ShellFormat::of(file).is_none()) {
            staged.extend(stage_surface(surface, file, options).map_err(Failure::output)?);
        }
        Ok(staged)
    }
}
