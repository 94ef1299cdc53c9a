//! Small flat holes filled.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::{Faults, Repair, Work, open_runs};
use crate::mesh::edges::EdgeUses;
use crate::mesh::error::PartWarning;
use crate::mesh::polygon::{MOST_CORNERS, triangulate};
use crate::mesh::{Bounds, TriMesh};

/// Corners of a hole lie in a plane if none is farther from it than this share of
/// the hole's diagonal.
const FLAT: f64 = 1e-3;

/// A hole is small if it has no more than this share of the mesh's area. One that
/// lacks a single triangle may have any.
const SMALL: f64 = 0.01;

/// Fills holes whose border is one simple loop, flat and small.
pub(super) fn fill(work: &mut Work, uses: &EdgeUses) -> Option<Repair> {
    let area = work.mesh.area();
    let mut tests = 0;
    let mut added = Vec::new();
    let mut places = Vec::new();
    for Hole { ring, beside } in holes(uses) {
        let mut triangles = Vec::new();
        let fits = ring.len() == 3 || is_flat(&work.mesh, &ring);
        if !fits || !triangulate(&ring, &work.mesh.positions, &mut triangles, &mut tests) {
            continue;
        }
        let filling = TriMesh {
            positions: work.mesh.positions.clone(),
            triangles,
        };
        if ring.len() > 3 && filling.area() > SMALL * area {
            continue;
        }
        places.push(Bounds::of(points(&work.mesh, &ring)).center());
        let origin = work.origin[beside];
        added.extend(filling.triangles.into_iter().map(|t| (origin, t)));
    }
    if added.is_empty() {
        return None;
    }
    let before = Faults::of(&work.mesh).all();
    let kept = (work.mesh.triangles.clone(), work.origin.clone());
    let triangles = added.len();
    work.insert(added);
    if Faults::of(&work.mesh).all() >= before {
        (work.mesh.triangles, work.origin) = kept;
        return None;
    }
    let holes = places.len();
    Some(Repair::at(PartWarning::Filled { holes, triangles }, places))
}

struct Hole {
    /// Around it as a filling triangle runs.
    ring: Vec<u32>,
    /// A triangle at its border.
    beside: usize,
}

/// Loops of open edges through vertices of one loop only.
fn holes(uses: &EdgeUses) -> Vec<Hole> {
    let runs = open_runs(uses);
    // From the end of a run to its start: the way a filling goes.
    let mut next: FxHashMap<u32, (u32, usize)> = FxHashMap::default();
    let mut ways: FxHashMap<u32, usize> = FxHashMap::default();
    for &([from, to], face) in &runs {
        next.insert(to, (from, face));
        *ways.entry(to).or_default() += 1;
    }
    let mut seen = rustc_hash::FxHashSet::default();
    let mut holes = Vec::new();
    for &([_, start], beside) in &runs {
        let mut ring = Vec::new();
        let mut here = start;
        while ways.get(&here) == Some(&1) && ring.len() < MOST_CORNERS && seen.insert(here) {
            ring.push(here);
            here = next[&here].0;
        }
        if here == start && ring.len() >= 3 {
            holes.push(Hole { ring, beside });
        }
    }
    holes
}

fn points<'m>(mesh: &'m TriMesh, ring: &'m [u32]) -> impl Iterator<Item = DVec3> + Clone + 'm {
    ring.iter().map(|&v| mesh.positions[v as usize])
}

/// Whether a ring lies in the plane of its Newell normal.
fn is_flat(mesh: &TriMesh, ring: &[u32]) -> bool {
    let bounds = Bounds::of(points(mesh, ring));
    let centre = bounds.center();
    let next = points(mesh, ring).cycle().skip(1);
    let normal: DVec3 = (points(mesh, ring).zip(next))
        .map(|(a, b)| (a - centre).cross(b - centre))
        .sum();
    let middle = points(mesh, ring).sum::<DVec3>() / ring.len() as f64;
    let normal = normal.normalize_or_zero();
    points(mesh, ring).all(|p| (p - middle).dot(normal).abs() <= FLAT * bounds.diagonal())
        && normal != DVec3::ZERO
}
