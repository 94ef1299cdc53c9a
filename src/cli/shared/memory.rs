//! The flag that bounds memory.

use midsurf::settings::memory::{Bytes, available};

/// Bound on the memory that cells take.
#[derive(clap::Args)]
pub(crate) struct MemoryArgs {
    /// Refuse cells so small that they would need more memory than this
    #[arg(
        long,
        value_name = "SIZE",
        default_value = "8G",
        allow_negative_numbers = true
    )]
    pub(crate) memory_limit: Bytes,
}

impl MemoryArgs {
    /// The bound, or what the system still gives where that is less.
    pub(crate) fn allowed(&self) -> u64 {
        self.memory_limit.0.min(available().unwrap_or(u64::MAX))
    }
}
