//! The command line: raw flags, then checked settings, then the library.
//!
//! `commands` has a file a command, `shared` what several of them need. Commands
//! return a [`shared::failure::Failure`]; it is printed here, in one place, and
//! turned into the exit code.

mod allocator;
mod commands;
mod shared;

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use midsurf::io::limit_input;
use midsurf::io::write::abandon;
use midsurf::settings::memory::Bytes;
use miette::MietteHandlerOpts;
use shared::config;

pub(crate) use allocator::Allocator;

use commands::{
    check, completions, extract, hollow, info, merge, mesh, offset, rethicken, roundtrip, schema,
    subdivide, tags, thicken,
};

/// Exit code after SIGINT or SIGTERM, or Ctrl-C.
const INTERRUPTED: i32 = 130;

const EXIT_CODES: &str = "\
Exit codes:
  0    done
  1    done, but a requested check failed (the result has cracks, folds or cuts itself)
  2    wrong usage or bad input; nothing was written
  4    no usable result; nothing was written
  130  interrupted

Errors and progress go to stderr, data to stdout. NO_COLOR is respected.";

/// Mid-surface of a thin-wall part as one connected, crack-free, non-manifold
/// triangle mesh with thickness.
#[derive(Parser)]
#[command(name = "midsurf", version, after_help = EXIT_CODES)]
struct Cli {
    /// Read no file of more bytes than this
    #[arg(
        long,
        global = true,
        value_name = "SIZE",
        default_value = "8G",
        allow_negative_numbers = true
    )]
    max_input: Bytes,
    /// Take flags from a TOML file whose keys are flags without their dashes
    #[arg(long, global = true, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Extract(extract::Args),
    Merge(merge::Args),
    Mesh(mesh::Args),
    Check(check::Args),
    Info(info::Args),
    Subdivide(subdivide::Args),
    Tags(tags::Args),
    Offset(offset::Args),
    Hollow(hollow::Args),
    Thicken(thicken::Args),
    Rethicken(rethicken::Args),
    Roundtrip(roundtrip::Args),
    Completions(completions::Args),
    Man(completions::ManArgs),
    Schema(schema::Args),
    #[cfg(feature = "view")]
    View(commands::view::Args),
}

/// Parses the command line, runs the command, reports what went wrong.
pub fn run() -> ExitCode {
    // Fails only if a hook was set before.
    let _ = miette::set_hook(Box::new(|_| {
        let terminal = io::stderr().is_terminal();
        Box::new(
            MietteHandlerOpts::new()
                .wrap_lines(terminal)
                .break_words(false)
                .build(),
        )
    }));
    // Fails only if a handler was set before.
    let _ = ctrlc::set_handler(|| abandon(|| std::process::exit(INTERRUPTED)));
    let arguments = match config::expand(std::env::args_os().collect(), &Cli::command()) {
        Ok(arguments) => arguments,
        Err(failure) => {
            let code = failure.exit_code();
            failure.print(&["config".to_owned()]);
            return code;
        }
    };
    let parsed = Cli::command()
        .try_get_matches_from(arguments)
        .and_then(|matches| {
            let cli = Cli::from_arg_matches(&matches)?;
            Ok((cli, flags(&matches)))
        });
    let (cli, flags) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => error.exit(),
    };
    limit_input(cli.max_input.0);
    let outcome = match cli.command {
        Command::Extract(args) => extract::run(args),
        Command::Merge(args) => merge::run(args),
        Command::Mesh(args) => mesh::run(args),
        Command::Check(args) => check::run(args),
        Command::Info(args) => info::run(args),
        Command::Subdivide(args) => subdivide::run(args),
        Command::Tags(args) => tags::run(args),
        Command::Offset(args) => offset::run(args),
        Command::Hollow(args) => hollow::run(args),
        Command::Thicken(args) => thicken::run(args),
        Command::Rethicken(args) => rethicken::run(args),
        Command::Roundtrip(args) => roundtrip::run(args),
        Command::Completions(args) => completions::run(&args, Cli::command()),
        Command::Schema(args) => schema::run(&args),
        Command::Man(args) => completions::man(&args, Cli::command()),
        #[cfg(feature = "view")]
        Command::View(args) => commands::view::run(args),
    };
    match outcome {
        Ok(code) => code,
        Err(failure) => {
            let code = failure.exit_code();
            failure.print(&flags);
            code
        }
    }
}

/// Long flags of the command that was named, without their dashes.
fn flags(matches: &ArgMatches) -> Vec<String> {
    let (mut command, mut matches) = (Cli::command(), matches);
    while let Some((name, inner)) = matches.subcommand() {
        match command.find_subcommand(name).cloned() {
            Some(found) => (command, matches) = (found, inner),
            None => break,
        }
    }
    let whole = Cli::command();
    let all = whole.get_arguments().chain(command.get_arguments());
    let names = all.filter_map(|flag| flag.get_long());
    names.map(str::to_owned).collect()
}
