//! Binary STL: triangles only, in single precision.

use std::io::{self, Write};

use glam::DVec3;

/// Writes triangles, given by their corners, under a title of one line.
pub(super) fn write(
    triangles: impl ExactSizeIterator<Item = [DVec3; 3]>,
    title: &str,
    out: &mut dyn Write,
) -> io::Result<()> {
    // The header has 80 bytes, whatever the title.
    write!(out, "{title:80.80}")?;
    let count = u32::try_from(triangles.len())
        .map_err(|_| io::Error::other("too many triangles for STL"))?;
    out.write_all(&count.to_le_bytes())?;
    for [a, b, c] in triangles {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for vector in [normal, a, b, c] {
            for value in vector.as_vec3().to_array() {
                out.write_all(&value.to_le_bytes())?;
            }
        }
        out.write_all(&[0, 0])?;
    }
    Ok(())
}
