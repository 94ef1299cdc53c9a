//! Where a long command is: a bar on a terminal, or lines of JSON.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use midsurf::settings::quote::figure;
use serde_json::json;

use super::console::log;

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ProgressArg {
    /// A bar, if stderr is a terminal
    #[default]
    Auto,
    /// A line of JSON on stderr for each stage, and ten a second within: `stage`,
    /// `done`, `total` (0 where it is not known) and `seconds`
    Json,
    /// Not at all
    None,
}

/// Time between lines of one stage.
const BETWEEN: Duration = Duration::from_millis(100);

/// Progress of a long command. Can be shared between threads.
pub(crate) struct Progress {
    bar: ProgressBar,
    json: bool,
    start: Instant,
    shown: Mutex<Shown>,
}

/// What was told last.
struct Shown {
    stage: &'static str,
    /// When that began.
    began: Instant,
    /// Whether the stage's number of steps is known.
    counted: bool,
    at: Option<Instant>,
}

impl Shown {
    /// Tells what the stage took.
    fn end(&self) {
        if !self.stage.is_empty() {
            let seconds = figure((1e3 * self.began.elapsed().as_secs_f64()).round() / 1e3);
            tracing::info!(target: "midsurf", "{} took {seconds} s", self.stage);
        }
    }
}

impl Progress {
    /// Silent where the user wants quiet.
    pub(crate) fn new(how: ProgressArg, quiet: bool) -> Progress {
        let visible = how == ProgressArg::Auto && !quiet && io::stderr().is_terminal();
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
            json: how == ProgressArg::Json,
            start: Instant::now(),
            shown: Mutex::new(Shown {
                stage: "",
                began: Instant::now(),
                counted: false,
                at: None,
            }),
        }
    }

    /// Shows a stage with `done` of `total` steps; zero when the number is not
    /// known. The total may grow as the work goes on.
    pub(crate) fn show(&self, stage: &'static str, done: u64, total: u64) {
        // A poisoned lock still holds a name.
        let mut shown = self.shown.lock().unwrap_or_else(|e| e.into_inner());
        let counted = total > 0;
        let new = shown.stage != stage;
        if new {
            log(stage);
            shown.end();
            shown.began = Instant::now();
        }
        if self.json && (new || shown.at.is_none_or(|at| at.elapsed() >= BETWEEN)) {
            self.tell(stage, done, total);
            shown.at = Some(Instant::now());
        }
        if new || shown.counted != counted {
            (shown.stage, shown.counted) = (stage, counted);
            let template = if counted {
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

    fn tell(&self, stage: &str, done: u64, total: u64) {
        let seconds = self.start.elapsed().as_secs_f64();
        let line = json!({ "stage": stage, "done": done, "total": total, "seconds": seconds });
        let _ = writeln!(io::stderr(), "{line}");
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
        self.shown.lock().unwrap_or_else(|e| e.into_inner()).end();
        if self.json {
            self.tell("end", 0, 0);
        }
    }
}
