//! `midsurf view`: a page in the browser.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use midsurf::io::read_surface;
use midsurf::mesh::PartOptions;
use midsurf::view::{Server, Subject};

use crate::cli::shared::console::say;
use crate::cli::shared::coping::CopingSource;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::{load_tags, print_warnings};
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};

const EXAMPLES: &str = "\
Examples:
  midsurf view bracket.stl
  midsurf view bracket.stl --coping bracket.coping.toml
  midsurf view bracket.stl --coping bracket.coping.toml --mid mid.ply

Opens a page that shows the part with the coping faces that were detected, asks about
those in doubt, lets you mark others and save them as tags, and extracts the
mid-surface to look at. Ctrl-C ends it.

The page is for this machine and this browser alone: it is served on loopback, under
an address that nobody can guess. Nothing is written but the tag file: that of
--coping, or PART.coping.toml beside the part; and only when you press Save.

Exit codes: 2 wrong usage or bad input, 130 interrupted.";

/// Look at a part in the browser, tag coping faces, extract.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part: a mesh (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// Coping tags to start with: a file, `auto` to detect them, or `none`; saved tags
    /// go to that file if its name ends in .toml
    #[arg(long, value_name = "FILE", default_value = "auto")]
    coping: CopingSource,
    /// Mid-surface to show from the start
    #[arg(long, value_name = "FILE")]
    mid: Option<PathBuf>,
    /// Port of 127.0.0.1; a free one if left away
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address, open no browser
    #[arg(long)]
    no_open: bool,
    /// Go on when the part has gaps
    #[arg(long)]
    allow_open: bool,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    let (mut loaded, mut warnings) = args.reading.load(&args.part, Some(&args.select))?;
    let (coping, more) = load_tags(&args.coping, &loaded, &args.part)?;
    warnings.extend(more);
    print_warnings(&warnings);
    let mid = args.mid.as_deref().map(|file| read_surface(file, None));
    let surface = mid
        .transpose()
        .map_err(Failure::input)?
        .map(|mid| mid.surface);
    let (tag_file, tags_are_ours) = tag_file(&args);
    let subject = Subject {
        title: name_of(&args.part),
        geometry: loaded.geometry(),
        mesh: std::mem::take(&mut loaded.mesh),
        source: std::mem::take(&mut loaded.source),
        coping: coping.flags,
        detection: coping.detection,
        options: PartOptions {
            allow_open: args.allow_open,
            ..PartOptions::default()
        },
        tag_file,
        tags_are_ours,
        surface,
    };
    let server = Server::bind(subject, args.port).map_err(|error| {
        Failure::usage(
            format!("port {} of 127.0.0.1 cannot be used: {error}", args.port),
            "take another --port, or leave it away for a free one",
        )
    })?;
    say(format_args!("{}", server.url()));
    if !args.no_open && open::that_detached(server.url()).is_err() {
        say(format_args!(
            "no browser could be started: open this address in one"
        ));
    }
    server.run();
    Ok(ExitCode::SUCCESS)
}

/// Where tags are saved, and whether they come from there.
fn tag_file(args: &Args) -> (PathBuf, bool) {
    let is_toml = |file: &Path| {
        let suffix = file.extension();
        suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("toml"))
    };
    match args.coping.file() {
        Some(file) if is_toml(file) => (file.to_owned(), true),
        Some(file) => (file.with_extension("toml"), false),
        None => (args.part.with_extension("coping.toml"), false),
    }
}

fn name_of(file: &Path) -> String {
    file.file_name()
        .map_or_else(|| file.display(), |name| Path::new(name).display())
        .to_string()
}
