//! The walk over the lattice: solves edges, faces and tetrahedra wherever the
//! mid-surface leads.
//!
//! The paper walks cell by cell and keeps all. Here the lattice is cut into
//! cubic *blocks*, and a block is walked by one thread, which keeps the edges
//! and faces of that block alone; what is left of it is a compact [`Piece`].
//! Where the mid-surface leaves a block, the neighbour is entered next. Faces
//! between two blocks are solved in both: what a simplex holds follows from its
//! key alone (see [`store`]), so both find the same, to the last bit, and the
//! pieces join by key. So the mesh depends neither on the size of the blocks,
//! nor on their order, nor on the number of threads, and the memory taken
//! beside the result is that of the blocks at work.
//!
//! [`store`]: self::store

mod answer;
mod asked;
mod piece;
mod store;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use self::asked::{Asked, Asks};
pub use self::piece::Piece;
use self::piece::join;
use self::store::{Effort, Store, is_crossed};
use crate::lattice::{BlockKey, FaceKey, Lattice, TetKey};
use crate::mesh::FaceId;
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::surface::marked::MarkedMesh;
use crate::trace::follow::face::FaceContours;
use crate::trace::tet::TetSurface;
use crate::trace::tolerances::Tolerances;
use crate::walls::Walls;
use crate::walls::thickness::{maximal_ball, spread};

/// Counts of what the walk took.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Counts {
    /// Lattice cells that hold a piece of the mid-surface.
    pub cells: usize,
    /// Tetrahedra solved.
    pub tetrahedra: usize,
    /// Faces solved; one between two blocks counts in both.
    pub faces: usize,
    /// Lattice edges solved, counted alike.
    pub edges: usize,
    /// Closest-point queries in all.
    pub queries: u64,
    /// Closest-point queries a lattice edge, its nodes included.
    pub queries_per_edge: f64,
    /// Places where a follower could not go on; they show as cracks unless
    /// they closed otherwise.
    pub lost: usize,
    /// Loops closed by matching what was left open, where a curve was lost or
    /// a sheet stops being one on the way.
    pub matched: usize,
    /// Faces that still changed when the rounds were over: two followers
    /// that do not agree.
    pub unsettled: usize,
}

/// Cells along the edge of a block, as a power of two. Of a block of 16 cells
/// the store stays in a core's cache, and one face in twelve is solved twice.
pub const BLOCK_BITS: u32 = 4;

/// The lattice walk over one part.
pub struct Tracer<'a> {
    walls: &'a Walls<'a>,
    lattice: Lattice,
    bits: u32,
    /// Tetrahedra that were entered, ascending, by block.
    reached: FxHashMap<BlockKey, Vec<TetKey>>,
    asked: Asked,
    pieces: Vec<Piece>,
    /// Tetrahedra of which the pieces are out of date.
    stale: FxHashSet<TetKey>,
    troubles: Troubles,
    effort: Effort,
    unsettled: usize,
}

/// Places lost and loops matched, by who met them. The last word counts.
#[derive(Default)]
struct Troubles {
    faces: FxHashMap<FaceKey, [u32; 2]>,
    tets: FxHashMap<TetKey, [u32; 2]>,
}

impl Troubles {
    fn of_face(&mut self, key: FaceKey, face: &FaceContours) {
        note(&mut self.faces, key, [face.lost.len() as u32, face.matched]);
    }

    /// A tetrahedron that could not be solved is one place lost.
    fn of_tet(&mut self, key: TetKey, tet: Option<&TetSurface>) {
        let trouble = tet.map_or([1, 0], |t| [t.open.len() as u32, t.matched]);
        note(&mut self.tets, key, trouble);
    }

    fn append(&mut self, other: Troubles) {
        self.faces.extend(other.faces);
        self.tets.extend(other.tets);
    }

    /// Forgets what was met in some tetrahedra.
    fn forget(&mut self, tets: &[TetKey]) {
        for tet in tets {
            self.tets.remove(tet);
            for face in tet.faces() {
                self.faces.remove(&face);
            }
        }
    }

