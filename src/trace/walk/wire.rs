//! Little-endian numbers out of bytes that nobody vouches for.

use std::io::{self, Read};

/// Bytes that mean nothing.
pub(crate) fn broken() -> io::Error {
    io::ErrorKind::InvalidData.into()
}

/// So many bytes, no fewer.
pub(crate) fn get<const N: usize>(input: &mut dyn Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    input.read_exact(&mut bytes)?;
    Ok(bytes)
}

pub(crate) fn get_u32(input: &mut dyn Read) -> io::Result<u32> {
    Ok(u32::from_le_bytes(get(input)?))
}

pub(crate) fn get_u64(input: &mut dyn Read) -> io::Result<u64> {
    Ok(u64::from_le_bytes(get(input)?))
}

pub(crate) fn get_f64(input: &mut dyn Read) -> io::Result<f64> {
    Ok(f64::from_le_bytes(get(input)?))
}
