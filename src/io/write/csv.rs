//! Thickness and radius of every vertex, by 0-based index.

use std::io::{self, Write};

use crate::surface::MidSurface;

pub(super) fn write(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "vertex_index,thickness,radius")?;
    for (index, vertex) in surface.vertices().iter().enumerate() {
        writeln!(
            out,
            "{index},{},{}",
            vertex.ball.thickness, vertex.ball.radius
        )?;
    }
    Ok(())
}
