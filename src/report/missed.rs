//! Tags that are missed where a result shows it, as warnings.

use crate::check::missed::{LooseKind, loose_ends, missed_tags};
use crate::coping::detect::{Options, detect};
use crate::extract::Extraction;

use crate::intake::{Input, facets, shown_ranges};
use crate::settings::quote::figure;
use crate::settings::warning::Warning;

/// Points of a look at faces that are only held against ends found before them.
const GLANCE: usize = 2000;

/// Faces named, at most.
const NAMED: usize = 8;

/// Faces that look like the end of a wall, are not tagged, and before which a
/// sheet fades out or has a crack.
pub(super) fn missed_warnings(input: &Input, result: &Extraction) -> Vec<Warning> {
    let ends = loose_ends(&result.surface, &result.graph);
    if ends.is_empty() {
        return Vec::new();
    }
    let own;
    let detection = match &input.detection {
        Some(detection) => detection,
        // The tags come from a file: what would have been found?
        None => {
            let glance = Options {
                samples: Some(GLANCE),
            };
            own = detect(input.part.mesh(), &glance);
            &own
        }
    };
    let missed = missed_tags(&input.part, detection, &ends);
    let missed = missed.into_iter().take(NAMED);
    missed
        .map(|tag| {
            let what = match tag.end.kind {
                LooseKind::Fading => "a sheet fades out",
                LooseKind::Crack => "a sheet has a crack",
            };
            let [x, y, z] = tag.end.at.to_array().map(figure);
            let triangles = shown_ranges(&facets(&input.source, &tag.triangles));
            Warning::new("missed_coping", format!(
                    "{what} at ({x}, {y}, {z}), before triangles {triangles}: they look like the end of a wall but are not tagged as coping"))
        })
        .collect()
}
