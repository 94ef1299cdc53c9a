//! Answers to what solved simplices ask of others; see [`Asked`].
//!
//! Each round answers all that was asked in the one before, in the order of the
//! keys of who asks, and solves again what that changes. What a simplex holds
//! after so many rounds thus depends on what lies so many simplices around it,
//! and on nothing else.

use rayon::prelude::*;

use super::asked::{Asked, Asks, CrossingAsk, SeedAsk};
use super::piece::Piece;
use super::store::{Effort, Store, is_crossed};
use super::{Tracer, Troubles};
use crate::lattice::{FaceKey, TetKey};
use crate::settings::progress::{Stop, Stopped};
use crate::trace::tet::TetSurface;

/// Rounds of asking neighbours again after which the walk goes on. Each adds
/// a vertex that was missing on an edge or in a face, and a face seldom lacks
/// more than two; what is left is told.
const MOST_ROUNDS: usize = 24;

/// Simplices that one thread solves again at a time.
const CHUNK: usize = 128;

impl Tracer<'_> {
    /// Grants what was asked for, and solves again what that changes, until
    /// nothing is asked. Returns tetrahedra that only now are led to.
    pub(super) fn answer(&mut self, asks: Asks, stop: &Stop) -> Result<Vec<TetKey>, Stopped> {
        let mut changed = self.settle(asks.crossings, stop)?;
        let mut tets = self.beside(&changed);
        // Tetrahedra at changed faces ask anew.
        let mut seeds = asks.seeds;
        seeds.retain(|s| tets.binary_search(&s.0).is_err());
        for round in 0.. {
            seeds.extend(self.seeds_asked(&tets, stop)?);
            seeds.sort_by_key(|s| s.0);
            self.stale.extend(&tets);
            if round == MOST_ROUNDS {
                self.unsettled += seeds.len();
                break;
            }
            let faces = self.sow(std::mem::take(&mut seeds));
            if faces.is_empty() {
                break;
            }
            let found = self.crossings_asked(&faces, stop)?;
            let mut touched = self.settle(found, stop)?;
            touched.extend(&faces);
            tets = self.beside(&touched);
            changed.extend(touched);
        }
        self.led_to(changed, stop)
    }

    /// Plants seeds; returns the faces that got one, ascending.
    fn sow(&mut self, seeds: Vec<SeedAsk>) -> Vec<FaceKey> {
        let near = self.same_point();
        let mut faces = Vec::new();
        for (_, face, seed) in seeds {
            if self.asked.add_seed(near, face, seed) {
                faces.push(face);
            }
        }
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// Puts vertices on edges until no face asks for more; returns the faces
    /// that changed, ascending.
    fn settle(
        &mut self,
        mut found: Vec<CrossingAsk>,
        stop: &Stop,
    ) -> Result<Vec<FaceKey>, Stopped> {
        let near = self.same_point();
        let (walls, lattice) = (self.walls, self.lattice);
        let untouched = Asked::default();
        let mut alone = Store::new(walls, lattice, &untouched);
        let mut changed = Vec::new();
        for round in 0.. {
            if found.is_empty() {
                break;
            }
            if round == MOST_ROUNDS {
                self.unsettled += found.len();
                break;
            }
            let mut faces = Vec::new();
            for (face, edge, crossing) in found {
                let solved = || alone.edge(edge).clone();
                let asked = (edge, crossing);
                if (self.asked).add_crossing(walls.field(), &lattice, near, asked, solved) {
                    faces.extend(edge.faces());
                }
                faces.push(face);
            }
            faces.sort_unstable();
            faces.dedup();
            faces.retain(|f| f.tetrahedra().any(|t| self.is_reached(t)));
            found = self.crossings_asked(&faces, stop)?;
            changed.extend(faces);
        }
        self.effort.add(alone.clear());
        changed.sort_unstable();
        changed.dedup();
        Ok(changed)
    }

    /// Tetrahedra that were entered at some faces, ascending.
    fn beside(&self, faces: &[FaceKey]) -> Vec<TetKey> {
        let mut tets: Vec<TetKey> = (faces.iter())
            .flat_map(|f| f.tetrahedra())
            .filter(|&t| self.is_reached(t))
            .collect();
        tets.sort_unstable();
        tets.dedup();
        tets
    }

    /// Tetrahedra not entered yet to which contours of some faces lead,
    /// ascending.
    fn led_to(&mut self, mut faces: Vec<FaceKey>, stop: &Stop) -> Result<Vec<TetKey>, Stopped> {
        faces.retain(|f| f.tetrahedra().any(|t| !self.is_reached(t)));
        faces.sort_unstable();
        faces.dedup();
        let crossed = self.solve_again(&faces, stop, |store, faces| {
            let crossed = |f: &FaceKey| is_crossed(store.face(*f));
            faces.iter().copied().filter(crossed).collect::<Vec<_>>()
        })?;
        let mut tets: Vec<TetKey> = (crossed.iter().flatten())
            .flat_map(|f| f.tetrahedra())
            .filter(|&t| self.within.contains(t) && !self.is_reached(t))
            .collect();
        tets.sort_unstable();
        tets.dedup();
        Ok(tets)
    }

    /// Vertices on edges for which some faces ask.
    fn crossings_asked(
        &mut self,
        faces: &[FaceKey],
        stop: &Stop,
    ) -> Result<Vec<CrossingAsk>, Stopped> {
        let asks = self.solve_again(faces, stop, |store, faces| {
            let mut asks = Asks::default();
            for &face in faces {
                asks.of_face(face, store.face(face));
            }
            asks.crossings
        })?;
        Ok(asks.into_iter().flatten().collect())
    }

    /// Seeds for which some tetrahedra ask.
    fn seeds_asked(&mut self, tets: &[TetKey], stop: &Stop) -> Result<Vec<SeedAsk>, Stopped> {
        let asks = self.solve_again(tets, stop, |store, tets| {
            let mut asks = Asks::default();
            for &tet in tets {
                if let Some(surface) = store.tet(tet) {
                    asks.of_tet(tet, &surface);
                }
            }
            asks.seeds
        })?;
        Ok(asks.into_iter().flatten().collect())
    }

    /// Replaces what pieces hold of tetrahedra that changed.
    pub(super) fn renew(&mut self, stop: &Stop) -> Result<(), Stopped> {
        let stale = std::mem::take(&mut self.stale);
        if stale.is_empty() {
            return Ok(());
        }
        self.pieces = (std::mem::take(&mut self.pieces).into_par_iter())
            .map(|piece| piece.retained(|t| !stale.contains(&t)))
            .collect();
        let mut tets: Vec<TetKey> = stale.into_iter().collect();
        tets.sort_unstable();
        self.troubles.forget(&tets);
        let renewed = self.solve_again(&tets, stop, |store, tets| {
            let mut troubles = Troubles::default();
            let mut solved: Vec<(TetKey, TetSurface)> = Vec::with_capacity(tets.len());
            for &tet in tets {
                for face in tet.faces() {
                    troubles.of_face(face, store.face(face));
                }
                let surface = store.tet(tet);
                troubles.of_tet(tet, surface.as_ref());
                solved.extend(surface.map(|s| (tet, s)));
            }
            (Piece::new(store, &solved), troubles)
        })?;
        for (piece, troubles) in renewed {
            self.pieces.push(piece);
            self.troubles.append(troubles);
        }
        Ok(())
    }

    /// Solves simplices again, some at a time, answers in their order.
    pub(super) fn solve_again<K: Copy + Sync, R: Send>(
        &mut self,
        keys: &[K],
        stop: &Stop,
        solve: impl Fn(&mut Store, &[K]) -> R + Sync,
    ) -> Result<Vec<R>, Stopped> {
        let this = &*self;
        let done: Vec<(R, Effort)> = (keys.par_chunks(CHUNK))
            .map(|keys| {
                stop.heed()?;
                let mut store = this.store();
                let answer = solve(&mut store, keys);
                Ok((answer, store.clear()))
            })
            .collect::<Result<_, Stopped>>()?;
        let mut answers = Vec::with_capacity(done.len());
        for (answer, effort) in done {
            self.effort.add(effort);
            answers.push(answer);
        }
        Ok(answers)
    }
}
