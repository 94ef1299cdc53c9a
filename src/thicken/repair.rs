//! Surfaces as scans and designers leave them, made patches: no vertex moves.

use rustc_hash::FxHashMap;
use serde::Serialize;

use super::fill::fill;
use crate::mesh::{EdgeUses, TriMesh, close_t_junctions};

/// What was done to a surface before it was thickened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Repair {
    /// Triangles with a corner twice were left out.
    Dropped {
        /// How many.
        triangles: usize,
    },
    /// Triangles that looked the other way than their neighbours were turned.
    Turned {
        /// How many.
        triangles: usize,
    },
    /// Triangles with vertices of others on their edges were split there.
    Stitched {
        /// Edges that were split.
        edges: usize,
    },
    /// Holes were closed.
    Filled {
        /// How many.
        holes: usize,
    },
    /// Vertices at which pieces of the surface meet in a point alone were doubled,
    /// so that each piece has its own boundary there.
    Parted {
        /// Vertices added.
        vertices: usize,
    },
}

/// Makes what can be made a patch of a surface; holes whose edge is no longer than
/// `holes` are closed.
pub(super) fn repair(mesh: &mut TriMesh, holes: f64) -> Vec<Repair> {
    let mut repairs = Vec::new();
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let triangles = before - mesh.triangles.len();
    if triangles > 0 {
        repairs.push(Repair::Dropped { triangles });
    }
    let edges = close_t_junctions(mesh);
    if edges > 0 {
        repairs.push(Repair::Stitched { edges });
    }
    let triangles = turn(mesh);
    if triangles > 0 {
        repairs.push(Repair::Turned { triangles });
    }
    let vertices = part(mesh);
    if vertices > 0 {
        repairs.push(Repair::Parted { vertices });
    }
    if holes > 0.0 {
        let holes = fill(mesh, holes);
        if holes > 0 {
            repairs.push(Repair::Filled { holes });
        }
    }
    repairs
}

/// Turns the fewer triangles of each piece so that neighbours agree; none where
/// that cannot be. How many.
fn turn(mesh: &mut TriMesh) -> usize {
    let uses = mesh.edges();
    if uses.census().misoriented == 0 {
        return 0;
    }
    let across = across(mesh, &uses);
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut flips = Vec::new();
    for seed in 0..turned.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut piece = vec![seed];
        let mut next = 0;
        while let Some(&face) = piece.get(next) {
            next += 1;
            for &(other, differs) in &across[face] {
                let wanted = (turned[face] == Some(true)) != differs;
                match turned[other] {
                    Some(found) if found != wanted => return 0,
                    Some(_) => {}
                    None => {
                        turned[other] = Some(wanted);
                        piece.push(other);
                    }
                }
            }
        }
        let (yes, no): (Vec<usize>, Vec<usize>) = piece
            .into_iter()
            .partition(|&face| turned[face] == Some(true));
        flips.extend(if yes.len() <= no.len() { yes } else { no });
    }
    for &face in &flips {
        mesh.triangles[face].swap(1, 2);
    }
    flips.len()
}

/// By triangle: its neighbours across edges of two, and whether those run it the
/// same way.
fn across(mesh: &TriMesh, uses: &EdgeUses) -> Vec<Vec<(usize, bool)>> {
    let mut across = vec![Vec::new(); mesh.triangles.len()];
    for pair in uses.by_edge().filter(|uses| uses.len() == 2) {
        let [a, b] = [pair[0], pair[1]];
        let differs = a.forward == b.forward;
        across[a.face.index()].push((b.face.index(), differs));
        across[b.face.index()].push((a.face.index(), differs));
    }
    across
}

/// Gives each fan of triangles around a vertex a vertex of its own; the first
/// keeps it, further ones come last. How many were added.
fn part(mesh: &mut TriMesh) -> usize {
    // Corners that hang together across edges at their vertex.
    let corner = |face: usize, k: usize| 3 * face + k;
    let mut root: Vec<u32> = (0..3 * mesh.triangles.len() as u32).collect();
    fn find(root: &mut [u32], mut at: u32) -> u32 {
        while root[at as usize] != at {
            root[at as usize] = root[root[at as usize] as usize];
            at = root[at as usize];
        }
        at
    }
    for pair in mesh.edges().by_edge().filter(|uses| uses.len() >= 2) {
        for v in pair[0].edge {
            let at = |face: usize| mesh.triangles[face].iter().position(|&u| u == v);
            for two in pair.windows(2) {
                let [f, g] = [two[0].face.index(), two[1].face.index()];
                if let (Some(i), Some(j)) = (at(f), at(g)) {
                    let a = find(&mut root, corner(f, i) as u32);
                    let b = find(&mut root, corner(g, j) as u32);
                    root[a.max(b) as usize] = a.min(b);
                }
            }
        }
    }
    let mut first: FxHashMap<u32, u32> = FxHashMap::default();
    let mut added: FxHashMap<u32, u32> = FxHashMap::default();
    let before = mesh.positions.len();
    for face in 0..mesh.triangles.len() {
        for k in 0..3 {
            let v = mesh.triangles[face][k];
            let fan = find(&mut root, corner(face, k) as u32);
            if *first.entry(v).or_insert(fan) == fan {
                continue;
            }
            let new = *added.entry(fan).or_insert_with(|| {
                mesh.positions.push(mesh.positions[v as usize]);
                mesh.positions.len() as u32 - 1
            });
            mesh.triangles[face][k] = new;
        }
    }
    mesh.positions.len() - before
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_bow_tie_is_parted_and_turned() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mut mesh = TriMesh {
            positions: vec![
                at(0.0, 0.0),
                at(1.0, 1.0),
                at(1.0, -1.0),
                at(2.0, 0.0),
                at(-1.0, -1.0),
                at(-1.0, 1.0),
            ],
            // The second looks the other way than the first; the third touches
            // them in a point; the fourth is none.
            triangles: vec![[0, 2, 1], [2, 1, 3], [0, 5, 4], [5, 5, 4]],
        };
        let repairs = repair(&mut mesh, 0.0);
        let expected = [
            Repair::Dropped { triangles: 1 },
            Repair::Turned { triangles: 1 },
            Repair::Parted { vertices: 1 },
        ];
        assert_eq!(repairs, expected);
        assert_eq!(mesh.positions.len(), 7);
        assert_eq!(mesh.triangles[2], [6, 5, 4]);
        assert_eq!(mesh.edges().census().misoriented, 0);
    }
}
