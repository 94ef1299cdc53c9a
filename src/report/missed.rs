//! Tags that are missed where a result shows it: a sheet that fades out before
//! an untagged rim, a crack beside a face in doubt.

use crate::coping::detect;
use crate::coping::detect::{DetectedFace, Detection, Options};
use crate::extract::Extraction;
use crate::field::Field;
use crate::mesh::Part;
use crate::surface::BorderKind;
use glam::DVec3;

use crate::intake::{Input, facets, shown_ranges};
use crate::io::quote::figure;
use crate::settings::warning::Warning;

/// A sheet fades out half a thickness before an untagged rim; what is not
/// nearer than this, in thicknesses of the wall, is not at fault.
const REACH: f64 = 1.2;

/// Share of a face that must be tagged otherwise than the program would.
const UNTAGGED: f64 = 0.5;

/// Faces named, at most.
const NAMED: usize = 8;

/// Faces that look like the end of a wall, are not tagged, and before which a
/// sheet fades out or has a crack.
pub(super) fn missed_tags(input: &Input, result: &Extraction) -> Vec<Warning> {
    let ends = ends(result);
    if ends.is_empty() {
        return Vec::new();
    }
    let own;
    let detection = match &input.detection {
        Some(detection) => detection,
        None => {
            own = detect(input.part.mesh(), &Options::default());
            &own
        }
    };
    let suspects = suspects(&input.part, detection);
    let mut warnings = Vec::new();
    for face in suspects {
        let Some((place, what)) = nearest_end(&input.part, face, &ends) else {
            continue;
        };
        if warnings.len() == NAMED {
            break;
        }
        let [x, y, z] = place.to_array().map(figure);
        warnings.push(Warning::new("missed_coping", format!(
                "{what} at ({x}, {y}, {z}), before triangles {}: they look like the end of a wall but are not tagged as coping",
                shown_ranges(&facets(&input.source, &face.triangles))
            )));
    }
    warnings
}

/// Where the result ends without coping, and how.
fn ends(result: &Extraction) -> Vec<(DVec3, &'static str)> {
    let surface = &result.surface;
    let fading = surface
        .borders()
        .iter()
        .filter(|b| b.kind == BorderKind::Fading);
    let fading = fading
        .flat_map(|border| &border.path)
        .map(|&v| (surface.vertices()[v as usize].position, "a sheet fades out"));
    let cracks = result
        .graph
        .cracks()
        .iter()
        .map(|crack| (crack.at, "a sheet has a crack"));
    cracks.chain(fading).collect()
}

/// Faces taken for wall that look like coping.
fn suspects<'a>(part: &Part, detection: &'a Detection) -> Vec<&'a DetectedFace> {
    let untagged = |face: &DetectedFace| {
        let open = face
            .triangles
            .iter()
            .filter(|&&t| !part.coping()[t as usize]);
        open.count() as f64 > UNTAGGED * face.triangles.len() as f64
    };
    let rim = |face: &&DetectedFace| face.coping || face.looks_like_a_rim();
    let faces = detection.faces.iter().filter(rim);
    faces.filter(|face| untagged(face)).collect()
}

fn nearest_end(
    part: &Part,
    face: &DetectedFace,
    ends: &[(DVec3, &'static str)],
) -> Option<(DVec3, &'static str)> {
    let reach = REACH * face.thickness;
    let (low, high) = (face.bounds.min - reach, face.bounds.max + reach);
    let near = |p: DVec3| p.cmpge(low).all() && p.cmple(high).all();
    let mut close = ends.iter().filter(|(p, _)| near(*p)).peekable();
    close.peek()?;
    let ids = face.triangles.iter().map(|&t| t as usize);
    let corners = ids
        .clone()
        .map(|t| part.mesh().triangles[t].map(|v| part.mesh().positions[v as usize]))
        .collect();
    let indices = ids.map(|t| part.mesh().triangles[t]).collect();
    let field = Field::from_triangles(corners, indices, Vec::new());
    close
        .map(|&(place, what)| (field.footpoint(place).distance, place, what))
        .filter(|&(distance, ..)| distance <= reach)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, place, what)| (place, what))
}
