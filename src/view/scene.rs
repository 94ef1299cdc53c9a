//! What the page shows, as packs: the part with its tags, and the mid-surface.

use glam::DVec3;
use serde_json::{Value, json};

use super::pack::Pack;
use crate::coping::detect::{Detection, Question};
use crate::extract::Extraction;
use crate::mesh::{TriMesh, weld_exact};
use crate::surface::graph::{Crack, SheetData, SheetGraph};
use crate::surface::{BorderKind, MidSurface, segments};

/// Stands in `neighbours` for an edge without another triangle.
const NONE: u32 = u32::MAX;

/// Kinds of line, as the page colours them.
const SEAM: u8 = 0;
const COPING_BORDER: u8 = 1;
const FADING_BORDER: u8 = 2;
const CRACK: u8 = 3;

/// Cracks that are listed with their place; all are drawn.
const CRACKS_LISTED: usize = 1000;

/// Origin of the page's coordinates, which have single precision: the middle of
/// the part.
pub(super) fn origin(mesh: &TriMesh) -> DVec3 {
    let bounds = mesh.bounds();
    0.5 * (bounds.min + bounds.max)
}

fn relative(points: impl Iterator<Item = DVec3>, origin: DVec3) -> impl Iterator<Item = f32> {
    points.flat_map(move |p| (p - origin).as_vec3().to_array())
}

/// The part: `positions` (x, y, z from the origin), `triangles` (three corners),
/// `coping` (1 for coping). With what tagging needs, `neighbours` (the triangle
/// across each of three edges) and `facets` (where a facet of the file has
/// several triangles), if `tagging`.
pub(super) fn part(mesh: &TriMesh, coping: &[bool], source: &[u32], tagging: bool) -> Pack {
    let origin = origin(mesh);
    let bounds = mesh.bounds();
    let mut pack = Pack::default();
    pack.fact("origin", json!(origin));
    pack.fact("size", json!(bounds.max - bounds.min));
    pack.fact("diagonal", bounds.diagonal());
    pack.fact("area", mesh.area());
    pack.fact("volume", mesh.volume());
    pack.f32(
        "positions",
        relative(mesh.positions.iter().copied(), origin),
    );
    pack.u32("triangles", mesh.triangles.iter().flatten().copied());
    pack.u8("coping", coping.iter().map(|&flag| u8::from(flag)));
    if tagging {
        pack.u32("neighbours", neighbours(mesh));
        let split = source.iter().enumerate().any(|(n, &f)| n as u32 != f);
        if split {
            pack.u32("facets", source.iter().copied());
        }
    }
    pack
}

/// Faces that a detection is in doubt about, alike ones as one question, gravest first.
pub(super) fn doubts(detection: &Detection, origin: DVec3) -> Vec<Value> {
    let question = |question: &Question| {
        let faces = || question.faces.iter().map(|&face| &detection.faces[face]);
        let reasons: Vec<&str> = question.reasons.iter().map(|r| r.text()).collect();
        let first = faces().next();
        json!({
            "triangles": faces().flat_map(|face| face.triangles.iter().copied()).collect::<Vec<u32>>(),
            "faces": question.faces.len(),
            "coping": question.coping,
            "reason": reasons.join("; "),
            "at": first.map_or(DVec3::ZERO, |face| face.middle - origin),
            "size": first.map_or(0.0, |face| face.bounds.diagonal()),
        })
    };
    detection.questions().iter().map(question).collect()
}

/// The triangle across each edge of each triangle; equal vertices count as one.
/// Where several meet at an edge, each leads to the next.
fn neighbours(mesh: &TriMesh) -> Vec<u32> {
    let welded = weld_exact(&mesh.positions).apply(mesh);
    let mut across = vec![NONE; 3 * mesh.triangles.len()];
    for uses in welded.edges().by_edge() {
        for (n, one) in uses.iter().enumerate() {
            let next = &uses[(n + 1) % uses.len()];
            let corners = welded.triangles[one.face.index()];
            let side = (0..3).find(|&k| {
                let [a, b] = [corners[k], corners[(k + 1) % 3]];
                [a.min(b), a.max(b)] == one.edge
            });
            if let Some(side) = side.filter(|_| next.face != one.face) {
                across[3 * one.face.index() + side] = next.face.0;
            }
        }
    }
    across
}

