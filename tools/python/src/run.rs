//! Long work outside the interpreter's lock, on threads of its own.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use midsurf::settings::progress::{Progress, Stop};
use pyo3::prelude::*;

use crate::fault;

/// Between two looks for Ctrl-C, and between two words on one stage.
const TICK: Duration = Duration::from_millis(50);

/// Bytes of a thread's stack, as a main thread has them.
const STACK: usize = 8 << 20;

/// A stage, steps done, steps expected.
type Step = (&'static str, u64, u64);

/// Runs work on as many threads as asked for, by default one a processor.
///
/// Meanwhile the calling thread hands on progress and looks for signals; an
/// exception out of either asks the work to stop, and is raised once it did.
/// What the work itself returns is passed on.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Progress<'_>, &Stop) -> T + Send,
) -> PyResult<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .stack_size(STACK)
        .build()
        .map_err(|error| no_threads(&error))?;
    let stop = Stop::default();
    let (tell, told) = channel::<Step>();
    py.detach(move || {
        thread::scope(|scope| {
            let stop = &stop;
            let work = move || {
                let show = |stage, done, expected| {
                    // The listener goes last.
                    let _ = tell.send((stage, done, expected));
                };
                pool.install(|| work(&show, stop))
            };
            let worker = Builder::new()
                .stack_size(STACK)
                .spawn_scoped(scope, work)
                .map_err(|error| no_threads(&error))?;
            let interrupted = listen(&told, progress.as_ref(), stop);
            let result = match worker.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            };
            interrupted.map(|()| result)
        })
    })
}

/// Hands progress on until the work is over.
fn listen(told: &Receiver<Step>, progress: Option<&Py<PyAny>>, stop: &Stop) -> PyResult<()> {
    let mut shown = "";
    let mut interrupted = Ok(());
    loop {
        let deadline = Instant::now() + TICK;
        let mut news: Vec<Step> = Vec::new();
        let over = loop {
            match told.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(step) => {
                    // Of one stage the last word counts.
                    match news.last_mut() {
                        Some(last) if last.0 == step.0 => *last = step,
                        _ => news.push(step),
                    }
                    if step.0 != shown {
                        shown = step.0;
                        break false;
                    }
                }
                Err(RecvTimeoutError::Timeout) => break false,
                Err(RecvTimeoutError::Disconnected) => break true,
            }
        };
        if interrupted.is_ok() {
            interrupted = Python::attach(|py| {
                py.check_signals()?;
                let Some(progress) = progress else {
                    return Ok(());
                };
                news.into_iter()
                    .try_for_each(|step| progress.call1(py, step).map(drop))
            });
            if interrupted.is_err() {
                stop.ask();
            }
        }
        if over {
            return interrupted;
        }
    }
}

fn no_threads(error: &dyn std::fmt::Display) -> PyErr {
    fault::no_result(
        format!("the system gives no threads: {error}"),
        Some("ask for fewer threads, or for less elsewhere".to_owned()),
    )
}
