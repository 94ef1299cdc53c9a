//! The allocator of the command, and the end of a run that gets no memory.
//!
//! Where an allocator gives nothing, Rust aborts the process (signal 6), with
//! whatever it was writing left behind. Nothing but the allocator itself can end it
//! otherwise: all that grows, here and in dependencies, comes by this place.

// An allocator is an unsafe trait.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout};
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use midsurf::io::write::abandon;
use mimalloc::MiMalloc;

/// Exit code where there is no usable result.
const NO_RESULT: i32 = 4;

/// Many small lists are made and dropped by all threads; measured, mimalloc takes a
/// tenth off the time of an extraction.
pub(crate) struct Allocator;

// SAFETY: all calls are passed on to an allocator that keeps the contract; a null
// pointer, which callers must expect, is not returned but ends the process.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are passed on.
        given(unsafe { MiMalloc.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { MiMalloc.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { MiMalloc.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { MiMalloc.dealloc(block, layout) }
    }
}

fn given(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() {
        end(size);
    }
    block
}

/// Thread that ends the process: an address that no two threads share.
static ENDING: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static OWN: u8 = const { 0 };
}

/// Says so, removes files that were being written, and ends the process.
#[cold]
fn end(size: usize) -> ! {
    let own = OWN.with(|own| std::ptr::from_ref(own) as usize);
    match ENDING.compare_exchange(0, own, Ordering::SeqCst, Ordering::SeqCst) {
        Ok(_) => {}
        // What ends the process needed memory itself.
        Err(thread) if thread == own => std::process::abort(),
        Err(_) => loop {
            std::thread::park();
        },
    }
    // Standard error has no buffer of its own.
    let _ = writeln!(
        std::io::stderr(),
        "Error: out of memory: {size} bytes more were not to be had\n  help: take a machine with more memory, a coarser mesh, or a larger --cell"
    );
    abandon(|| std::process::exit(NO_RESULT));
    std::process::exit(NO_RESULT)
}
