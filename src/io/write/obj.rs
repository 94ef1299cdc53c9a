//! Wavefront OBJ: one group a sheet.

use std::io::{self, Write};

use super::SurfaceOptions;
use crate::surface::{BorderKind, MidSurface, segments};

pub(super) fn write(
    surface: &MidSurface,
    options: SurfaceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    writeln!(
        out,
        "# mid-surface: {} vertices, {} triangles, {} sheets, {} seams",
        surface.vertices().len(),
        surface.triangles().len(),
        surface.sheet_count(),
        surface.seams().len()
    )?;
    writeln!(out, "o mid_surface")?;
    for vertex in surface.vertices() {
        let p = vertex.position;
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    // By sheet, each sheet's triangles in their order.
    let mut order: Vec<usize> = (0..surface.triangles().len()).collect();
    order.sort_by_key(|&index| surface.triangles()[index].sheet);
    let mut sheet = None;
    for index in order {
        let triangle = surface.triangles()[index];
        if sheet != Some(triangle.sheet) {
            sheet = Some(triangle.sheet);
            writeln!(out, "g sheet_{}", triangle.sheet)?;
        }
        let [a, b, c] = triangle.corners.map(|v| u64::from(v) + 1);
        writeln!(out, "f {a} {b} {c}")?;
    }
    if options.obj_lines {
        for (number, seam) in surface.seams().iter().enumerate() {
            writeln!(out, "g seam_{number}")?;
            line(&seam.path, seam.closed, out)?;
        }
        for (number, border) in surface.borders().iter().enumerate() {
            let kind = match border.kind {
                BorderKind::Coping => "coping",
                BorderKind::Fading => "fading",
            };
            writeln!(out, "g {kind}_border_{number}")?;
            line(&border.path, border.closed, out)?;
        }
    }
    Ok(())
}

fn line(path: &[u32], closed: bool, out: &mut dyn Write) -> io::Result<()> {
    let mut segments = segments(path, closed).peekable();
    let Some([first, _]) = segments.peek() else {
        return Ok(());
    };
    write!(out, "l {}", u64::from(*first) + 1)?;
    for [_, to] in segments {
        write!(out, " {}", u64::from(to) + 1)?;
    }
    writeln!(out)
}
