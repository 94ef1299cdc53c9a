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
mod packed;
mod piece;
mod store;
#[cfg(test)]
mod tests;
pub(crate) mod wire;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use self::asked::{Asked, Asks};
pub use self::piece::Piece;
use self::piece::join;
use self::store::{Effort, Store, is_crossed};
use crate::lattice::{BlockKey, CellBox, FaceKey, Lattice, TetKey};
use crate::mesh::FaceId;
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::surface::marked::MarkedMesh;
use crate::trace::follow::face::{FaceContours, FaceNodeKind};
use crate::trace::tet::TetSurface;
use crate::trace::tolerances::Tolerances;
use crate::walls::Walls;
use crate::walls::thickness::{maximal_ball, spread};

/// Counts of what the walk took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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
    /// Borders where no wall ends: following was lost between walls that are
    /// separate, in a face whose small triangles did not tell how it goes on,
    /// or on a seam through a tetrahedron.
    pub torn: usize,
    /// Faces that still changed when the rounds were over: two followers
    /// that do not agree.
    pub unsettled: usize,
}

impl Counts {
    /// Adds the work of another walk, which a file may tell of.
    pub fn add(&mut self, other: &Counts) {
        let asked = |c: &Counts| c.queries_per_edge * c.edges as f64;
        let edges = (self.edges.saturating_add(other.edges)).max(1) as f64;
        self.queries_per_edge = (asked(self) + asked(other)) / edges;
        self.cells = self.cells.saturating_add(other.cells);
        self.tetrahedra = self.tetrahedra.saturating_add(other.tetrahedra);
        self.faces = self.faces.saturating_add(other.faces);
        self.edges = self.edges.saturating_add(other.edges);
        self.queries = self.queries.saturating_add(other.queries);
        self.lost = self.lost.saturating_add(other.lost);
        self.matched = self.matched.saturating_add(other.matched);
        self.torn = self.torn.saturating_add(other.torn);
        self.unsettled = self.unsettled.saturating_add(other.unsettled);
    }
}

/// Cells along the edge of a block, as a power of two. Of a block of 16 cells
/// the store stays in a core's cache, and one face in twelve is solved twice.
pub const BLOCK_BITS: u32 = 4;

/// Bytes that an active cell takes as long as its block is open.
const BYTES_PER_OPEN_CELL: f64 = 10_000.0;

/// Blocks such that those that all threads have open take an eighth of some
/// memory at most, or as small as blocks get.
pub fn block_bits(memory: u64) -> u32 {
    let threads = rayon::current_num_threads() as f64;
    let cells = memory as f64 / (8.0 * threads * BYTES_PER_OPEN_CELL);
    // Three sheets through a block cross three times the cells of its side.
    let side = (cells / 3.0).sqrt();
    side.log2().floor().clamp(1.0, f64::from(BLOCK_BITS)) as u32
}

/// The lattice walk over one part.
pub struct Tracer<'a> {
    walls: &'a Walls<'a>,
    lattice: Lattice,
    bits: u32,
    /// Cells that the walk stays in.
    within: CellBox,
    /// Tetrahedra to which no seed within them leads.
    cut_in: Vec<TetKey>,
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

/// Places lost, loops matched and borders torn, by who met them. The last word counts.
#[derive(Default)]
struct Troubles {
    faces: FxHashMap<FaceKey, [u32; 3]>,
    tets: FxHashMap<TetKey, [u32; 3]>,
}

impl Troubles {
    fn of_face(&mut self, key: FaceKey, face: &FaceContours) {
        let torn = face.nodes.iter().filter(|n| n.kind == FaceNodeKind::Torn);
        let trouble = [face.lost.len() as u32, face.matched, torn.count() as u32];
        note(&mut self.faces, key, trouble);
    }

    /// A tetrahedron that could not be solved is one place lost.
    fn of_tet(&mut self, key: TetKey, tet: Option<&TetSurface>) {
        let trouble = tet.map_or([1, 0, 0], |t| [t.open.len() as u32, t.matched, t.torn]);
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

fn note<K: std::hash::Hash + Eq>(all: &mut FxHashMap<K, [u32; 3]>, key: K, trouble: [u32; 3]) {
    if trouble != [0; 3] {
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
            within: CellBox::ALL,
            cut_in: Vec::new(),
            reached: FxHashMap::default(),
            asked: Asked::default(),
            pieces: Vec::new(),
            stale: FxHashSet::default(),
            troubles: Troubles::default(),
            effort: Effort::default(),
            unsettled: 0,
        }
    }

    /// Stays within a box of cells.
    pub fn within(mut self, cells: CellBox) -> Tracer<'a> {
        self.within = cells;
        self
    }

