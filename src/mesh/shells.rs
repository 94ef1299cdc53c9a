//! Closed shells, and how they nest.
//!
//! A part may have several: bodies side by side, and cavities, whose shells look
//! inwards. Some programs write every shell outwards. Here all are read one
//! way: a shell that lies in an odd number of others bounds a cavity, one that
//! lies in an even number bounds a body.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::edges::{EdgeKind, EdgeUses, kind};
use super::error::PartWarning;
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
pub(super) fn turn_by_nesting(mesh: &mut TriMesh, uses: &EdgeUses) -> Vec<PartWarning> {
    let shells = closed_shells(mesh, uses);
    if shells.len() < 2 {
        return Vec::new();
    }
    let Some(depths) = depths(mesh, &shells) else {
        let shells = shells.len();
        return vec![PartWarning::ShellsUnchecked { shells }];
    };
    let mut stray = Turned::default();
    let mut nested = Turned::default();
    let mut wrong = Vec::new();
    for (index, (shell, depth)) in shells.iter().zip(depths).enumerate() {
        let wanted = depth % 2 == 0;
        if (shell.volume >= 0.0) == wanted {
            continue;
        }
        if depth == 0 {
            stray.add(shell);
        } else if !meets_another(mesh, &shells, index) {
            nested.add(shell);
        } else {
            continue;
        }
        wrong.push(index);
    }
    for face in wrong.into_iter().flat_map(|index| &shells[index].faces) {
        mesh.triangles[face.index()].swap(1, 2);
    }
    let stray = (stray.shells > 0).then_some(PartWarning::ShellsTurned {
        shells: stray.shells,
        triangles: stray.triangles,
    });
    let nested = (nested.shells > 0).then_some(PartWarning::ShellsNested {
        shells: nested.shells,
        triangles: nested.triangles,
    });
    stray.into_iter().chain(nested).collect()
}

#[derive(Default)]
struct Turned {
    shells: usize,
    triangles: usize,
}

impl Turned {
    fn add(&mut self, shell: &Shell) {
        self.shells += 1;
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

/// Whether a shell cuts or touches another one, vertices in common included.
fn meets_another(mesh: &TriMesh, shells: &[Shell], index: usize) -> bool {
    let shell = &shells[index];
    let near = |face: &FaceId| Bounds::of(mesh.corners(*face)).meets(&shell.bounds);
    let others = shells
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != index);
    let others = others
        .flat_map(|(_, other)| &other.faces)
        .filter(|f| near(f));
    let faces: Vec<FaceId> = shell.faces.iter().chain(others).copied().collect();
    let own = shell.faces.len();
    let soup = TriMesh {
        positions: faces.iter().flat_map(|&face| mesh.corners(face)).collect(),
        triangles: (0..faces.len() as u32)
            .map(|k| [3 * k, 3 * k + 1, 3 * k + 2])
            .collect(),
    };
    let places = weld_exact(&soup.positions).new_index;
    let (ours, theirs) = places.split_at(3 * own);
    let ours: FxHashSet<u32> = ours.iter().copied().collect();
    let crosses = |(a, b): &(FaceId, FaceId)| (a.index() < own) != (b.index() < own);
    theirs.iter().any(|place| ours.contains(place)) || self_intersections(&soup).iter().any(crosses)
}

impl Part {
    /// Whether closed shells of the part cut or touch each other.
    pub fn bodies_meet(&self) -> bool {
        let shells = closed_shells(&self.mesh, &self.mesh.edges());
        let near = |index: usize| {
            let bounds = &shells[index].bounds;
            let others = shells[..index].iter();
            others.into_iter().any(|other| other.bounds.meets(bounds))
        };
        shells.len() <= MOST_SHELLS
            && (0..shells.len())
                .any(|index| near(index) && meets_another(&self.mesh, &shells, index))
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
            mesh: super::checks::drop_unused(mesh),
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
