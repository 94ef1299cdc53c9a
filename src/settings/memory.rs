//! Memory asked for before it is taken.

use thiserror::Error;

/// Cells so small that they would not fit into the memory allowed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "cell size {cell} needs about {cells:.0} active cells and {gigabytes:.1} GB; the smallest cell that fits is about {smallest:.4}"
)]
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
