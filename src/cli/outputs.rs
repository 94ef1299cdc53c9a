//! Output files of a command: names checked first, all named at the end.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use midsurf::io::write::{Staged, WriteError, check_target, stage};
use serde_json::Value;

use super::failure::Failure;

/// Sets the number of threads, before anything runs.
pub(super) fn use_threads(threads: Option<u16>) {
    if let Some(threads) = threads {
        // Fails only if the pool exists already; nothing ran before this.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(usize::from(threads))
            .build_global();
    }
}

/// Refuses outputs that could not be written, or that would overwrite an
/// input or each other, before any work is done. Inputs come with their role.
pub(super) fn check_names(
    inputs: &[(&Path, &'static str)],
    outputs: Vec<PathBuf>,
    json: Option<&Path>,
) -> Result<(), Failure> {
    let mut named: Vec<(PathBuf, &'static str)> = inputs
        .iter()
        .map(|&(file, role)| (file.to_owned(), role))
        .collect();
    let mut outputs: Vec<(PathBuf, &'static str)> =
        outputs.into_iter().map(|file| (file, "output")).collect();
    outputs.extend(json_file(json).map(|file| (file.to_owned(), "report")));
    for (file, role) in outputs {
        check_target(&file).map_err(Failure::input)?;
        if let Some((_, first)) = named
            .iter()
            .find(|(other, _)| identity(other) == identity(&file))
        {
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

/// The report's file, unless it goes to stdout.
fn json_file(json: Option<&Path>) -> Option<&Path> {
    json.filter(|file| *file != Path::new("-"))
}

/// Whether the report goes to stdout.
pub(super) fn to_stdout(json: Option<&Path>) -> bool {
    json.is_some() && json_file(json).is_none()
}

/// A name by which equal files are equal.
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

/// Adds the report, then gives all files their names, so that either all or
/// none appear as far as one process can see to it.
pub(super) fn finish(
    json: Option<&Path>,
    mut staged: Vec<Staged>,
    report: &Value,
) -> Result<(), Failure> {
    if let Some(file) = json_file(json) {
        let write = |out: &mut dyn Write| writeln!(out, "{report:#}");
        staged.push(stage(file, write).map_err(Failure::output)?);
    }
    for file in staged {
        file.commit().map_err(Failure::output)?;
    }
    if to_stdout(json) {
        let mut out = io::stdout().lock();
        writeln!(out, "{report:#}")?;
        out.flush()?;
    }
    Ok(())
}
