//! The cell size as a user states it.

use std::fmt;
use std::str::FromStr;

use midsurf::extract::Cell;
use serde::{Serialize, Serializer};

/// Edge length of the lattice cells, absolute or relative to the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CellSize {
    /// The median wall thickness.
    Auto,
    /// Part units.
    Length(f64),
    /// Multiples of the median wall thickness.
    Thicknesses(f64),
    /// Per cent of the bounding box' diagonal.
    Percent(f64),
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

impl From<CellSize> for Cell {
    fn from(size: CellSize) -> Cell {
        match size {
            CellSize::Auto => Cell::Auto,
            CellSize::Length(length) => Cell::Length(length),
            CellSize::Thicknesses(factor) => Cell::Thicknesses(factor),
            CellSize::Percent(percent) => Cell::Percent(percent),
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
    use super::CellSize;

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
}