    fn sum(&self, kind: usize) -> usize {
        let counts = self.faces.values().chain(self.tets.values());
        counts.map(|c| c[kind] as usize).sum()
    }
}

fn note<K: std::hash::Hash + Eq>(all: &mut FxHashMap<K, [u32; 2]>, key: K, trouble: [u32; 2]) {
    if trouble != [0, 0] {
        all.insert(key, trouble);
    }
}

/// A block that was walked.
#[derive(Default)]
struct Walked {
    /// Tetrahedra entered, ascending.
    tets: Vec<TetKey>,
    piece: Piece,
    /// Tetrahedra of other blocks into which the mid-surface leads.
    exits: Vec<TetKey>,
    asks: Asks,
    troubles: Troubles,
    effort: Effort,
}

impl<'a> Tracer<'a> {
    /// A walk with nothing found yet, by blocks of `2^bits` cells along each edge.
    pub fn new(walls: &'a Walls<'a>, lattice: Lattice, bits: u32) -> Tracer<'a> {
        Tracer {
            walls,
            lattice,
            bits,
            reached: FxHashMap::default(),
            asked: Asked::default(),
            pieces: Vec::new(),
            stale: FxHashSet::default(),
            troubles: Troubles::default(),
            effort: Effort::default(),
            unsettled: 0,
        }
    }

    /// Tetrahedra in which the walls' maximal balls have their centres.
    fn seeds(&self) -> Vec<TetKey> {
        let field = self.walls.field();
        let spacing = 3.0 * self.lattice.cell();
        let walls: Vec<FaceId> = (0..field.face_count() as u32)
            .map(FaceId)
            .filter(|&f| !field.is_coping(f))
            .collect();
        let mut tets: Vec<TetKey> = walls
            .par_iter()
            .flat_map_iter(|&face| {
                spread(field.corners(face), spacing, 64)
                    .filter_map(move |p| maximal_ball(field, face, p))
            })
            .map(|(centre, _)| self.lattice.locate(centre))
            .collect();
        tets.par_sort_unstable();
        tets.dedup();
        tets
    }

    /// Follows the mid-surface from tetrahedron to tetrahedron until nothing is
    /// left to follow, or until asked to stop; what was found by then is of no
    /// use.
    ///
    /// First all is entered to which contours lead. Then what solved simplices
    /// ask of others is answered in rounds, all at once in each: so it does not
    /// matter who was solved first. The rounds end because they only ever add: a
    /// seed or a crossing that is there already, to a tolerance, asks for
    /// nothing. Where they lead on, the walk is taken up again.
    pub fn run(&mut self, progress: &Progress, stop: &Stop) -> Result<(), Stopped> {
        let mut frontier = self.seeds();
        while !frontier.is_empty() {
            let asks = self.walk(frontier, progress, stop)?;
            frontier = self.answer(asks, stop)?;
        }
        self.renew(stop)
    }

    fn is_reached(&self, tet: TetKey) -> bool {
        let block = self.reached.get(&tet.block(self.bits));
        block.is_some_and(|tets| tets.binary_search(&tet).is_ok())
    }

    fn store(&self) -> Store<'_> {
        Store::new(self.walls, self.lattice, &self.asked)
    }

    fn same_point(&self) -> f64 {
        Tolerances::new(self.walls.tolerances(), self.lattice.cell()).same_point
    }

    /// Enters every tetrahedron to which contours lead from a frontier, block by
    /// block; returns what they ask.
    fn walk(
        &mut self,
        frontier: Vec<TetKey>,
        progress: &Progress,
        stop: &Stop,
    ) -> Result<Asks, Stopped> {
        let mut asks = Asks::default();
        let mut entries = frontier;
        let done = AtomicU64::new(0);
        let mut expected = 0;
        while !entries.is_empty() {
            let mut blocks: BTreeMap<BlockKey, Vec<TetKey>> = BTreeMap::new();
            for tet in entries {
                blocks.entry(tet.block(self.bits)).or_default().push(tet);
            }
            let blocks: Vec<(BlockKey, Vec<TetKey>)> = blocks.into_iter().collect();
            expected += blocks.len() as u64;
            let this = &*self;
            let walked: Vec<Walked> = (blocks.par_iter())
                .map_init(
                    || this.store(),
                    |store, (block, entries)| {
                        let walked = this.walk_block(store, *block, entries, stop)?;
                        let done = 1 + done.fetch_add(1, Ordering::Relaxed);
                        progress("trace", done, expected);
                        Ok(walked)
                    },
                )
                .collect::<Result<_, Stopped>>()?;
            let mut exits = Vec::new();
            for ((block, _), walked) in blocks.into_iter().zip(walked) {
                let tets = self.reached.entry(block).or_default();
                tets.extend(walked.tets);
                tets.sort_unstable();
                tets.shrink_to_fit();
                exits.extend(walked.exits);
                self.pieces.push(walked.piece);
                asks.append(walked.asks);
                self.troubles.append(walked.troubles);
                self.effort.add(walked.effort);
            }
            exits.par_sort_unstable();
            exits.dedup();
            exits.retain(|&t| !self.is_reached(t));
            entries = exits;
        }
        asks.sort();
        Ok(asks)
    }

    fn walk_block(
        &self,
        store: &mut Store,
        block: BlockKey,
        entries: &[TetKey],
        stop: &Stop,
    ) -> Result<Walked, Stopped> {
        let known = self.reached.get(&block).map_or(&[][..], |tets| tets);
        let mut out = Walked::default();
        let mut seen: FxHashSet<TetKey> = FxHashSet::default();
        let mut open: Vec<TetKey> = entries.iter().rev().copied().collect();
        while let Some(tet) = open.pop() {
            if tet.block(self.bits) != block {
                out.exits.push(tet);
                continue;
            }
            if known.binary_search(&tet).is_ok() || !seen.insert(tet) {
                continue;
            }
            if seen.len() % 64 == 0 {
                stop.heed()?;
            }
            for face in tet.faces() {
                if is_crossed(store.face(face)) {
                    open.extend(face.tetrahedra().filter(|t| !seen.contains(t)));
                }
            }
        }
        out.exits.sort_unstable();
        out.exits.dedup();
        out.tets = seen.into_iter().collect();
        out.tets.sort_unstable();
        let mut solved: Vec<(TetKey, TetSurface)> = Vec::with_capacity(out.tets.len());
        for (n, &key) in out.tets.iter().enumerate() {
            if n % 64 == 0 {
                stop.heed()?;
            }
            for face in key.faces() {
                let contours = store.face(face);
                out.troubles.of_face(face, contours);
                out.asks.of_face(face, contours);
            }
            // One of which a face asks for more is solved once that is there.
            if let Some(surface) = store.tet(key) {
                out.troubles.of_tet(key, Some(&surface));
                out.asks.of_tet(key, &surface);
                solved.push((key, surface));
            }
        }
        out.piece = Piece::new(store, &solved);
        out.effort = store.clear();
        Ok(out)
    }

    /// Counts of the work done.
    pub fn counts(&self) -> Counts {
        Counts {
            cells: Piece::cells(&self.pieces),
            tetrahedra: self.reached.values().map(Vec::len).sum(),
            faces: self.effort.faces,
            edges: self.effort.edges,
            queries: self.effort.queries,
            queries_per_edge: self.effort.edge_queries as f64 / self.effort.edges.max(1) as f64,
            lost: self.troubles.sum(0),
            matched: self.troubles.sum(1),
            unsettled: self.unsettled,
        }
    }

    /// Joins the pieces of all tetrahedra to one mesh, vertices numbered in
    /// the order of their keys.
    pub fn assemble(self) -> MarkedMesh {
        let Tracer { pieces, .. } = self;
        let mut mesh = join(pieces);
        mesh.drop_pillows();
        mesh.drop_stray_lines();
        mesh
    }
}
