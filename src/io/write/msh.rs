//! Gmsh 4.1 mesh, ASCII.
//!
//! A surface entity for every sheet and a curve entity for every run of sides
//! that belong to the same lines, each in the physical groups of its names.
//! A node is listed once: under a curve if it is on one, else under a surface.
//! Thickness is nodal data.

use std::collections::BTreeMap;
use std::io::{self, Write};

use glam::DVec3;

use crate::mesh::Bounds;
use crate::shell::ShellModel;

/// Sides, and the middle of each if it has one.
type Sides = Vec<([u32; 2], Option<u32>)>;

/// The model sorted into entities.
struct Entities<'m> {
    model: &'m ShellModel,
    /// Places in [`ShellModel::lines`], and the sides that are on just these.
    curves: Vec<(Vec<usize>, Sides)>,
    /// Nodes that belong to each curve.
    curve_nodes: Vec<Vec<u32>>,
    /// Elements of each sheet.
    sheets: Vec<Vec<usize>>,
    /// Nodes that belong to each sheet.
    sheet_nodes: Vec<Vec<u32>>,
}

impl<'m> Entities<'m> {
    fn of(model: &'m ShellModel) -> Entities<'m> {
        let mut lines_of: BTreeMap<[u32; 2], (Vec<usize>, Option<u32>)> = BTreeMap::new();
        for (n, line) in model.lines.iter().enumerate() {
            for &([a, b], middle) in &line.sides {
                let entry = lines_of.entry([a.min(b), a.max(b)]);
                let (lines, _) = entry.or_insert((Vec::new(), middle));
                lines.push(n);
            }
        }
        let mut by_lines: BTreeMap<Vec<usize>, Sides> = BTreeMap::new();
        for (ends, (lines, middle)) in lines_of {
            by_lines.entry(lines).or_default().push((ends, middle));
        }
        let curves: Vec<(Vec<usize>, Sides)> = by_lines.into_iter().collect();
        let mut free = vec![true; model.nodes.len()];
        let mut take = |nodes: &mut dyn Iterator<Item = u32>| {
            let mut own: Vec<u32> = nodes
                .filter(|&n| std::mem::take(&mut free[n as usize]))
                .collect();
            own.sort_unstable();
            own
        };
        let curve_nodes = (curves.iter())
            .map(|(_, sides)| take(&mut sides.iter().flat_map(|s| s.0.into_iter().chain(s.1))))
            .collect();
        let sheets = model.by_sheet();
        let nodes = |&e: &usize| model.elements[e].nodes.iter().copied();
        let sheet_nodes = (sheets.iter())
            .map(|own| take(&mut own.iter().flat_map(nodes)))
            .collect();
        Entities {
            model,
            curves,
            curve_nodes,
            sheets,
            sheet_nodes,
        }
    }

    fn bounds(&self, nodes: impl Iterator<Item = u32>) -> String {
        let bounds = Bounds::of(nodes.map(|n| self.model.nodes[n as usize].position));
        let [low, high] = [bounds.min, bounds.max].map(point);
        format!("{low} {high}")
    }
}

fn point(p: DVec3) -> String {
    format!("{} {} {}", p.x, p.y, p.z)
}

pub(super) fn write(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    let entities = Entities::of(model);
    writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
    names(model, out)?;
    blocks(&entities, out)?;
    nodes(&entities, out)?;
    elements(&entities, out)?;
    thickness(&entities, out)
}

fn names(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "$PhysicalNames\n{}",
        model.lines.len() + model.sheets.len()
    )?;
    for (n, line) in (1..).zip(&model.lines) {
        writeln!(out, "1 {n} \"{}\"", line.name)?;
    }
    for n in 1..=model.sheets.len() {
        writeln!(out, "2 {n} \"SHEET_{n}\"")?;
    }
    writeln!(out, "$EndPhysicalNames")
}

