//! Triangles of the same three vertices.

use rustc_hash::FxHashMap;

use super::{Faults, Repair, Work, middle};
use crate::mesh::TriMesh;
use crate::mesh::error::PartWarning;

/// Triangles by their vertices, each with whether it runs them the even way
/// round; those of a repeated corner left out.
fn by_vertices(mesh: &TriMesh) -> FxHashMap<[u32; 3], Vec<(usize, bool)>> {
    let mut found: FxHashMap<[u32; 3], Vec<(usize, bool)>> = FxHashMap::default();
    for (index, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if a == b || b == c || c == a {
            continue;
        }
        let mut key = [a, b, c];
        key.sort_unstable();
        let even = [key, [key[1], key[2], key[0]], [key[2], key[0], key[1]]].contains(&[a, b, c]);
        found.entry(key).or_default().push((index, even));
    }
    found
}

/// Drops triangles that are there twice the same way round, if fewer edges are
/// wrong without.
pub(super) fn drop_repeated(work: &mut Work) -> Option<Repair> {
    drop(work, |same| {
        let mut seen = [false; 2];
        let again =
            |&&(_, even): &&(usize, bool)| std::mem::replace(&mut seen[usize::from(even)], true);
        same.iter().filter(again).map(|&(index, _)| index).collect()
    })
}

/// Drops pairs of triangles that lie on each other, back to back: they enclose
/// nothing, and no edge gets fewer ways in one direction than in the other.
pub(super) fn drop_folded(work: &mut Work) -> Option<Repair> {
    drop(work, |same| {
        let (even, odd): (Vec<(usize, bool)>, Vec<_>) = same.iter().partition(|(_, even)| *even);
        let pairs = even.iter().zip(&odd);
        pairs.flat_map(|(a, b)| [a.0, b.0]).collect()
    })
}

/// Drops what is chosen among triangles of the same vertices, unless more edges are
/// wrong then or nothing would be left.
fn drop(work: &mut Work, choose: impl Fn(&[(usize, bool)]) -> Vec<usize>) -> Option<Repair> {
    let mut gone = vec![false; work.mesh.triangles.len()];
    for same in by_vertices(&work.mesh).values().filter(|s| s.len() > 1) {
        for index in choose(same) {
            gone[index] = true;
        }
    }
    let count = gone.iter().filter(|&&gone| gone).count();
    if count == 0 || count == gone.len() {
        return None;
    }
    let rest = TriMesh {
        positions: work.mesh.positions.clone(),
        triangles: (work.mesh.triangles.iter().zip(&gone))
            .filter(|(_, gone)| !**gone)
            .map(|(t, _)| *t)
            .collect(),
    };
    if Faults::of(&rest).all() > Faults::of(&work.mesh).all() {
        return None;
    }
    let places = (work.mesh.triangles.iter().zip(&gone))
        .filter(|(_, gone)| **gone)
        .map(|(t, _)| middle(&work.mesh, *t));
    let repair = Repair::at(PartWarning::Doubled { triangles: count }, places);
    work.retain(|index| !gone[index]);
    Some(repair)
}
