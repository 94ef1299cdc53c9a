//! The cell size: as a user states it, and as a length.

use std::fmt;
use std::str::FromStr;

use miette::Diagnostic;
use serde::{Serialize, Serializer};
use thiserror::Error;

/// Cells along the side of a square of the area of a surface that becomes a
/// solid, at least: one that is no larger than its thickness has features that
/// are smaller.
pub(crate) const CELLS_ALONG: f64 = 32.0;

/// Edge length of a cell, absolute or relative to what is meshed.
///
/// Read from and shown as `auto`, `1.5`, `0.5t` or `1%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CellSize {
    /// What the engine thinks right.
    Auto,
    /// A length in part units.
    Length(f64),
    /// So many wall thicknesses.
    Thicknesses(f64),
    /// So many hundredths of the bounding box's diagonal.
    Percent(f64),
}

/// What relative cell sizes are relative to, part units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The cell for [`CellSize::Auto`]; none where it hangs on a thickness
    /// that is unknown.
    pub auto: Option<f64>,
    /// The wall thickness, usually the median; none where there is no such.
    pub thickness: Option<f64>,
    /// Diagonal of the bounding box.
    pub diagonal: f64,
}

/// Why a cell size is no length.
#[derive(Clone, Copy, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum BadCell {
    /// Zero, negative, infinite or no number.
    #[error("cell size {0} is not a positive length")]
    #[diagnostic(help("give --cell a positive length, or leave it away"))]
    NotPositive(f64),
    /// Stated in wall thicknesses, and there is no such.
    #[error("a cell size in wall thicknesses means nothing here: no thickness is known")]
    #[diagnostic(help("give --cell a length, or a share of the diagonal as 0.5%"))]
    NoThickness,
}

impl CellSize {
    /// The cell as a length, part units; that for [`CellSize::Auto`] is passed
    /// on as it is.
    ///
    /// # Errors
    ///
    /// [`BadCell`] where the length is not positive and finite, or the thickness
    /// that it is relative to is unknown.
    pub fn resolve(self, scale: &Scale) -> Result<f64, BadCell> {
        let thickness = scale.thickness.ok_or(BadCell::NoThickness);
        match self {
            CellSize::Auto => scale.auto.ok_or(BadCell::NoThickness),
            CellSize::Length(length) => check(length),
            CellSize::Thicknesses(factor) => check(factor * thickness?),
            CellSize::Percent(percent) => check(0.01 * percent * scale.diagonal),
        }
    }
}

/// Passes a cell on that is a positive length.
///
/// # Errors
///
/// [`BadCell::NotPositive`].
pub fn check(cell: f64) -> Result<f64, BadCell> {
    if cell > 0.0 && cell.is_finite() {
        Ok(cell)
    } else {
        Err(BadCell::NotPositive(cell))
    }
}

impl FromStr for CellSize {
    type Err = String;

    fn from_str(text: &str) -> Result<CellSize, String> {
        let text = text.trim();
        if text.eq_ignore_ascii_case("auto") {
            return Ok(CellSize::Auto);
        }
        let (number, make): (&str, fn(f64) -> CellSize) =
            if let Some(number) = text.strip_suffix(['t', 'T']) {
                (number, CellSize::Thicknesses)
            } else if let Some(number) = text.strip_suffix('%') {
                (number, CellSize::Percent)
            } else {
                (text, CellSize::Length)
            };
        match number.trim().parse::<f64>() {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(make(value)),
            Ok(_) => Err("the cell size must be positive and finite".to_owned()),
            Err(_) => Err(
                "expected a length as 1.5, wall thicknesses as 0.5t, a share of the diagonal as 1%, or auto"
                    .to_owned(),
            ),
        }
    }
}

impl fmt::Display for CellSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CellSize::Auto => write!(f, "auto"),
            CellSize::Length(value) => write!(f, "{value}"),
            CellSize::Thicknesses(value) => write!(f, "{value}t"),
            CellSize::Percent(value) => write!(f, "{value}%"),
        }
    }
}

impl Serialize for CellSize {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::{BadCell, CellSize, Scale};

    #[test]
    fn what_is_printed_can_be_read() {
        for (text, size) in [
            ("auto", CellSize::Auto),
            ("1.5", CellSize::Length(1.5)),
            ("0.5t", CellSize::Thicknesses(0.5)),
            ("2%", CellSize::Percent(2.0)),
        ] {
            assert_eq!(text.parse(), Ok(size));
            assert_eq!(size.to_string(), text);
        }
        for text in ["", "0", "-1", "nan", "inf", "1mm", "t", "%", "0t"] {
            assert!(text.parse::<CellSize>().is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_become_lengths() {
        let scale = Scale {
            auto: Some(3.0),
            thickness: Some(4.0),
            diagonal: 500.0,
        };
        for (size, length) in [
            (CellSize::Auto, 3.0),
            (CellSize::Length(1.5), 1.5),
            (CellSize::Thicknesses(0.5), 2.0),
            (CellSize::Percent(2.0), 10.0),
        ] {
            assert_eq!(size.resolve(&scale), Ok(length));
        }
        let bare = Scale {
            auto: None,
            thickness: None,
            diagonal: 500.0,
        };
        for size in [CellSize::Auto, CellSize::Thicknesses(1.0)] {
            assert_eq!(size.resolve(&bare), Err(BadCell::NoThickness));
        }
        let over = CellSize::Thicknesses(f64::MAX).resolve(&scale);
        assert_eq!(over, Err(BadCell::NotPositive(f64::INFINITY)));
        assert!(CellSize::Length(f64::NAN).resolve(&scale).is_err());
    }
}
