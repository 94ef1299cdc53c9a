//! Lines to stderr.

use std::io::{self, Write};

/// Writes a line to stderr; a closed stderr is nobody's concern.
pub(crate) fn say(line: std::fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{line}");
}
