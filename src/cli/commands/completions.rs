//! `midsurf completions` and `midsurf man`: the flags, for a shell and for
//! `man`.

use std::io::{self, Write};
use std::process::ExitCode;

use clap::Command;
use clap_complete::{Shell, generate};

use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf completions bash > ~/.local/share/bash-completion/completions/midsurf
  midsurf completions zsh > ~/.zfunc/_midsurf

Exit codes: 0 done, 2 wrong usage.";

/// Print completions for a shell
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

/// Writes the completions of all commands.
pub(crate) fn run(args: &Args, mut whole: Command) -> Result<ExitCode, Failure> {
    let mut text = Vec::new();
    generate(args.shell, &mut whole, "midsurf", &mut text);
    print(&text)
}

const MAN_EXAMPLES: &str = "\
Examples:
  midsurf man | man -l -
  midsurf man extract > midsurf-extract.1

Exit codes: 0 done, 2 wrong usage.";

/// Print the manual page of the program, or of a command
#[derive(clap::Args)]
#[command(after_help = MAN_EXAMPLES)]
pub(crate) struct ManArgs {
    /// The command
    command: Option<String>,
}

/// Writes a manual page.
pub(crate) fn man(args: &ManArgs, mut whole: Command) -> Result<ExitCode, Failure> {
    whole.build();
    let command = match &args.command {
        None => whole,
        Some(name) => match whole.find_subcommand(name) {
            Some(found) => found.clone(),
            None => {
                return Err(Failure::usage(
                    format!("there is no command {name}"),
                    "`midsurf --help` lists the commands",
                ));
            }
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text)?;
    print(&text)
}

pub(super) fn print(text: &[u8]) -> Result<ExitCode, Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text)?;
    out.flush()?;
    Ok(ExitCode::SUCCESS)
}
