//! Input deck for CalculiX and Abaqus.
//!
//! | what | how |
//! | --- | --- |
//! | elements | one `*ELEMENT` block a sheet and shape, in the set `SHEET_n` |
//! | thickness | `*NODAL THICKNESS`: both programs take it on every node |
//! | normals | `*NORMAL` at every corner of every element, without which slivers stop CalculiX |
//! | sets | element sets `THICKNESS_n` of the classes; node sets of the lines |
//!
//! CalculiX reads at most 20 characters of a number.

use std::io::{self, Write};

use super::real::real;
use super::template::{self, Template};
use crate::shell::{ShellElement, ShellModel};

/// Longest number that CalculiX reads.
const WIDTH: usize = 20;

/// Members of a set on a line; both programs take 16.
const ROW: usize = 12;

/// Whose names the elements have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Dialect {
    /// CalculiX.
    #[default]
    Calculix,
    /// Abaqus.
    Abaqus,
}

impl Dialect {
    /// Name of an element, by its number of nodes.
    fn element(self, nodes: usize) -> &'static str {
        match (nodes, self) {
            (3, _) => "S3",
            (4, _) => "S4",
            (6, Dialect::Calculix) => "S6",
            (6, Dialect::Abaqus) => "STRI65",
            _ => "S8R",
        }
    }
}

pub(super) fn write(
    model: &ShellModel,
    dialect: Dialect,
    template: Option<Template>,
    out: &mut dyn Write,
) -> io::Result<()> {
    writeln!(
        out,
        "** midsurf: {} nodes, {} elements, {} sheets",
        model.nodes.len(),
        model.elements.len(),
        model.sheets.len()
    )?;
    writeln!(
        out,
        "** Lengths are the part's. The material is steel in mm, N and t: change it as needed."
    )?;
    writeln!(out, "*NODE, NSET=NALL")?;
    for (n, node) in (1..).zip(&model.nodes) {
        let [x, y, z] = node.position.to_array().map(|x| real(x, WIDTH));
        writeln!(out, "{n}, {x}, {y}, {z}")?;
    }
    elements(model, dialect, out)?;
    sets(model, out)?;
    normals(model, out)?;
    sections(model, out)?;
    match template {
        Some(template) => template::write(model, template, out),
        None => loads(model, out),
    }
}

/// Nodes of an element, counted from 1.
fn nodes(element: &ShellElement) -> String {
    let all: Vec<String> = element.nodes.iter().map(|n| (n + 1).to_string()).collect();
    all.join(", ")
}

fn elements(model: &ShellModel, dialect: Dialect, out: &mut dyn Write) -> io::Result<()> {
    for (sheet, own) in (1..).zip(model.by_sheet()) {
        for sides in [3, 4] {
            let mut empty = true;
            for &e in own.iter().filter(|&&e| model.elements[e].sides() == sides) {
                let element = &model.elements[e];
                if std::mem::take(&mut empty) {
                    let name = dialect.element(element.nodes.len());
                    writeln!(out, "*ELEMENT, TYPE={name}, ELSET=SHEET_{sheet}")?;
                }
                writeln!(out, "{}, {}", e + 1, nodes(element))?;
            }
        }
    }
    Ok(())
}

fn sets(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "*ELSET, ELSET=EALL")?;
    rows((1..=model.sheets.len()).map(|n| format!("SHEET_{n}")), out)?;
    for (n, class) in (1..).zip(&model.classes) {
        writeln!(out, "** thickness {}", class.thickness)?;
        writeln!(out, "*ELSET, ELSET=THICKNESS_{n}")?;
        rows(class.sheets.iter().map(|s| format!("SHEET_{}", s + 1)), out)?;
    }
    for line in &model.lines {
        writeln!(out, "*NSET, NSET={}", line.name)?;
        rows(line.nodes().iter().map(|n| (n + 1).to_string()), out)?;
    }
    Ok(())
}

/// Names or numbers, some on each line.
pub(super) fn rows(items: impl Iterator<Item = String>, out: &mut dyn Write) -> io::Result<()> {
    let items: Vec<String> = items.collect();
    for row in items.chunks(ROW) {
        writeln!(out, "{},", row.join(", "))?;
    }
    Ok(())
}

fn normals(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "*NORMAL")?;
    for (e, element) in (1..).zip(&model.elements) {
        for (node, &normal) in element.nodes.iter().zip(&element.normals) {
            // The sums of rounding at ten digits are far below any tolerance.
            let [x, y, z] = model.normals[normal as usize].to_array();
            writeln!(out, "{e}, {}, {x:.10}, {y:.10}, {z:.10}", node + 1)?;
        }
    }
    Ok(())
}

fn sections(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "*NODAL THICKNESS")?;
    for (n, node) in (1..).zip(&model.nodes) {
        writeln!(out, "{n}, {}", real(node.thickness, WIDTH))?;
    }
    writeln!(
        out,
        "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n*DENSITY\n7.85e-9"
    )?;
    // Offset of the nodes from the middle, in thicknesses along the normal.
    let offset = model.placement - 0.5;
    let offset = match offset == 0.0 {
        true => String::new(),
        false => format!(", OFFSET={offset:?}"),
    };
    for (n, sheet) in (1..).zip(&model.sheets) {
        let names = |side: usize| sheet.walls[side].join(" ");
        if !sheet.walls.iter().all(Vec::is_empty) {
            writeln!(out, "** walls: below {}; above {}", names(0), names(1))?;
        }
        // The figure below is not used, but has to be there.
        writeln!(
            out,
            "*SHELL SECTION, ELSET=SHEET_{n}, MATERIAL=STEEL, NODAL THICKNESS{offset}"
        )?;
        writeln!(out, "{}", real(sheet.thickness.median, WIDTH))?;
    }
    Ok(())
}

/// How to go on from here.
fn loads(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    let set = template::ends(model).map_or("A_SET", |(clamped, _)| &clamped.name);
    writeln!(
        out,
        "** To solve: add supports and loads on the node sets above, for example\n\
         ** *BOUNDARY\n\
         ** {set}, 1, 6\n\
         ** *STEP\n\
         ** *STATIC\n\
         ** *CLOAD\n\
         ** NODE, 3, -1.0\n\
         ** *NODE FILE\n\
         ** U\n\
         ** *END STEP\n\
         ** or write the deck with a template."
    )
}
