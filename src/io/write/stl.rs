//! Binary STL: triangles only, in single precision.

use std::io::{self, Write};

use crate::mesh::midsurface::MidSurface;

pub(super) fn write(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    let mut header = [b' '; 80];
    let title = b"mid-surface, binary STL";
    header[..title.len()].copy_from_slice(title);
    out.write_all(&header)?;
    let count = u32::try_from(surface.triangles.len())
        .map_err(|_| io::Error::other("too many triangles for STL"))?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &surface.triangles {
        let corners = triangle
            .corners
            .map(|v| surface.vertices[v as usize].position);
        let [a, b, c] = corners;
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
