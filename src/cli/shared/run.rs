//! What all commands that compute have in common: threads, progress, and
//! output files, whose names are checked first and given at the end.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use midsurf::io::write::{Staged, WriteError, check_target, stage};
use serde_json::Value;

use super::config;
use super::console::{self, open_log};
use super::failure::Failure;
use super::pool;
use super::progress::{Progress, ProgressArg};

/// What a run may take, and what it says of itself.
#[derive(clap::Args)]
pub(crate) struct RunArgs {
    /// Write a report as JSON; `-` for stdout
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Threads to use; the result does not depend on it
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print errors and nothing else
    #[arg(short, long)]
    pub(crate) quiet: bool,
    /// Print more: what each stage gave as it ends, in place of a bar; twice for
    /// what was tried within
    #[arg(short, long, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    pub(crate) verbose: u8,
    /// How to tell where the work is
    #[arg(
        long,
        value_name = "HOW",
        value_enum,
        default_value_t,
        conflicts_with = "quiet"
    )]
    progress: ProgressArg,
    /// Write all that is said, and when each stage began, to this file too
    #[arg(long, value_name = "FILE")]
    log_file: Option<PathBuf>,
}

impl RunArgs {
    /// [`check_names`] of the outputs and the report.
    pub(crate) fn check_names(
        &self,
        inputs: &[(&Path, &'static str)],
        outputs: Vec<PathBuf>,
    ) -> Result<(), Failure> {
        let outputs = outputs.into_iter().map(|file| (file, "output"));
        let report = self.json_file().map(|file| (file.to_owned(), "report"));
        let log = self.log_file.clone().map(|file| (file, "log"));
        check_names(inputs, outputs.chain(report).chain(log))
    }

    /// Opens the log and sets the number of threads, before anything runs; what runs
    /// first is reading.
    pub(crate) fn start(&self) -> Result<Progress, Failure> {
        if let Some(file) = &self.log_file {
            open_log(file).map_err(|source| {
                let file = file.clone();
                Failure::input(WriteError::Io { file, source })
            })?;
        }
        console::trace(self.verbose, self.log_file.is_some());
        pool::start(self.threads);
        let progress = Progress::new(self.progress, self.quiet || self.verbose > 0);
        progress.show("reading", 0, 0);
        Ok(progress)
    }

    /// The report's file, unless it goes to stdout.
    fn json_file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|file| *file != Path::new("-"))
    }

    /// Whether the report goes to stdout.
    pub(crate) fn reports_to_stdout(&self) -> bool {
        self.json.is_some() && self.json_file().is_none()
    }

    /// Adds the report, then gives all files their names, so that either all
    /// or none appear as far as one process can see to it.
    pub(crate) fn finish(&self, mut staged: Vec<Staged>, report: &Value) -> Result<(), Failure> {
        if let Some(file) = self.json_file() {
            let write = |out: &mut dyn Write| writeln!(out, "{report:#}");
            staged.push(stage(file, write).map_err(Failure::output)?);
        }
        for file in staged {
            file.commit().map_err(Failure::output)?;
        }
        if self.reports_to_stdout() {
            let mut out = io::stdout().lock();
            writeln!(out, "{report:#}")?;
            out.flush()?;
        }
        Ok(())
    }
}

/// Refuses an output whose name does not end in one of the suffixes, which are
/// given as a message lists them: `.ply, .vtu`.
pub(crate) fn check_suffix(file: &Path, known: &'static str) -> Result<(), Failure> {
    let suffix = file.extension().map(|suffix| suffix.to_ascii_lowercase());
    let fits = |name: &str| {
        let name = name.trim_start_matches('.');
        suffix.as_ref().is_some_and(|suffix| suffix == name)
    };
    if known.split(", ").any(fits) {
        return Ok(());
    }
    Err(Failure::input(WriteError::UnknownFormat {
        file: file.to_owned(),
        known,
    }))
}

/// Refuses outputs that could not be written, or that would overwrite an input
/// or each other, before any work is done. All come with their role.
pub(crate) fn check_names(
    inputs: &[(&Path, &'static str)],
    outputs: impl IntoIterator<Item = (PathBuf, &'static str)>,
) -> Result<(), Failure> {
    let mut named: Vec<(PathBuf, &'static str)> = inputs
        .iter()
        .map(|&(file, role)| (file.to_owned(), role))
        .chain(config::file().map(|file| (file.to_owned(), "config")))
        .collect();
    for (file, role) in outputs {
        check_target(&file).map_err(Failure::input)?;
        if let Some((_, first)) = named.iter().find(|(other, _)| are_one(other, &file)) {
            return Err(Failure::input(WriteError::NamedTwice {
                file,
                first,
                second: role,
            }));
        }
        named.push((file, role));
    }
    Ok(())
}

/// Whether two names are of one file, links of either kind followed.
fn are_one(a: &Path, b: &Path) -> bool {
    identity(a) == identity(b) || same_file::is_same_file(a, b).unwrap_or(false)
}

/// A name by which equal files are equal, also where there is none yet.
fn identity(file: &Path) -> PathBuf {
    if let Ok(whole) = file.canonicalize() {
        return whole;
    }
    let folder = match file.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), file.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => file.to_owned(),
    }
}
