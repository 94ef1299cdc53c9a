//! What to say of an extraction.

use glam::DVec3;
use serde_json::{Value, json};

use super::missed::missed_warnings;
use super::words::{counted, listed};
use crate::extract::Extraction;
use crate::intake::Input;
use crate::settings::quote::figure;
use crate::settings::warning::Warning;
use crate::surface::MidSurface;
use crate::surface::graph::SheetGraph;
use crate::surface::listing::{Summary, summary};
use crate::surface::thickness::Thickness;

/// A mid-surface in figures: `result` of the report.
pub fn account(surface: &MidSurface, graph: &SheetGraph) -> Value {
    let seams = surface.seams().iter().zip(graph.seams());
    let seams = seams.map(|(line, data)| {
        json!({
            "sheets": line.sheets,
            "length": data.length,
            "closed": line.closed,
            "ends": data.ends,
        })
    });
    let borders = surface.borders().iter().zip(graph.borders());
    let borders = borders.map(|(line, data)| {
        json!({
            "sheet": line.sheet,
            "kind": line.kind,
            "length": data.length,
            "closed": line.closed,
        })
    });
    let Summary {
        counts,
        area,
        seam_length,
        coping_border_length,
        fading_border_length,
        quality,
        sheets,
        ..
    } = summary(surface, graph);
    json!({
        "counts": counts,
        "area": area,
        "seam_length": seam_length,
        "coping_border_length": coping_border_length,
        "fading_border_length": fading_border_length,
        "thickness": Thickness::of(surface),
        "quality": quality,
        "sheets": sheets,
        "seams": seams.collect::<Vec<Value>>(),
        "borders": borders.collect::<Vec<Value>>(),
    })
}

/// What is wrong or odd about a result; of the input its own warnings tell.
pub fn warnings(input: &Input, result: &Extraction) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut warn = |code, message: String| {
        warnings.push(Warning::new(code, message));
    };
    if result.solid.is_some() {
        warn(
            "united",
            "bodies of the part overlap or touch: they were made one solid first".to_owned(),
        );
    }
    if !result.graph.cracks().is_empty() {
        let places = listed(result.graph.cracks().iter().map(|crack| crack.at));
        let length: f64 = result.graph.cracks().iter().map(|crack| crack.length).sum();
        warn(
            "cracks",
            format!(
                "the mid-surface has {}, {} long in all, at {places}: something is missing there; another --cell may help",
                counted(result.graph.cracks().len(), "crack"),
                figure(length),
            ),
        );
    }
    let counts = result.graph.counts();
    for (code, count, what) in [
        (
            "irregular_edges",
            counts.irregular_edges,
            "an edge joins three or more triangles but no seam was followed",
        ),
        (
            "pinches",
            counts.pinches,
            "pieces hang together by a point only",
        ),
        (
            "non_orientable",
            counts.non_orientable_sheets,
            "a sheet has one side only",
        ),
        (
            "degenerate_triangles",
            counts.degenerate_triangles,
            "a triangle has no area to speak of",
        ),
        (
            "lone_feet",
            counts.lone_feet,
            "a vertex has fewer than two separate footpoints and no sure thickness",
        ),
    ] {
        if count > 0 {
            warn(code, format!("{} where {what}", counted(count, "place")));
        }
    }
    if result.work.counts.lost > 0 {
        warn(
            "lost",
            format!(
                "followers stopped short at {}; {} closed by the walls at their ends, what did not close is counted as a crack",
                counted(result.work.counts.lost, "place"),
                counted(result.work.counts.matched, "loop")
            ),
        );
    }
    // Cells that stop side by side may close each other all the same.
    if result.work.counts.torn > 0 && counts.fading_borders > 0 {
        warn(
            "torn",
            format!(
                "sheets stop where no wall ends at {}: the border there is where following stopped; a smaller --cell may follow on",
                counted(result.work.counts.torn, "place")
            ),
        );
    }
    if result.work.counts.unsettled > 0 {
        warn(
            "unsettled",
            format!(
                "followers do not agree in {}",
                counted(result.work.counts.unsettled, "lattice face")
            ),
        );
    }
    if !result.closed_over.is_empty() {
        let middles = result
            .closed_over
            .iter()
            .map(|piece| 0.5 * (DVec3::from(piece.min) + DVec3::from(piece.max)));
        warn(
            "closed_over",
            format!(
                "no border came out on {}, at {}: features smaller than two cells are closed over; a smaller --cell finds them",
                counted(result.closed_over.len(), "coping face"),
                listed(middles)
            ),
        );
    }
    warnings.extend(missed_warnings(input, result));
    warnings
}