fn blocks(entities: &Entities, out: &mut dyn Write) -> io::Result<()> {
    let Entities {
        model,
        curves,
        sheets,
        ..
    } = entities;
    writeln!(
        out,
        "$Entities\n0 {} {} 0",
        curves.len(),
        model.sheets.len()
    )?;
    for (n, (lines, sides)) in (1..).zip(curves) {
        let bounds = entities.bounds(sides.iter().flat_map(|s| s.0));
        let groups: Vec<String> = lines.iter().map(|l| (l + 1).to_string()).collect();
        writeln!(out, "{n} {bounds} {} {} 0", groups.len(), groups.join(" "))?;
    }
    for (n, own) in (1..).zip(sheets) {
        let corners = |&e: &usize| model.elements[e].corners().iter().copied();
        let bounds = entities.bounds(own.iter().flat_map(corners));
        writeln!(out, "{n} {bounds} 1 {n} 0")?;
    }
    writeln!(out, "$EndEntities")
}

fn nodes(entities: &Entities, out: &mut dyn Write) -> io::Result<()> {
    let count = entities.model.nodes.len();
    let curves = (1..).zip(&entities.curve_nodes).map(|(n, own)| (1, n, own));
    let sheets = (1..).zip(&entities.sheet_nodes).map(|(n, own)| (2, n, own));
    let blocks: Vec<(u32, u32, &Vec<u32>)> = curves.chain(sheets).collect();
    writeln!(out, "$Nodes\n{} {count} 1 {count}", blocks.len())?;
    for (dimension, n, own) in blocks {
        writeln!(out, "{dimension} {n} 0 {}", own.len())?;
        for node in own {
            writeln!(out, "{}", node + 1)?;
        }
        for &node in own {
            writeln!(
                out,
                "{}",
                point(entities.model.nodes[node as usize].position)
            )?;
        }
    }
    writeln!(out, "$EndNodes")
}

/// Gmsh's number of an element with so many nodes.
fn kind(nodes: usize) -> u32 {
    match nodes {
        3 => 2,
        4 => 3,
        6 => 9,
        _ => 16,
    }
}

/// Elements keep the model's numbers; sides follow.
fn elements(entities: &Entities, out: &mut dyn Write) -> io::Result<()> {
    let Entities {
        model,
        curves,
        sheets,
        ..
    } = entities;
    let mut blocks: Vec<(u32, u32, Vec<usize>)> = Vec::new();
    for (sheet, all) in (1..).zip(sheets) {
        for sides in [3, 4] {
            let fits = |e: &usize| model.elements[*e].sides() == sides;
            let own: Vec<usize> = all.iter().copied().filter(fits).collect();
            if let Some(&first) = own.first() {
                blocks.push((sheet, kind(model.elements[first].nodes.len()), own));
            }
        }
    }
    let sides: usize = curves.iter().map(|c| c.1.len()).sum();
    let count = model.elements.len() + sides;
    writeln!(
        out,
        "$Elements\n{} {count} 1 {count}",
        blocks.len() + curves.len()
    )?;
    for (sheet, kind, own) in blocks {
        writeln!(out, "2 {sheet} {kind} {}", own.len())?;
        for e in own {
            write!(out, "{}", e + 1)?;
            for node in &model.elements[e].nodes {
                write!(out, " {}", node + 1)?;
            }
            writeln!(out)?;
        }
    }
    let mut number = model.elements.len();
    for (n, (_, sides)) in (1..).zip(curves) {
        let quadratic = sides.iter().all(|s| s.1.is_some());
        writeln!(
            out,
            "1 {n} {} {}",
            if quadratic { 8 } else { 1 },
            sides.len()
        )?;
        for &([a, b], middle) in sides {
            number += 1;
            write!(out, "{number} {} {}", a + 1, b + 1)?;
            if let Some(middle) = middle {
                write!(out, " {}", middle + 1)?;
            }
            writeln!(out)?;
        }
    }
    writeln!(out, "$EndElements")
}

/// In the order of the nodes: some readers go by it and not by the numbers.
fn thickness(entities: &Entities, out: &mut dyn Write) -> io::Result<()> {
    let nodes = &entities.model.nodes;
    writeln!(
        out,
        "$NodeData\n1\n\"thickness\"\n1\n0.0\n3\n0\n1\n{}",
        nodes.len()
    )?;
    let curves = entities.curve_nodes.iter().flatten();
    for &n in curves.chain(entities.sheet_nodes.iter().flatten()) {
        writeln!(out, "{} {}", n + 1, nodes[n as usize].thickness)?;
    }
    writeln!(out, "$EndNodeData")
}