/// The mid-surface, in the part's coordinates: `positions`, `triangles`,
/// `thickness` (one a vertex), `feet` (two footpoints a vertex; the vertex itself
/// where none is known), `sheets` (one a triangle), `lines` (vertex pairs) with
/// `kinds`; and what is to be said of it.
pub(super) fn surface(surface: &MidSurface, graph: &SheetGraph, origin: DVec3) -> Pack {
    let mut pack = Pack::default();
    let vertices = || surface.vertices().iter();
    let positions = vertices().map(|v| v.position);
    pack.f32("positions", relative(positions, origin));
    pack.f32("thickness", vertices().map(|v| v.ball.thickness as f32));
    let feet = vertices().flat_map(|v| {
        let foot = |k| *v.ball.footpoints.get(k).unwrap_or(&v.position);
        [foot(0), foot(1)]
    });
    pack.f32("feet", relative(feet, origin));
    let triangles = || surface.triangles().iter();
    pack.u32("triangles", triangles().flat_map(|t| t.corners));
    pack.u32("sheets", triangles().map(|t| t.sheet));
    let lines = lines(surface);
    pack.u32("lines", lines.iter().flat_map(|&(ends, _)| ends));
    pack.u8("kinds", lines.iter().map(|&(_, kind)| kind));
    pack.fact("counts", json!(graph.counts()));
    pack.fact("area", graph.area());
    let sheets = graph.sheets().iter().zip(0..);
    let sheet = |(data, number): (&SheetData, u32)| {
        json!({
            "area": data.area,
            "thickness": data.thickness,
            "neighbours": graph.neighbours(number),
        })
    };
    pack.fact("sheets", sheets.map(sheet).collect::<Vec<Value>>());
    let listed = graph.cracks().iter().take(CRACKS_LISTED);
    let crack = |crack: &Crack| json!({ "at": crack.at - origin, "length": crack.length });
    pack.fact("cracks", listed.map(crack).collect::<Vec<Value>>());
    pack
}

/// A fresh extraction: [`surface`], and how it was made.
pub(super) fn extraction(result: &Extraction, origin: DVec3) -> Pack {
    let mut pack = surface(&result.surface, &result.graph, origin);
    let work = &result.work;
    pack.fact("cell", work.cell);
    pack.fact("cells", work.counts.cells);
    pack.fact(
        "seconds",
        work.field_seconds + work.trace_seconds + work.mesh_seconds,
    );
    let closed = result.closed_over.iter().map(|piece| {
        let (min, max) = (DVec3::from(piece.min), DVec3::from(piece.max));
        json!({ "at": 0.5 * (min + max) - origin, "size": (max - min).length(), "area": piece.area })
    });
    pack.fact("closed_over", closed.collect::<Vec<Value>>());
    pack
}

/// Segments of all lines with their kind. What stands at cracks has no line in
/// the surface; it is found as edges of one triangle that no border has.
fn lines(surface: &MidSurface) -> Vec<([u32; 2], u8)> {
    let mut lines = Vec::new();
    for seam in surface.seams() {
        lines.extend(segments(&seam.path, seam.closed).map(|ends| (ends, SEAM)));
    }
    for border in surface.borders() {
        let kind = match border.kind {
            BorderKind::Coping => COPING_BORDER,
            BorderKind::Fading => FADING_BORDER,
        };
        lines.extend(segments(&border.path, border.closed).map(|ends| (ends, kind)));
    }
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut known: Vec<[u32; 2]> = lines.iter().map(|&(ends, _)| sorted(ends)).collect();
    known.sort_unstable();
    for uses in surface.mesh().edges().by_edge() {
        if uses.len() == 1 && known.binary_search(&uses[0].edge).is_err() {
            lines.push((uses[0].edge, CRACK));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::{NONE, neighbours};
    use crate::mesh::TriMesh;

    /// Two triangles of a square with their own copies of the shared corners.
    #[test]
    fn equal_vertices_make_neighbours() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mesh = TriMesh {
            positions: vec![
                at(0.0, 0.0),
                at(1.0, 0.0),
                at(0.0, 1.0),
                at(1.0, 0.0),
                at(1.0, 1.0),
                at(0.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [3, 4, 5]],
        };
        assert_eq!(neighbours(&mesh), [NONE, 1, NONE, NONE, NONE, 0]);
    }
}
