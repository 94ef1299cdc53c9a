//! How what takes long says where it is, and how it is asked to stop.

use std::sync::atomic::{AtomicBool, Ordering};

/// Stages as they begin, for progress displays: stage name, done and expected.
pub type Progress<'p> = dyn Fn(&'static str, u64, u64) + Sync + 'p;

/// A wish to stop, made by one thread and met by others.
///
/// Work that heeds it ends soon after with [`Stopped`] and no result.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

/// Work ended early, on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

impl Stop {
    /// Asks to stop; there is no way back.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// For the places of long work where it may end.
    ///
    /// # Errors
    ///
    /// [`Stopped`] once it was asked for.
    pub fn heed(&self) -> Result<(), Stopped> {
        if self.0.load(Ordering::Relaxed) {
            Err(Stopped)
        } else {
            Ok(())
        }
    }
}
