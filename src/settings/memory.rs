//! Memory asked for before it is taken.

use miette::Diagnostic;
use thiserror::Error;

/// Most memory that an engine's cells may take unless told otherwise, bytes.
pub const MEMORY_LIMIT: u64 = 8 << 30;

/// Cells so small that they would not fit into the memory allowed.
#[derive(Clone, Copy, Debug, PartialEq, Error, Diagnostic)]
#[error(
    "cell size {cell} needs about {cells:.0} active cells and {gigabytes:.1} GB; the smallest cell that fits is about {smallest:.4}"
)]
#[diagnostic(help("take a larger --cell; raise --memory-limit if the machine has more memory"))]
pub struct TooFine {
    /// Cell asked for.
    pub cell: f64,
    /// Active cells that it would need.
    pub cells: f64,
    /// Memory that they would take.
    pub gigabytes: f64,
    /// Smallest cell within the bound.
    pub smallest: f64,
}
