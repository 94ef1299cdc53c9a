//! Ready decks: supports, loads and steps for the CalculiX or Abaqus file.

use std::io::{self, Write};

use glam::DVec3;

use super::real::real;
use crate::mesh::Bounds;
use crate::shell::{LineSet, SetKind, ShellModel};

/// What a ready deck does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Template {
    /// Clamped at one end, loaded across at the other.
    Cantilever,
    /// Natural frequencies, clamped at one end.
    Modal,
}

/// Total force of the cantilever.
const FORCE: f64 = 1.0;

/// Frequencies of the modal deck.
const MODES: u32 = 6;

/// The coping faces at both ends: the two whose middles are farthest apart
/// along the longest side of the model's box. One and the same for a part with
/// a single coping face; none without.
pub(super) fn ends(model: &ShellModel) -> Option<(&LineSet, &LineSet)> {
    let along = axes(model).1;
    let middle = |set: &&LineSet| {
        let nodes = set.nodes();
        let sum: f64 = nodes
            .iter()
            .map(|&n| model.nodes[n as usize].position.dot(along))
            .sum();
        sum / nodes.len().max(1) as f64
    };
    let sets: Vec<&LineSet> = model
        .lines
        .iter()
        .filter(|l| l.kind == SetKind::Coping)
        .collect();
    let first = sets.iter().min_by(|a, b| middle(a).total_cmp(&middle(b)))?;
    let last = sets.iter().max_by(|a, b| middle(a).total_cmp(&middle(b)))?;
    Some((first, last))
}

/// Axes of the shortest and of the longest side of the box.
fn axes(model: &ShellModel) -> (DVec3, DVec3) {
    let size = Bounds::of(model.nodes.iter().map(|n| n.position)).size();
    (
        DVec3::AXES[size.min_position()],
        DVec3::AXES[size.max_position()],
    )
}

pub(super) fn write(model: &ShellModel, template: Template, out: &mut dyn Write) -> io::Result<()> {
    let Some((clamped, loaded)) = ends(model) else {
        return writeln!(
            out,
            "** No template: the part has no coping face to hold it by."
        );
    };
    writeln!(
        out,
        "** Clamped: {}. Change the name to hold it elsewhere.",
        clamped.name
    )?;
    writeln!(out, "*BOUNDARY\n{}, 1, 6", clamped.name)?;
    match template {
        Template::Modal => {
            writeln!(out, "*STEP\n*FREQUENCY\n{MODES}\n*NODE FILE\nU\n*END STEP")
        }
        Template::Cantilever => {
            let down = axes(model).0;
            writeln!(
                out,
                "** Loaded: {}, with {FORCE} in total, spread by length and thickness.",
                loaded.name
            )?;
            writeln!(out, "*STEP\n*STATIC\n*CLOAD")?;
            for (node, share) in shares(model, loaded) {
                for (k, part) in (1..).zip((-down * FORCE * share).to_array()) {
                    if part != 0.0 {
                        writeln!(out, "{}, {k}, {}", node + 1, real(part, 20))?;
                    }
                }
            }
            writeln!(out, "*NODE FILE\nU\n*EL FILE\nS\n*END STEP")
        }
    }
}

/// Share of a line load at each node, ascending: by length and thickness, as
/// the shape functions of the sides spread it.
fn shares(model: &ShellModel, line: &LineSet) -> Vec<(u32, f64)> {
    let mut all: Vec<(u32, f64)> = Vec::new();
    for &([a, b], middle) in &line.sides {
        let [p, q] = [a, b].map(|n| &model.nodes[n as usize]);
        let weight = p.position.distance(q.position) * 0.5 * (p.thickness + q.thickness);
        match middle {
            // Simpson's rule.
            Some(m) => all.extend([(a, weight / 6.0), (m, weight / 1.5), (b, weight / 6.0)]),
            None => all.extend([(a, weight / 2.0), (b, weight / 2.0)]),
        }
    }
    let total: f64 = all.iter().map(|s| s.1).sum();
    all.sort_by_key(|s| s.0);
    (all.chunk_by(|a, b| a.0 == b.0))
        .map(|same| (same[0].0, same.iter().map(|s| s.1).sum::<f64>() / total))
        .collect()
}
