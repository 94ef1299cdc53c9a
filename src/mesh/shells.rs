//! Closed shells, and how they nest.
//!
//! A part may have several: bodies side by side, and cavities, whose shells look
//! inwards. Some programs write every shell outwards. Here all are read one
//! way: a shell that lies in an odd number of others bounds a cavity, one that
//! lies in an even number bounds a body.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::edges::{EdgeKind, EdgeUses, kind};
use super::error::PartWarning;
use super::mend::Repair;
use super::sets::Sets;
use super::{Bounds, FaceId, Part, TriMesh, self_intersections, weld_exact};

/// Solid angles that the nesting may sum before it gives up; about a second's
/// worth.
const SHELL_CHECK_BUDGET: usize = 50_000_000;

/// Shells beyond which not each is held against each other.
const MOST_SHELLS: usize = 20_000;

/// A closed piece of a mesh.
#[derive(Clone, Debug)]
pub struct Shell {
    /// Its triangles, ascending.
    pub faces: Vec<FaceId>,
    /// Box around it.
    pub bounds: Bounds,
    /// Enclosed volume; negative for a cavity.
    pub volume: f64,
}

/// Turns closed shells to what their nesting makes of them. Shells that cut or
/// touch another one nest in nothing: they keep their side, unless they are inside
/// out and lie in no other.
///
/// # Errors
///
/// The number of shells, if they are too many to find out which lies in which.
pub(crate) fn turn_by_nesting(mesh: &mut TriMesh, uses: &EdgeUses) -> Result<Vec<Repair>, usize> {
    let shells = closed_shells(mesh, uses);
    if shells.len() < 2 {
        return Ok(Vec::new());
    }
    let depths = depths(mesh, &shells).ok_or(shells.len())?;
    let mut stray = Turned::default();
    let mut nested = Turned::default();
    let mut wrong = Vec::new();
    let mut meets: Option<Vec<bool>> = None;
    for (index, (shell, depth)) in shells.iter().zip(depths).enumerate() {
        let wanted = depth % 2 == 0;
        if (shell.volume >= 0.0) == wanted {
            continue;
        }
        if depth == 0 {
            stray.add(shell);
        } else if !meets.get_or_insert_with(|| meeting(mesh, &shells))[index] {
            nested.add(shell);
        } else {
            continue;
        }
        wrong.push(index);
    }
    for face in wrong.into_iter().flat_map(|index| &shells[index].faces) {
        mesh.triangles[face.index()].swap(1, 2);
    }
    let mut repairs = Vec::new();
    if !stray.places.is_empty() {
        let what = PartWarning::ShellsTurned {
            shells: stray.places.len(),
            triangles: stray.triangles,
        };
        repairs.push(Repair::at(what, stray.places));
    }
    if !nested.places.is_empty() {
        let what = PartWarning::ShellsNested {
            shells: nested.places.len(),
            triangles: nested.triangles,
        };
        repairs.push(Repair::at(what, nested.places));
    }
    Ok(repairs)
}

#[derive(Default)]
struct Turned {
    /// Middle of each shell's box.
    places: Vec<DVec3>,
    triangles: usize,
}

impl Turned {
    fn add(&mut self, shell: &Shell) {
        self.places.push(shell.bounds.center());
        self.triangles += shell.faces.len();
    }
}

/// In how many others each shell lies, told at one of its points; none if that
/// takes too long.
fn depths(mesh: &TriMesh, shells: &[Shell]) -> Option<Vec<usize>> {
    if shells.len() > MOST_SHELLS {
        return None;
    }
    let mut budget = SHELL_CHECK_BUDGET;
    let mut depths = Vec::with_capacity(shells.len());
    for (index, shell) in shells.iter().enumerate() {
        let [a, b, c] = mesh.corners(shell.faces[0]);
        let probe = (a + b + c) / 3.0;
        let mut depth = 0;
        for (other, outer) in shells.iter().enumerate() {
            if other == index || !outer.bounds.contains(probe) {
                continue;
            }
            budget = budget.checked_sub(outer.faces.len())?;
            if winding_number(mesh, &outer.faces, probe).abs() > 0.5 {
                depth += 1;
            }
        }
        depths.push(depth);
    }
    Some(depths)
}

/// Which shells cut or touch another one, vertices in common included.
fn meeting(mesh: &TriMesh, shells: &[Shell]) -> Vec<bool> {
    let label = labels(mesh, shells);
    let mut meeting = vec![false; shells.len()];
    let mut meet = |a: u32, b: u32| {
        if a != b {
            for index in [a, b].into_iter().filter(|&index| index != NONE) {
                meeting[index as usize] = true;
            }
        }
    };
    let place = weld_exact(&mesh.positions).new_index;
    let mut first: FxHashMap<u32, u32> = FxHashMap::default();
    for (corners, &own) in mesh.triangles.iter().zip(&label) {
        for &v in corners {
            meet(*first.entry(place[v as usize]).or_insert(own), own);
        }
    }
    for (f, g) in self_intersections(mesh) {
        meet(label[f.index()], label[g.index()]);
    }
    meeting
}

/// Label of a triangle that belongs to no closed shell.
const NONE: u32 = u32::MAX;

/// Shell of each triangle.
fn labels(mesh: &TriMesh, shells: &[Shell]) -> Vec<u32> {
    let mut label = vec![NONE; mesh.triangles.len()];
    for (index, shell) in (0..).zip(shells) {
        for face in &shell.faces {
            label[face.index()] = index;
        }
    }
    label
}

impl Part {
    /// Whether closed shells of the part cut or touch each other.
    pub fn bodies_meet(&self) -> bool {
        let shells = closed_shells(&self.mesh, &self.mesh.edges());
        if shells.len() < 2 {
            return false;
        }
        let label = labels(&self.mesh, &shells);
        let differ = |(f, g): &(FaceId, FaceId)| label[f.index()] != label[g.index()];
        self_intersections(&self.mesh).iter().any(differ)
    }

    /// The part without its cavities: shells that look inwards are left out.
    /// None if there are none.
    pub fn without_voids(&self) -> Option<Part> {
        let shells = closed_shells(&self.mesh, &self.mesh.edges());
        let mut keep = vec![true; self.mesh.triangles.len()];
        for face in shells
            .iter()
            .filter(|s| s.volume < 0.0)
            .flat_map(|s| &s.faces)
        {
            keep[face.index()] = false;
        }
        if keep.iter().all(|&keep| keep) {
            return None;
        }
        let kept = |face: usize| keep[face];
        let pick = |face: usize| kept(face).then_some(face);
        let faces: Vec<usize> = (0..keep.len()).filter_map(pick).collect();
        let mesh = TriMesh {
            positions: self.mesh.positions.clone(),
            triangles: faces.iter().map(|&f| self.mesh.triangles[f]).collect(),
        };
        Some(Part {
            mesh: super::weld::drop_unused(mesh),
            coping: faces.iter().map(|&f| self.coping[f]).collect(),
            closed: self.closed,
        })
    }
}

/// Patches joined through two-triangle edges that are closed by themselves,
/// in order of their lowest triangle.
///
/// Patches that are not closed are left out; indices must be in range.
pub fn closed_shells(mesh: &TriMesh, uses: &EdgeUses) -> Vec<Shell> {
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
