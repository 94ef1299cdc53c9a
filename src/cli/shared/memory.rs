//! Amounts of memory: as a user states them, and what the process took.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use midsurf::io::quote::shown_path;
use serde::{Serialize, Serializer};

use super::failure::Failure;

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

impl MemoryArgs {
    /// The bound, or what the system still gives where that is less.
    pub(crate) fn allowed(&self) -> u64 {
        self.memory_limit.0.min(available().unwrap_or(u64::MAX))
    }
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

/// Most memory that this process ever held, where the system tells.
pub(crate) fn peak() -> Option<Bytes> {
    amount("/proc/self/status", "VmHWM:").map(Bytes)
}

/// Memory that the system still gives, where it tells: what is free, and what a
/// limit on this process's address space leaves.
pub(crate) fn available() -> Option<u64> {
    let free = amount("/proc/meminfo", "MemAvailable:");
    free.into_iter().chain(address_space()).min()
}

/// What a limit on this process's address space leaves, if there is one.
pub(crate) fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(amount("/proc/self/status", "VmSize:")?))
}

/// Bytes that reading and checking a file takes at the peak, over its size;
/// measured: 9 to 13 for a binary STL and an OBJ of 300,000 triangles.
const BYTES_PER_BYTE: f64 = 12.0;

/// Refuses a file that the memory left could not hold once read.
pub(crate) fn check_input(file: &Path) -> Result<(), Failure> {
    // What cannot be asked for its size is told when it is read.
    let Ok(meta) = std::fs::metadata(file) else {
        return Ok(());
    };
    let needed = BYTES_PER_BYTE * meta.len() as f64;
    match available() {
        Some(left) if needed > left as f64 => Err(Failure::no_result(
            format!(
                "{}: reading needs about {}, and {} are left; a file of {} would fit",
                shown_path(file),
                Bytes(needed as u64),
                Bytes(left),
                Bytes((left as f64 / BYTES_PER_BYTE) as u64),
            ),
            "take a machine with more memory, or coarsen the mesh",
        )),
        _ => Ok(()),
    }
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
