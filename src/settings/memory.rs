//! Memory asked for before it is taken: amounts as a user states them, what
//! the system still gives, and what this process took.

use std::fmt;
use std::str::FromStr;

use miette::Diagnostic;
use serde::{Serialize, Serializer};
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

/// An amount of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

/// Letters and how many times 1024 they stand for.
const UNITS: [(char, i32); 4] = [('K', 1), ('M', 2), ('G', 3), ('T', 4)];

impl FromStr for Bytes {
    type Err = String;

    /// Reads `8G`, `8GB`, `8GiB` (all 8 times 2^30), `512M`, or plain bytes.
    fn from_str(text: &str) -> Result<Bytes, String> {
        let upper = text.trim().to_ascii_uppercase();
        let bare = upper.strip_suffix('B').unwrap_or(&upper);
        let bare = bare.strip_suffix('I').unwrap_or(bare);
        let unit = UNITS.iter().find(|(letter, _)| bare.ends_with(*letter));
        let (number, power) = match unit {
            Some((_, power)) => (&bare[..bare.len() - 1], *power),
            None => (upper.strip_suffix('B').unwrap_or(&upper), 0),
        };
        match number.trim().parse::<f64>() {
            Ok(value) if value > 0.0 && value.is_finite() => {
                // Saturates, which is as good as no bound.
                Ok(Bytes((value * 1024f64.powi(power)) as u64))
            }
            _ => Err("expected an amount of memory as 512M or 8G".to_owned()),
        }
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (letter, power) in UNITS.into_iter().rev() {
            let unit = 1024f64.powi(power);
            if self.0 as f64 >= unit {
                let value = (self.0 as f64 / unit * 100.0).round() / 100.0;
                return write!(f, "{value}{letter}");
            }
        }
        write!(f, "{}", self.0)
    }
}

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u64(self.0)
    }
}

/// Most memory that this process ever held, where the system tells.
pub fn peak() -> Option<Bytes> {
    amount("/proc/self/status", "VmHWM:").map(Bytes)
}

/// Memory that the system still gives, where it tells: what is free, and what a
/// limit on this process's address space leaves.
pub fn available() -> Option<u64> {
    let free = amount("/proc/meminfo", "MemAvailable:");
    free.into_iter().chain(address_space()).min()
}

/// What a limit on this process's address space leaves, if there is one.
pub fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(amount("/proc/self/status", "VmSize:")?))
}

/// An amount in one of Linux's tables of `NAME: NUMBER kB`, in bytes.
fn amount(table: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(table).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::Bytes;

    #[test]
    fn amounts_are_read_and_printed() {
        for (text, bytes, shown) in [
            ("8G", 8 << 30, "8G"),
            ("8gib", 8 << 30, "8G"),
            ("1.5GB", 3 << 29, "1.5G"),
            ("512M", 512 << 20, "512M"),
            ("64k", 64 << 10, "64K"),
            ("1000", 1000, "1000"),
            ("1000 B", 1000, "1000"),
        ] {
            assert_eq!(text.parse(), Ok(Bytes(bytes)), "{text}");
            assert_eq!(Bytes(bytes).to_string(), shown);
        }
        for text in ["", "G", "0", "-1G", "nan", "8X", "8iG", "infG"] {
            assert!(text.parse::<Bytes>().is_err(), "{text}");
        }
    }
}
