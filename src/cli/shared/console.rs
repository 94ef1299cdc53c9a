//! Lines to stderr, and to the file of `--log-file`; events of the library among them.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

use midsurf::settings::quote::bounded;
use tracing::Metadata;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::fmt::MakeWriter;

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

/// Tells what the library says of its stages: on stderr as often as `-v` was given,
/// in the log all.
pub(crate) fn trace(verbose: u8, logged: bool) {
    let shown = match verbose {
        0 => LevelFilter::OFF,
        1 => LevelFilter::INFO,
        _ => LevelFilter::DEBUG,
    };
    let all = if logged { LevelFilter::DEBUG } else { shown };
    // One a process: a second would say all twice.
    let _ = tracing_subscriber::fmt()
        .without_time()
        .with_ansi(false)
        .with_max_level(all)
        .with_writer(Events { shown })
        .try_init();
}

/// Where events go: to the log, and to stderr those that are to be shown.
struct Events {
    shown: LevelFilter,
}

impl<'a> MakeWriter<'a> for Events {
    type Writer = Lines;

    fn make_writer(&'a self) -> Lines {
        Lines { shown: false }
    }

    fn make_writer_for(&'a self, event: &Metadata<'_>) -> Lines {
        let shown = *event.level() <= self.shown;
        Lines { shown }
    }
}

/// A writer of whole lines.
struct Lines {
    shown: bool,
}

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let line = String::from_utf8_lossy(bytes);
        match self.shown {
            true => say(format_args!("{}", line.trim_end())),
            false => log(line.trim_end()),
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
