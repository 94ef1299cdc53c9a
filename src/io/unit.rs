//! Units of length that files and people name.

use std::fmt;
use std::str::FromStr;

use serde::{Serialize, Serializer};

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A millionth of a metre.
    Micron,
    /// A thousandth of a metre.
    Millimetre,
    /// A hundredth of a metre.
    Centimetre,
    /// 25.4 millimetres.
    Inch,
    /// Twelve inches.
    Foot,
    /// The metre.
    Metre,
}

impl Unit {
    /// All of them.
    pub const ALL: [Unit; 6] = [
        Unit::Micron,
        Unit::Millimetre,
        Unit::Centimetre,
        Unit::Inch,
        Unit::Foot,
        Unit::Metre,
    ];

    /// How many millimetres it has.
    pub fn millimetres(self) -> f64 {
        match self {
            Unit::Micron => 1e-3,
            Unit::Millimetre => 1.0,
            Unit::Centimetre => 10.0,
            Unit::Inch => 25.4,
            Unit::Foot => 304.8,
            Unit::Metre => 1000.0,
        }
    }

    /// Its sign, as [`FromStr`] reads it.
    pub fn sign(self) -> &'static str {
        match self {
            Unit::Micron => "um",
            Unit::Millimetre => "mm",
            Unit::Centimetre => "cm",
            Unit::Inch => "in",
            Unit::Foot => "ft",
            Unit::Metre => "m",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sign())
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Unit, String> {
        let found = Unit::ALL.into_iter().find(|unit| unit.sign() == text);
        found.ok_or_else(|| "expected um, mm, cm, m, in or ft".to_owned())
    }
}

impl Serialize for Unit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.sign())
    }
}
