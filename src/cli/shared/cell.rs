//! The cell size as a user states it.

use std::fmt;
use std::str::FromStr;

use midsurf::extract::Cell;
use serde::{Serialize, Serializer};

/// A cell size from the command line, absolute or relative to the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellSize(pub(crate) Cell);

impl FromStr for CellSize {
    type Err = String;

    fn from_str(text: &str) -> Result<CellSize, String> {
        let text = text.trim();
        if text.eq_ignore_ascii_case("auto") {
            return Ok(CellSize(Cell::Auto));
        }
        let (number, make): (&str, fn(f64) -> Cell) =
            if let Some(number) = text.strip_suffix(['t', 'T']) {
                (number, Cell::Thicknesses)
            } else if let Some(number) = text.strip_suffix('%') {
                (number, Cell::Percent)
            } else {
                (text, Cell::Length)
            };
        match number.trim().parse::<f64>() {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(CellSize(make(value))),
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
        match self.0 {
            Cell::Auto => write!(f, "auto"),
            Cell::Length(value) => write!(f, "{value}"),
            Cell::Thicknesses(value) => write!(f, "{value}t"),
            Cell::Percent(value) => write!(f, "{value}%"),
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
    use super::{Cell, CellSize};

    #[test]
    fn what_is_printed_can_be_read() {
        for (text, size) in [
            ("auto", Cell::Auto),
            ("1.5", Cell::Length(1.5)),
            ("0.5t", Cell::Thicknesses(0.5)),
            ("2%", Cell::Percent(2.0)),
        ] {
            assert_eq!(text.parse(), Ok(CellSize(size)));
            assert_eq!(CellSize(size).to_string(), text);
        }
        for text in ["", "0", "-1", "nan", "inf", "1mm", "t", "%", "0t"] {
            assert!(text.parse::<CellSize>().is_err(), "{text}");
        }
    }
}
