//! A progress bar, shown on a terminal only.

use std::io::{self, IsTerminal};
use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress of a long command; silent when stderr is no terminal or the user
/// wants quiet. Can be shared between threads.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// Stage shown, and whether its number of steps is known.
    shown: Mutex<(&'static str, bool)>,
}

impl Progress {
    /// A bar on stderr.
    pub(crate) fn new(quiet: bool) -> Progress {
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
        Progress {
            bar,
            shown: Mutex::new(("", false)),
        }
    }

    /// Shows a stage with `done` of `total` steps; zero when the number is not
    /// known. The total may grow as the work goes on.
    pub(crate) fn show(&self, stage: &'static str, done: u64, total: u64) {
        // A poisoned lock still holds a name.
        let mut shown = self.shown.lock().unwrap_or_else(|e| e.into_inner());
        if *shown != (stage, total > 0) {
            *shown = (stage, total > 0);
            let template = if total > 0 {
                "{spinner} {msg:<8} {bar:32} {human_pos} of {human_len}  {elapsed}"
            } else {
                "{spinner} {msg:<8} {elapsed}"
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                self.bar.set_style(style);
            }
            self.bar.set_message(stage);
        }
        self.bar.set_length(total);
        self.bar.set_position(done);
    }

    /// Prints to stderr beside the bar.
    pub(crate) fn aside(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }
}

impl Drop for Progress {
    /// Removes the bar.
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
