//! The bytes of a file, within bounds.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::io::error::{Located, Place, Problem};

/// Most bytes of an input file unless told otherwise.
pub const MAX_INPUT: u64 = 8 << 30;

static MOST: AtomicU64 = AtomicU64::new(MAX_INPUT);

/// Sets the most bytes that any input file of this process may have; by default
/// [`MAX_INPUT`].
pub fn limit_input(bytes: u64) {
    MOST.store(bytes, Ordering::Relaxed);
}

/// Reads a file whole; devices and pipes, which may never end, as far as the
/// bound.
///
/// # Errors
///
/// [`Problem`]; what passes the bound is not taken into memory beyond it.
pub(crate) fn read_bytes(file: &Path) -> Result<Vec<u8>, Problem> {
    let most = MOST.load(Ordering::Relaxed);
    let mut source = File::open(file).map_err(Problem::Io)?;
    let meta = source.metadata().map_err(Problem::Io)?;
    if meta.is_dir() {
        return Err(Problem::NotAFile);
    }
    let too_large = || Problem::TooLarge { most };
    if meta.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let expected = usize::try_from(meta.len()).unwrap_or(usize::MAX);
    (bytes.try_reserve_exact(expected)).map_err(|_| Problem::Memory { bytes: meta.len() })?;
    let read = source.by_ref().take(most.saturating_add(1));
    match { read }.read_to_end(&mut bytes) {
        Ok(_) if bytes.len() as u64 > most => Err(too_large()),
        Ok(_) => Ok(bytes),
        Err(error) if error.kind() == io::ErrorKind::OutOfMemory => Err(Problem::Memory {
            bytes: bytes.len() as u64,
        }),
        Err(error) => Err(Problem::Io(error)),
    }
}

/// Makes room for so many more items, or says that there is none.
///
/// # Errors
///
/// [`Problem::Memory`].
pub(crate) fn room<T>(list: &mut Vec<T>, more: usize) -> Result<(), Located> {
    let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
    (list.try_reserve(more)).map_err(|_| (Place::Whole, Problem::Memory { bytes }))
}
