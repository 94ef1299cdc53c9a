//! Lines to stderr.

use std::io::{self, Write};

use midsurf::io::quote::bounded;

/// Writes a line to stderr, without what would move the terminal's cursor; a
/// closed stderr is nobody's concern.
pub(crate) fn say(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{}", bounded(&line.to_string()));
}
