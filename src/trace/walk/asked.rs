//! What followers found beyond what their simplex was solved from.
//!
//! A curve that a 3D follower meets is seen first inside a tetrahedron, when it
//! comes out through a face; but the vertex there belongs to the face, which
//! both its tetrahedra read. So the tetrahedron only leaves a *seed*, and the
//! face is solved again with it, its contours starting from the new vertex. In
//! the same way a contour that arrives at an edge where no vertex is known
//! leaves one there, and all faces round the edge are solved again.
//!
//! This is rare. So it is all that a walk keeps of what it solved: with it
//! every face and tetrahedron can be solved again, anywhere and at any time.

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::field::Field;
use crate::lattice::{EdgeKey, FaceKey, Lattice, TetKey};
use crate::trace::edge::Crossing;
use crate::trace::follow::face::{FaceContours, FaceSeed};
use crate::trace::follow::fan::alike;
use crate::trace::tet::TetSurface;

/// Vertices and seeds that were asked for.
#[derive(Default)]
pub(super) struct Asked {
    edges: FxHashMap<EdgeKey, SmallVec<[Crossing; 1]>>,
    seeds: FxHashMap<FaceKey, Vec<FaceSeed>>,
}

/// A face asks for a further vertex on one of its edges.
pub(super) type CrossingAsk = (FaceKey, EdgeKey, Crossing);

/// A tetrahedron asks for a seed in one of its faces.
pub(super) type SeedAsk = (TetKey, FaceKey, FaceSeed);

/// What solved simplices ask of others.
#[derive(Default)]
pub(super) struct Asks {
    pub(super) crossings: Vec<CrossingAsk>,
    pub(super) seeds: Vec<SeedAsk>,
}

impl Asks {
    pub(super) fn of_face(&mut self, key: FaceKey, face: &FaceContours) {
        let edges = key.edges();
        let ask = |&(side, crossing): &(u8, Crossing)| (key, edges[side as usize], crossing);
        self.crossings.extend(face.found.iter().map(ask));
    }

    pub(super) fn of_tet(&mut self, key: TetKey, tet: &TetSurface) {
        let ask = |&(face, seed): &(FaceKey, FaceSeed)| (key, face, seed);
        self.seeds.extend(tet.seeds.iter().map(ask));
    }

    pub(super) fn append(&mut self, mut other: Asks) {
        self.crossings.append(&mut other.crossings);
        self.seeds.append(&mut other.seeds);
    }

    /// In the order of who asks; a face on the rim of a block asks in each of
    /// the two, and counts once.
    pub(super) fn sort(&mut self) {
        self.crossings.sort_by_key(|a| (a.0, a.1));
        self.crossings.dedup();
        self.seeds.sort_by_key(|a| a.0);
    }
}

impl Asked {
    /// All vertices of an edge that has more than were solved there.
    pub(super) fn edge(&self, key: EdgeKey) -> Option<&SmallVec<[Crossing; 1]>> {
        self.edges.get(&key)
    }

    /// Seeds in a face.
    pub(super) fn seeds(&self, key: FaceKey) -> &[FaceSeed] {
        self.seeds.get(&key).map_or(&[], |seeds| seeds)
    }

    /// Adds a vertex to an edge, `solved` those that it has by itself. False if
    /// it is there already.
    pub(super) fn add_crossing(
        &mut self,
        field: &Field,
        lattice: &Lattice,
        near: f64,
        (edge, crossing): (EdgeKey, Crossing),
        solved: impl FnOnce() -> SmallVec<[Crossing; 1]>,
    ) -> bool {
        let low = lattice.position(edge.nodes()[0]);
        let list = self.edges.entry(edge).or_insert_with(solved);
        let same = |c: &Crossing| {
            c.at.distance(crossing.at) <= near && alike(field, crossing.at, c.walls, crossing.walls)
        };
        if list.iter().any(same) {
            return false;
        }
        // In the order along the edge, whoever found it.
        let place = |c: &Crossing| c.at.distance(low);
        let after = list.partition_point(|c| place(c) <= place(&crossing));
        list.insert(after, crossing);
        true
    }

    /// Adds a seed to a face; false if one is there already.
    pub(super) fn add_seed(&mut self, near: f64, face: FaceKey, seed: FaceSeed) -> bool {
        let list = self.seeds.entry(face).or_default();
        let new = list.iter().all(|s| s.at.distance(seed.at) > near);
        if new {
            list.push(seed);
        }
        new
    }
}
