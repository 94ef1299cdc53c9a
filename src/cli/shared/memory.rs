//! Amounts of memory: as a user states them, and what the process took.

use std::fmt;
use std::str::FromStr;

use serde::{Serialize, Serializer};

/// An amount of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bytes(pub(crate) u64);

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

/// Most memory that this process ever held, where the system tells: the
/// `VmHWM` line of `/proc/self/status` on Linux.
pub(crate) fn peak() -> Option<Bytes> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(Bytes(kibibytes * 1024))
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