    /// Tetrahedra in which the walls' maximal balls have their centres.
    pub fn seeds(&self) -> Vec<TetKey> {
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
        let mut seeds = self.seeds();
        seeds.retain(|&t| self.within.contains(t));
        let mut asks = self.walk(seeds, progress, stop)?;
        let by_seeds = self.pieces.len();
        let mut entries = self.cut_contours(stop)?;
        entries.retain(|&t| !self.is_reached(t));
        asks.append(self.walk(entries, progress, stop)?);
        asks.sort();
        self.cut_in = (self.pieces[by_seeds..].iter())
            .flat_map(Piece::tets)
            .collect();
        loop {
            let frontier = self.answer(asks, stop)?;
            if frontier.is_empty() {
                return self.renew(stop);
            }
            asks = self.walk(frontier, progress, stop)?;
        }
    }

    /// Tetrahedra from which contours lead out of the box that the walk stays
    /// in: there it enters what no seed within the box leads to.
    fn cut_contours(&mut self, stop: &Stop) -> Result<Vec<TetKey>, Stopped> {
        let field = self.walls.field();
        let (low, high) = field.bounds();
        let all = self.lattice.cells(low, high);
        let within = self.within;
        let inside = |centre, radius: f64| field.signed_clearance(centre) > -radius;
        let rim = within.rim(&self.lattice, &all, inside);
        let entries = self.solve_again(&rim, stop, |store, tets| {
            let mut leads_out = |tet: &TetKey| {
                let mut faces = tet.faces().into_iter();
                faces.any(|face| {
                    let out = face.tetrahedra().any(|t| !within.contains(t));
                    out && is_crossed(store.face(face))
                })
            };
            let tets = tets.iter().copied();
            tets.filter(|t| leads_out(t)).collect::<Vec<_>>()
        })?;
        Ok(entries.into_iter().flatten().collect())
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
            exits.retain(|&t| self.within.contains(t) && !self.is_reached(t));
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
            if seen.len().is_multiple_of(64) {
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
            if n.is_multiple_of(64) {
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
            torn: self.troubles.sum(2),
            unsettled: self.unsettled,
        }
    }

    /// Joins the pieces of all tetrahedra to one mesh.
    pub fn assemble(self) -> MarkedMesh {
        assemble(self.pieces)
    }

    /// What was found in some of the cells that the walk stayed in.
    pub fn share(self, cells: &CellBox) -> Share {
        let keep = |t: TetKey| cells.contains(t);
        let pieces = self.pieces.into_par_iter();
        Share {
            pieces: pieces.map(|p| p.retained(keep)).collect(),
            cut_in: self.cut_in.into_iter().filter(|&t| keep(t)).collect(),
        }
    }
}

/// What a walk within some cells found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Share {
    /// The mid-surface there.
    pub pieces: Vec<Piece>,
    /// Tetrahedra to which no seed in the surroundings leads; they count if the
    /// mid-surface of other shares comes there.
    pub cut_in: Vec<TetKey>,
}

/// Joins pieces to one mesh, vertices numbered in the order of their keys.
fn assemble(pieces: Vec<Piece>) -> MarkedMesh {
    let mut mesh = join(pieces);
    mesh.drop_pillows();
    mesh.drop_stray_lines();
    mesh
}

impl Share {
    /// Joins shares to one mesh. None where two of them know a vertex apart.
    pub fn join(shares: Vec<Share>) -> Option<(MarkedMesh, usize)> {
        let (mut pieces, mut cut_in) = (Vec::new(), Vec::new());
        for mut share in shares {
            pieces.append(&mut share.pieces);
            cut_in.append(&mut share.cut_in);
        }
        let apart = piece::unreached(&pieces, cut_in);
        if !apart.is_empty() {
            let keep = |t: TetKey| !apart.contains(&t);
            pieces = (pieces.into_par_iter()).map(|p| p.retained(keep)).collect();
        }
        let cells = Piece::cells(&pieces);
        piece::agree(&pieces).then(|| (assemble(pieces), cells))
    }
}
