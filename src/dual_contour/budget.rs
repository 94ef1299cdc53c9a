//! A grid that fits: memory asked before it is taken.

use miette::Diagnostic;
use thiserror::Error;

use super::grid::Grid;
use super::numbers::Numbers;
use crate::mesh::Bounds;
use crate::settings::memory::TooFine;
use crate::settings::precision::Precision;

/// Bytes that an active cell takes at the peak, measured; for the memory bound.
const BYTES_PER_CELL: f64 = 400.0;

/// Bytes that a node whose distance is known takes, where they fill a volume.
const BYTES_PER_NODE: f64 = 8.0;

/// Active cells for a surface as large as a cell's face: those that a plane
/// meets, over all directions.
const CELLS_PER_FACE: f64 = 2.0;

/// Why there is no grid.
#[derive(Clone, Copy, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum GridError {
    /// The grid would not fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    TooFine(#[from] TooFine),
    /// More cells along an axis than the grid can count, or planes that the
    /// numbers allowed cannot tell apart.
    #[error(
        "cell size {cell} is too small for a box of {size:.6} at {far:.6} from the origin; use a larger cell{hint}"
    )]
    #[diagnostic(help("move it nearer to the origin; take a larger --cell"))]
    NoGrid {
        /// Cell asked for.
        cell: f64,
        /// Longest side of the box around the surface.
        size: f64,
        /// Greatest coordinate.
        far: f64,
        /// What else helps.
        hint: &'static str,
    },
}

/// The smallest cell for a surface of this area within so many bytes.
pub fn smallest_cell(area: f64, memory_limit: u64) -> f64 {
    (CELLS_PER_FACE * area * BYTES_PER_CELL / memory_limit as f64).sqrt()
}

impl Grid {
    /// A grid around `bounds` for a surface of about this area.
    ///
    /// # Errors
    ///
    /// [`GridError`].
    pub fn within(
        bounds: &Bounds,
        area: f64,
        cell: f64,
        numbers: impl Into<Numbers>,
        memory_limit: u64,
    ) -> Result<Grid, GridError> {
        Grid::within_filled(bounds, area, 0.0, cell, numbers, memory_limit)
    }

    /// The same where the distance is asked at all nodes in about this volume,
    /// too many to be passed over beside the cells at the surface.
    ///
    /// # Errors
    ///
    /// [`GridError`].
    pub fn within_filled(
        bounds: &Bounds,
        area: f64,
        volume: f64,
        cell: f64,
        numbers: impl Into<Numbers>,
        memory_limit: u64,
    ) -> Result<Grid, GridError> {
        let cells = CELLS_PER_FACE * area / (cell * cell);
        let bytes = cells * BYTES_PER_CELL + volume / cell.powi(3) * BYTES_PER_NODE;
        if bytes > memory_limit as f64 {
            return Err(GridError::TooFine(TooFine {
                cell,
                cells,
                gigabytes: bytes / 1e9,
                // Fits that area and volume, and is exact where only one of the
                // two counts.
                smallest: smallest_cell(area, memory_limit)
                    + (volume * BYTES_PER_NODE / memory_limit as f64).cbrt(),
            }));
        }
        let numbers = numbers.into();
        let world = [bounds.min, bounds.max].map(|p| numbers.frame().to_world(p));
        let far = world[0].abs().max(world[1].abs()).max_element();
        Grid::around(bounds, cell, numbers).ok_or(GridError::NoGrid {
            cell,
            size: bounds.size().max_element(),
            far,
            hint: match numbers.precision() {
                Precision::Single => ", or a format of double precision such as .obj",
                Precision::Double => "",
            },
        })
    }
}
