//! Nastran bulk data.
//!
//! Positions in large fields of 16 characters; thickness `T1`.. at the corners
//! of every element, so that nodes of a seam need no common one; a `PSHELL` for
//! every sheet, bending and shear included; lines as `SET1` of nodes.

use std::io::{self, Write};

use super::real::real;
use crate::shell::{ShellElement, ShellModel};

/// Numbers of a set on its first line, and on those after it.
const SET_ROW: usize = 7;

pub(super) fn write(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "$ midsurf: {} nodes, {} elements, {} sheets",
        model.nodes.len(),
        model.elements.len(),
        model.sheets.len()
    )?;
    writeln!(
        out,
        "$ The material is steel in mm, N and t: change it as needed."
    )?;
    writeln!(out, "SOL 101\nCEND\nBEGIN BULK")?;
    writeln!(
        out,
        "{:8}{:>8}{:>8}{:>8}{:>8}{:>8}",
        "MAT1", 1, "210000.", "", "0.3", "7.85-9"
    )?;
    for (n, sheet) in (1..).zip(&model.sheets) {
        writeln!(out, "$HMNAME COMP          {n:>12}\"SHEET_{n}\"")?;
        writeln!(out, "$ANSA_NAME_COMMENT;{n};PSHELL;SHEET_{n};")?;
        let t = real(sheet.thickness.median, 8);
        // Material 1 for membrane, bending and shear.
        writeln!(
            out,
            "{:8}{n:>8}{:>8}{t:>8}{:>8}{:>8}{:>8}",
            "PSHELL", 1, 1, "", 1
        )?;
    }
    for (n, node) in (1..).zip(&model.nodes) {
        let [x, y, z] = node.position.to_array().map(|x| real(x, 16));
        writeln!(out, "{:8}{n:>16}{:>16}{x:>16}{y:>16}", "GRID*", "")?;
        writeln!(out, "{:8}{z:>16}", "*")?;
    }
    for (e, element) in (1..).zip(&model.elements) {
        write_element(model, e, element, out)?;
    }
    for (n, line) in (1..).zip(&model.lines) {
        writeln!(out, "$ {}", line.name)?;
        let nodes: Vec<String> = line
            .nodes()
            .iter()
            .map(|v| format!("{:>8}", v + 1))
            .collect();
        let mut head = format!("{:8}{n:>8}", "SET1");
        let mut rest = nodes.as_slice();
        let mut room = SET_ROW;
        while !rest.is_empty() {
            let (row, after) = rest.split_at(room.min(rest.len()));
            writeln!(out, "{head}{}", row.concat())?;
            (head, rest, room) = (" ".repeat(8), after, SET_ROW + 1);
        }
    }
    writeln!(out, "ENDDATA")
}

fn write_element(
    model: &ShellModel,
    number: usize,
    element: &ShellElement,
    out: &mut dyn Write,
) -> io::Result<()> {
    let whole = |n: u32| format!("{n:>8}");
    let length = |x: f64| format!("{:>8}", real(x, 8));
    let blank = || " ".repeat(8);
    let thickness: Vec<f64> = (element.corners().iter())
        .map(|&n| model.nodes[n as usize].thickness)
        .collect();
    let mean = thickness.iter().sum::<f64>() / thickness.len() as f64;
    // The middle as seen from the nodes, along the normal.
    let offset = match model.placement == 0.5 {
        true => blank(),
        false => length((0.5 - model.placement) * mean),
    };
    let nodes = element.nodes.iter().map(|n| whole(n + 1));
    let corners = thickness.iter().map(|&t| length(t));
    let name = match element.nodes.len() {
        3 => "CTRIA3",
        4 => "CQUAD4",
        6 => "CTRIA6",
        _ => "CQUAD8",
    };
    let mut fields: Vec<String> = vec![whole(number as u32), whole(element.sheet + 1)];
    fields.extend(nodes);
    match element.nodes.len() {
        // Angle, offset, then a line that begins with two more fields.
        3 => fields.extend([blank(), offset.clone(), blank(), blank(), blank()]),
        4 => fields.extend([blank(), offset.clone(), blank(), blank()]),
        6 => fields.extend([blank(), offset.clone()]),
        _ => {}
    }
    fields.extend(corners);
    if element.nodes.len() == 8 {
        fields.extend([blank(), offset]);
    }
    for (n, row) in fields.chunks(8).enumerate() {
        let head = if n == 0 { name } else { "" };
        writeln!(out, "{}", format!("{head:8}{}", row.concat()).trim_end())?;
    }
    Ok(())
}
