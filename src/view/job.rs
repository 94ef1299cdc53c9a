//! A long job whose answer is a stream: a line of JSON a few times a second while
//! it runs, and one when it is done. Whoever hangs up stops it.

use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde_json::{Value, json};

use super::http::Lines;
use super::session::Failed;
use crate::settings::progress::{Progress, Stop};

/// Between two lines: often enough to see that the reader has gone.
const BEAT: Duration = Duration::from_millis(150);

/// Runs `work` and tells `out` about it: `{"stage", "done", "of"}` while it runs, at
/// the end `{"result"}` or `{"error", "help"}`.
pub(super) fn stream(
    mut lines: Lines,
    work: impl FnOnce(&Progress, &Stop) -> Result<Value, Failed> + Send,
) {
    let stop = Stop::default();
    let at = Mutex::new(("start", 0, 0));
    let (done, finished) = channel();
    thread::scope(|scope| {
        let (stop, at) = (&stop, &at);
        let run = move || {
            let progress = |stage, done, expected| {
                if let Ok(mut at) = at.lock() {
                    *at = (stage, done, expected);
                }
            };
            let result = work(&progress, stop);
            // Nobody listens any more once the reader has gone.
            let _ = done.send(result);
        };
        // A thread refused drops the sender, which is told below as breaking off.
        let _ = thread::Builder::new().spawn_scoped(scope, run);
        loop {
            let (line, last) = match finished.recv_timeout(BEAT) {
                Err(RecvTimeoutError::Timeout) => {
                    let (stage, done, of) = at.lock().map_or(("", 0, 0), |at| *at);
                    (json!({ "stage": stage, "done": done, "of": of }), false)
                }
                Ok(Ok(result)) => (json!({ "result": result }), true),
                Ok(Err(failed)) => (
                    json!({ "error": failed.message, "help": failed.help }),
                    true,
                ),
                Err(RecvTimeoutError::Disconnected) => {
                    (json!({ "error": "the extraction broke off" }), true)
                }
            };
            let told = lines.send(&line.to_string());
            if told.is_err() {
                stop.ask();
            }
            if last || told.is_err() {
                return;
            }
        }
    });
}
