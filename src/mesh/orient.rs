//! Consistent and outward orientation.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::edges::{EdgeKind, EdgeUse, EdgeUses, kind};
use super::error::{EdgeReport, PartError, PartWarning};
use super::sets::Sets;
use super::{Bounds, FaceId, TriMesh};

/// Solid angles that the shell check may sum before it gives up; about a
/// second's worth.
const SHELL_CHECK_BUDGET: usize = 50_000_000;

/// An edge with its first triangle, for a message.
pub(super) fn report(mesh: &TriMesh, uses: &[EdgeUse]) -> EdgeReport {
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
) -> Result<Option<PartWarning>, PartError> {
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
    let mut count = 0;
    for (corners, _) in mesh.triangles.iter_mut().zip(&flips).filter(|(_, f)| **f) {
        corners.swap(1, 2);
        count += 1;
    }
    Ok(Some(PartWarning::Reoriented {
        triangles: count,
        first,
    }))
}

/// The edge shared by two triangles.
fn between(mesh: &TriMesh, uses: &EdgeUses, a: FaceId, b: FaceId) -> Option<EdgeReport> {
    uses.by_edge()
        .find(|uses| uses.iter().any(|u| u.face == a) && uses.iter().any(|u| u.face == b))
        .map(|uses| report(mesh, uses))
}

/// Turns a part that is inside out, then single closed shells that are inside
/// out and lie in no other shell; those that do are cavities and stay.
pub(super) fn make_outward(mesh: &mut TriMesh, uses: &EdgeUses) -> Vec<PartWarning> {
    let mut warnings = Vec::new();
    let volume = mesh.volume();
    if volume < 0.0 {
        for corners in &mut mesh.triangles {
            corners.swap(1, 2);
        }
        warnings.push(PartWarning::Turned { volume });
    }
    warnings.extend(turn_stray_shells(mesh, uses));
    warnings
}

struct Shell {
    faces: Vec<FaceId>,
    bounds: Bounds,
    volume: f64,
}

fn turn_stray_shells(mesh: &mut TriMesh, uses: &EdgeUses) -> Option<PartWarning> {
    let shells = closed_shells(mesh, uses);
    if shells.len() < 2 {
        return None;
    }
    let mut budget = SHELL_CHECK_BUDGET;
    let mut stray = Vec::new();
    let mut negative = 0;
    for (index, shell) in shells.iter().enumerate() {
        if shell.volume >= 0.0 {
            continue;
        }
        negative += 1;
        let [a, b, c] = mesh.corners(shell.faces[0]);
        let probe = (a + b + c) / 3.0;
        let mut inside = false;
        for (other, outer) in shells.iter().enumerate() {
            if other == index || !outer.bounds.contains(probe) {
                continue;
            }
            budget = match budget.checked_sub(outer.faces.len()) {
                Some(left) => left,
                None => return Some(PartWarning::ShellsUnchecked { shells: negative }),
            };
            if winding_number(mesh, &outer.faces, probe).abs() > 0.5 {
                inside = true;
                break;
            }
        }
        if !inside {
            stray.push(index);
        }
    }
    if stray.is_empty() {
        return None;
    }
    let mut triangles = 0;
    for &index in &stray {
        for face in &shells[index].faces {
            mesh.triangles[face.index()].swap(1, 2);
            triangles += 1;
        }
    }
    Some(PartWarning::ShellsTurned {
        shells: stray.len(),
        triangles,
    })
}

/// Patches joined through two-triangle edges that are closed by themselves,
/// in order of their lowest triangle.
fn closed_shells(mesh: &TriMesh, uses: &EdgeUses) -> Vec<Shell> {
    let mut sets = Sets::new(mesh.triangles.len());
    for pair in uses.by_edge().filter(|uses| uses.len() == 2) {
        sets.join(pair[0].face.0, pair[1].face.0);
    }
    let (label, count) = sets.labels();
    let mut closed = vec![true; count];
    for uses in uses.by_edge() {
        if kind(uses) == EdgeKind::Manifold {
            continue;
        }
        // Within its own patch an edge must be run equally often both ways.
        let mut balance: FxHashMap<u32, i64> = FxHashMap::default();
        for one in uses {
            let patch = label[one.face.index()];
            *balance.entry(patch).or_default() += if one.forward { 1 } else { -1 };
        }
        for (patch, balance) in balance {
            if balance != 0 {
                closed[patch as usize] = false;
            }
        }
    }
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); count];
    for face in mesh.faces() {
        faces[label[face.index()] as usize].push(face);
    }
    faces
        .into_iter()
        .zip(closed)
        .filter(|(_, closed)| *closed)
        .map(|(faces, _)| {
            let bounds = Bounds::of(faces.iter().flat_map(|&face| mesh.corners(face)));
            Shell {
                volume: mesh.volume_about(bounds.center(), faces.iter().copied()),
                bounds,
                faces,
            }
        })
        .collect()
}

/// Winding number of the faces about a point: solid angles over 4 pi, each by
/// the formula of van Oosterom and Strackee (1983).
fn winding_number(mesh: &TriMesh, faces: &[FaceId], point: DVec3) -> f64 {
    let sum: f64 = faces
        .iter()
        .map(|&face| {
            let [a, b, c] = mesh.corners(face).map(|p| p - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let numerator = a.dot(b.cross(c));
            let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * numerator.atan2(denominator)
        })
        .sum();
    sum / (4.0 * std::f64::consts::PI)
}
