//! `midsurf schema`: what reports and tag files look like, as JSON Schema.

use std::process::ExitCode;

use super::completions::print;
use crate::cli::shared::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  midsurf schema report > report.schema.json
  midsurf schema tags > tags.schema.json

A tag file in TOML has the schema once it is read into the same tables, lists and
values as JSON has.

Exit codes: 0 done, 2 wrong usage.";

/// Print the JSON Schema of reports or of tag files
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Of what
    #[arg(value_enum)]
    of: Of,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Of {
    /// What --json writes
    Report,
    /// Coping tags in TOML
    Tags,
}

pub(crate) fn run(args: &Args) -> Result<ExitCode, Failure> {
    print(match args.of {
        Of::Report => include_bytes!("schema/report.json"),
        Of::Tags => include_bytes!("schema/tags.json"),
    })
}
