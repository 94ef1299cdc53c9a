//! The threads that all work shares.

use std::sync::mpsc;
use std::thread;

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use midsurf::settings::memory::address_space;

use super::console::say;

/// Bytes of a thread's stack, as a main thread has them.
const STACK: usize = 8 << 20;

/// Bytes of address space a thread: its stack, and what the allocator keeps for
/// it. A thread that finds no room as it begins ends the process.
const ROOM: u64 = 64 << 20;

/// Starts as many threads as asked for, or as there are processors, before
/// anything else runs; as many as the system gives, if those are fewer.
///
/// The pool itself gives up for good when one of its threads cannot be had. So
/// they are started first and wait for what it wants of them.
pub(crate) fn start(asked: Option<u16>) {
    let wanted = match asked {
        Some(count) => usize::from(count),
        None => usual(),
    };
    let room = address_space().map_or(u64::MAX, |left| left / ROOM);
    let mut threads = Vec::new();
    for _ in 0..wanted.min(usize::try_from(room).unwrap_or(wanted)) {
        let (give, take) = mpsc::channel::<ThreadBuilder>();
        let work = move || {
            if let Ok(thread) = take.recv() {
                thread.run();
            }
        };
        match thread::Builder::new().stack_size(STACK).spawn(work) {
            Ok(_) => threads.push(give),
            Err(_) => break,
        }
    }
    let builder = ThreadPoolBuilder::new();
    if threads.len() < wanted {
        // Others may want some too.
        threads.truncate(threads.len().div_ceil(2));
        let count = threads.len().max(1);
        say(format_args!(
            "warning: the system gives fewer than {wanted} threads: {count} are used"
        ));
    }
    // Fails only if the pool exists already; nothing ran before this.
    let _ = if threads.is_empty() {
        builder.num_threads(1).use_current_thread().build_global()
    } else {
        let count = threads.len();
        let mut threads = threads.into_iter();
        builder
            .num_threads(count)
            .spawn_handler(|thread| {
                let give = threads.next().ok_or(std::io::ErrorKind::WouldBlock)?;
                (give.send(thread)).map_err(|_| std::io::ErrorKind::BrokenPipe.into())
            })
            .build_global()
    };
}

/// What `RAYON_NUM_THREADS` says, or the number of processors.
fn usual() -> usize {
    let told = std::env::var("RAYON_NUM_THREADS").ok();
    let told = told.and_then(|text| text.parse().ok()).filter(|&n| n > 0);
    let processors = || thread::available_parallelism().map_or(1, usize::from);
    told.map_or_else(processors, |count: usize| count.min(1024))
}
