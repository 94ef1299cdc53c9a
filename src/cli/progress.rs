//! A progress bar, shown on a terminal only.

use std::io::{self, IsTerminal};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress of a long command; silent when stderr is no terminal or the user
/// wants quiet. Can be shared between threads.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on stderr.
    pub(super) fn new(quiet: bool) -> Progress {
        let visible = !quiet && io::stderr().is_terminal();
        let target = if visible {
            ProgressDrawTarget::stderr_with_hz(10)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        if visible {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        Progress { bar }
    }

    /// Begins a stage of `total` steps; zero when the number is not known.
    pub(super) fn stage(&self, name: &'static str, total: u64) {
        let template = if total > 0 {
            "{spinner} {msg:<24} {bar:32} {percent:>3} %  {elapsed}"
        } else {
            "{spinner} {msg:<24} {elapsed}"
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style);
        }
        self.bar.set_position(0);
        self.bar.set_length(total);
        self.bar.set_message(name);
    }

    /// Prints to stderr beside the bar.
    pub(super) fn aside(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// Some steps of the stage are done.
    #[expect(dead_code, reason = "for stages with a known number of steps")]
    pub(super) fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }
}

impl Drop for Progress {
    /// Removes the bar.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
