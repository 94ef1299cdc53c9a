//! The report that every command gives of a run: one envelope, and in it what
//! the command has to tell.

use std::path::Path;

use serde_json::{Value, json};

use super::config;
use super::memory::peak;
use super::warning::Warning;

/// Version of the report's layout; raised when a reader must change.
const SCHEMA: u32 = 1;

/// What all reports hold.
pub(crate) struct Envelope<'a> {
    pub(crate) command: &'a str,
    /// Files read, and what they hold.
    pub(crate) input: Value,
    /// Settings as given and as resolved; the number of threads is added.
    pub(crate) settings: Value,
    /// Wall-clock seconds, by stage.
    pub(crate) seconds: Value,
    pub(crate) outputs: Vec<&'a Path>,
    pub(crate) warnings: Vec<&'a Warning>,
}

/// A path for reports; what is no Unicode in it is replaced.
pub(crate) fn named(file: &Path) -> String {
    file.to_string_lossy().into_owned()
}

impl Envelope<'_> {
    /// The report, with the members of `results`, an object, beside the
    /// envelope's.
    pub(crate) fn around(mut self, results: Value) -> Value {
        if let Value::Object(settings) = &mut self.settings {
            settings.insert("threads".into(), rayon::current_num_threads().into());
        }
        let mut report = json!({
            "schema": SCHEMA,
            "tool": {
                "name": "midsurf",
                "version": env!("CARGO_PKG_VERSION"),
                "command": self.command,
            },
            "input": self.input,
            "settings": self.settings,
            "config": config::told(),
            "seconds": self.seconds,
            "peak_memory": peak(),
            "outputs": self.outputs.into_iter().map(named).collect::<Vec<_>>(),
            "warnings": self.warnings,
        });
        if let (Value::Object(report), Value::Object(results)) = (&mut report, results) {
            report.extend(results);
        }
        report
    }
}
