//! Lines to stderr, and to the file of `--log-file`.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

use midsurf::io::quote::bounded;

/// The log, once it is opened: one of the process, as stderr is.
static LOG: OnceLock<(Instant, Mutex<File>)> = OnceLock::new();

/// Opens the log, in place of what the file held.
pub(crate) fn open_log(file: &Path) -> io::Result<()> {
    let file = File::create(file)?;
    // A second log is opened by nobody.
    let _ = LOG.set((Instant::now(), Mutex::new(file)));
    Ok(())
}

/// Writes lines to the log alone, with the seconds since it was opened.
pub(crate) fn log(text: &str) {
    let Some((start, file)) = LOG.get() else {
        return;
    };
    let seconds = start.elapsed().as_secs_f64();
    // A poisoned lock still holds a file; a full disk is no reason to stop.
    let mut file = file.lock().unwrap_or_else(|e| e.into_inner());
    for line in text.lines() {
        let _ = writeln!(file, "[{seconds:9.3}] {line}");
    }
}

/// Writes a line to stderr and the log, without what would move the terminal's
/// cursor; a closed stderr is nobody's concern.
pub(crate) fn say(line: std::fmt::Arguments<'_>) {
    let line = bounded(&line.to_string()).to_string();
    let _ = writeln!(io::stderr(), "{line}");
    log(&line);
}
