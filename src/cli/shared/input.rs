//! What is said of what was read.

use midsurf::settings::warning::Warning;

use super::console::say;

/// Prints warnings to stderr.
pub(crate) fn print_warnings(warnings: &[Warning]) {
    for warning in warnings {
        say(format_args!("warning: {}", warning.message));
    }
}
