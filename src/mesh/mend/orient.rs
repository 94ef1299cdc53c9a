//! Consistent and outward orientation.

use super::{Repair, middle};
use crate::mesh::edges::{EdgeKind, EdgeUse, EdgeUses};
use crate::mesh::error::{EdgeReport, PartError, PartWarning};
use crate::mesh::{FaceId, TriMesh};

/// An edge with its first triangle, for a message.
pub(in crate::mesh) fn report(mesh: &TriMesh, uses: &[EdgeUse]) -> EdgeReport {
    let [a, b] = uses[0].edge;
    EdgeReport {
        from: mesh.positions[a as usize],
        to: mesh.positions[b as usize],
        triangle: uses[0].face,
    }
}

/// Turns triangles so that neighbours across edges of two triangles run them
/// in opposite directions.
///
/// In each patch that hangs together through such edges the smaller part by
/// area is turned. Does nothing when all agree already.
pub(super) fn make_consistent(
    mesh: &mut TriMesh,
    uses: &EdgeUses,
) -> Result<Option<Repair>, PartError> {
    let Some(first) = uses.first(EdgeKind::Misoriented) else {
        return Ok(None);
    };
    let first = report(mesh, first);

    // Neighbours across two-triangle edges: (other triangle, whether it must
    // be turned relative to this one).
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); mesh.triangles.len()];
    for pair in uses.by_edge().filter(|uses| uses.len() == 2) {
        let (a, b) = (pair[0].face, pair[1].face);
        let turn = pair[0].forward == pair[1].forward;
        neighbours[a.index()].push((b.0, turn));
        neighbours[b.index()].push((a.0, turn));
    }

    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut flips = vec![false; mesh.triangles.len()];
    for seed in mesh.faces() {
        if turned[seed.index()].is_some() {
            continue;
        }
        turned[seed.index()] = Some(false);
        let mut patch = vec![seed];
        let mut next = 0;
        while next < patch.len() {
            let face = patch[next];
            next += 1;
            let own = turned[face.index()] == Some(true);
            for &(other, turn) in &neighbours[face.index()] {
                let wanted = own ^ turn;
                match turned[other as usize] {
                    None => {
                        turned[other as usize] = Some(wanted);
                        patch.push(FaceId(other));
                    }
                    Some(given) if given == wanted => {}
                    Some(_) => {
                        return Err(PartError::NotOrientable {
                            first: between(mesh, uses, face, FaceId(other)).unwrap_or(first),
                        });
                    }
                }
            }
        }
        let area = |wanted: bool| -> f64 {
            patch
                .iter()
                .filter(|face| turned[face.index()] == Some(wanted))
                .map(|&face| mesh.triangle_area(face))
                .sum()
        };
        let minority = area(true) <= area(false);
        for face in &patch {
            flips[face.index()] = turned[face.index()] == Some(minority);
        }
    }
    let turned = || (0..flips.len()).filter(|&face| flips[face]);
    let places: Vec<_> = turned().map(|f| middle(mesh, mesh.triangles[f])).collect();
    for face in turned() {
        mesh.triangles[face].swap(1, 2);
    }
    let what = PartWarning::Reoriented {
        triangles: places.len(),
        first,
    };
    Ok(Some(Repair::at(what, places)))
}

/// The edge shared by two triangles.
fn between(mesh: &TriMesh, uses: &EdgeUses, a: FaceId, b: FaceId) -> Option<EdgeReport> {
    uses.by_edge()
        .find(|uses| uses.iter().any(|u| u.face == a) && uses.iter().any(|u| u.face == b))
        .map(|uses| report(mesh, uses))
}

/// Turns a part that is inside out as a whole.
pub(super) fn make_outward(mesh: &mut TriMesh) -> Option<Repair> {
    let volume = mesh.volume();
    if volume >= 0.0 {
        return None;
    }
    for corners in &mut mesh.triangles {
        corners.swap(1, 2);
    }
    Some(Repair::at(PartWarning::Turned { volume }, []))
}
