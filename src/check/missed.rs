//! Tags that are missed where a result shows it: a sheet that fades out before
//! an untagged rim, a crack beside a face in doubt.

use glam::DVec3;

use crate::coping::detect::{DetectedFace, Detection};
use crate::field::Field;
use crate::mesh::Part;
use crate::surface::graph::SheetGraph;
use crate::surface::{BorderKind, MidSurface};

/// A sheet fades out half a thickness before an untagged rim; what is not
/// nearer than this, in thicknesses of the wall, is not at fault.
const REACH: f64 = 1.2;

/// Share of a face that must be tagged otherwise than the program would.
const UNTAGGED: f64 = 0.5;

/// Where a surface ends without coping, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseEnd {
    /// Where.
    pub at: DVec3,
    /// How.
    pub kind: LooseKind,
}

/// How a surface ends without coping.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum LooseKind {
    /// A sheet fades out.
    Fading,
    /// An edge of one triangle that is no border.
    Crack,
}

/// A face that looks like the end of a wall and is not tagged, before which a
/// surface ends.
#[derive(Clone, Debug, PartialEq)]
pub struct MissedTag {
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
    /// The end nearest to it.
    pub end: LooseEnd,
}

/// All places where a surface ends without coping: none for a surface whose
/// tags miss nothing.
pub fn loose_ends(surface: &MidSurface, graph: &SheetGraph) -> Vec<LooseEnd> {
    let fading = (surface.borders().iter()).filter(|border| border.kind == BorderKind::Fading);
    let fading = fading.flat_map(|border| &border.path).map(|&v| LooseEnd {
        at: surface.vertices()[v as usize].position,
        kind: LooseKind::Fading,
    });
    let cracks = graph.cracks().iter().map(|crack| LooseEnd {
        at: crack.at,
        kind: LooseKind::Crack,
    });
    cracks.chain(fading).collect()
}

/// Faces that look like the end of a wall, are not tagged, and before which one
/// of the ends lies; in the order of the detection.
pub fn missed_tags(part: &Part, detection: &Detection, ends: &[LooseEnd]) -> Vec<MissedTag> {
    let open = |face: &DetectedFace| {
        let open = (face.triangles.iter()).filter(|&&t| !part.coping()[t as usize]);
        open.count() as f64 > UNTAGGED * face.triangles.len() as f64
    };
    let suspect = |face: &&DetectedFace| (face.coping || face.looks_like_a_rim()) && open(face);
    let missed = |face: &DetectedFace| {
        Some(MissedTag {
            triangles: face.triangles.clone(),
            end: nearest(part, face, ends)?,
        })
    };
    let faces = detection.faces.iter().filter(suspect);
    faces.filter_map(missed).collect()
}

/// The end nearest to a face, if it is near enough.
fn nearest(part: &Part, face: &DetectedFace, ends: &[LooseEnd]) -> Option<LooseEnd> {
    let reach = REACH * face.thickness;
    let (low, high) = (face.bounds.min - reach, face.bounds.max + reach);
    let near = |end: &&LooseEnd| end.at.cmpge(low).all() && end.at.cmple(high).all();
    let mut close = ends.iter().filter(near).peekable();
    close.peek()?;
    let mesh = part.mesh();
    let ids = face.triangles.iter().map(|&t| mesh.triangles[t as usize]);
    let corners = ids.clone().map(|t| t.map(|v| mesh.positions[v as usize]));
    let field = Field::from_triangles(corners.collect(), ids.collect(), Vec::new());
    close
        .map(|end| (field.footpoint(end.at).distance, *end))
        .filter(|&(distance, _)| distance <= reach)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, end)| end)
}
