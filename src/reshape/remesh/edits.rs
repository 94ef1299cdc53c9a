//! Splits, contractions and flips.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::{LEANING, Remesher};
use crate::mesh::FaceId;
use crate::reshape::complex::Rank;
use crate::reshape::facing::{TRUSTED, TURN};
use crate::reshape::shape::{Shape, to_segment, to_triangle};
use crate::surface::marked::MarkedVertex;

/// Edges longer than this, against their target, are split: halves are then
/// as far below the target as the edge was above.
pub(super) const LONG: f64 = 1.4;

/// Edges shorter than this, against their target, are contracted.
const SHORT: f64 = 0.75;

/// Sine of an angle of 25 degrees: good enough for an edit for length's sake.
pub(super) const GOOD: f64 = 0.42;

/// An edit for length's sake may lower the sine of worse angles to this share.
const LOSS: f64 = 0.6;

/// An edit for shape's sake must raise the sine of the worst angle by this.
const GAIN: f64 = 1.03;

/// Sine of an angle of 28 degrees: triangles below are poor.
pub(super) const POOR: f64 = 0.47;

/// No edit makes a triangle flatter, least height over longest edge.
const FLATTEST: f64 = 0.02;

/// Passes of one kind in a round.
const PASSES: usize = 6;

/// What a contraction would do.
pub(super) struct Outcome {
    /// Sine of the worst angle after.
    pub(super) sine: f64,
    /// Sine of the worst angle before, of all triangles concerned.
    pub(super) before: f64,
    /// Longest edge made, against its target.
    pub(super) longest: f64,
}

impl Remesher<'_> {
    /// Edges that are longer or shorter against their target than a bound,
    /// the farthest off first.
    fn edges_off(&self, off: impl Fn(f64) -> bool) -> Vec<(u32, u32)> {
        let mut found: Vec<(f64, (u32, u32))> = (self.complex.edges().into_iter())
            .map(|(a, b)| (self.ratio(a, b), (a, b)))
            .filter(|e| off(e.0))
            .collect();
        let rank = |ratio: f64| -ratio.max(1.0 / ratio);
        found.sort_by(|e, f| rank(e.0).total_cmp(&rank(f.0)).then(e.1.cmp(&f.1)));
        found.into_iter().map(|e| e.1).collect()
    }

    pub(super) fn split_long(&mut self) {
        for _ in 0..PASSES {
            let before = self.edits.split;
            for (a, b) in self.edges_off(|ratio| ratio > LONG) {
                // A longer edge beside it may have been split first.
                let there = self.complex.adjacent(a, b) && !self.is_left(a, b);
                if there && self.ratio(a, b) > LONG {
                    self.split(a, b);
                }
            }
            if self.edits.split == before {
                break;
            }
        }
    }

    fn split(&mut self, a: u32, b: u32) {
        let (vertex, chord) = self.halfway(a, b);
        let new = self.complex.split(a, b, vertex.at);
        self.note_middle([a, b], new, vertex, chord);
        self.edits.split += 1;
    }

    /// Notes the new vertex at the middle of an edge.
    pub(super) fn note_middle(
        &mut self,
        [a, b]: [u32; 2],
        new: u32,
        vertex: MarkedVertex,
        chord: bool,
    ) {
        let place = self.lines.of_edge(a, b).map_or(0.0, |line| {
            let [s, t] = self.lines.span(&self.complex, line, a, b);
            0.5 * (s + t)
        });
        self.lines.split(a, b, new, place);
        self.note_vertex(new, vertex, chord, &[a, b]);
    }

    /// Notes a new vertex of a sheet or line, amid others.
    pub(super) fn note_vertex(
        &mut self,
        new: u32,
        vertex: MarkedVertex,
        chord: bool,
        amid: &[u32],
    ) {
        for size in [&mut self.size, &mut self.fine] {
            let sum: f64 = amid.iter().map(|&v| size[v as usize]).sum();
            size.push(sum / amid.len() as f64);
        }
        self.vertices.push(vertex);
        self.chord.push(chord);
        self.straight.push(None);
        self.normals.push(DVec3::ZERO);
        self.note_normal(new);
    }

    /// The point halfway along an edge, of its line or sheet, and whether it
    /// is on the chord only.
    pub(super) fn halfway(&self, a: u32, b: u32) -> (MarkedVertex, bool) {
        let line = (self.complex.class(a, b)).and_then(|_| self.lines.of_edge(a, b));
        match line {
            Some(line) if !self.frozen => {
                let [s, t] = self.lines.span(&self.complex, line, a, b);
                self.line_point(line, 0.5 * (s + t))
            }
            // A chord of straight walls lies in them.
            _ if self.is_straight(a) || self.is_straight(b) => self.chord_middle(a, b),
            _ => self.middle(a, b),
        }
    }

    /// The point of a sheet halfway along an edge, and whether it is on the
    /// chord only.
    fn middle(&self, a: u32, b: u32) -> (MarkedVertex, bool) {
        let guess = 0.5 * (self.complex.at(a) + self.complex.at(b));
        let mut hints: SmallVec<[FaceId; 12]> = SmallVec::new();
        for v in [a, b] {
            hints.extend_from_slice(&self.vertices[v as usize].walls);
        }
        for (_, c) in self.complex.wings(a, b).into_iter().flatten() {
            hints.extend_from_slice(&self.vertices[c as usize].walls);
        }
        let reach = 0.3 * self.length(a, b);
        let found = self.ground.on_sheet(guess, &hints, reach);
        let turns_none = |v: &MarkedVertex| {
            (self.complex.wings(a, b).into_iter().flatten()).all(|(t, c)| {
                let Some(corners) = self.complex.corners(t) else {
                    return false;
                };
                let old = self.complex.shape(corners);
                [a, b].iter().all(|&end| {
                    let new = self.complex.shape_with(corners, end, v.at);
                    old.flatness < TRUSTED || (new.normal.dot(old.normal) >= TURN && c != end)
                })
            })
        };
        match found.filter(turns_none) {
            Some(vertex) => (vertex, false),
            None => self.chord_middle(a, b),
        }
    }

    fn is_straight(&self, v: u32) -> bool {
        self.straight[v as usize].is_some()
    }

    /// The middle of an edge, said to be on the chord only.
    fn chord_middle(&self, a: u32, b: u32) -> (MarkedVertex, bool) {
        let vertex = MarkedVertex {
            at: 0.5 * (self.complex.at(a) + self.complex.at(b)),
            walls: self.vertices[a as usize].walls.clone(),
            coping: None,
        };
        (vertex, true)
    }

    pub(super) fn contract_short(&mut self) {
        self.contract_shorter(SHORT);
    }

    /// Contracts edges that are shorter than this, against their target.
    pub(super) fn contract_shorter(&mut self, short: f64) {
        for _ in 0..PASSES {
            let before = self.edits.contracted;
            for (a, b) in self.edges_off(|ratio| ratio < short) {
                if !self.complex.adjacent(a, b) {
                    continue;
                }
                let tiny = self.ratio(a, b) < 0.25;
                let acceptable = |o: &Outcome| {
                    o.sine >= (LOSS * o.before).min(GOOD) && (tiny || o.longest <= LONG)
                };
                let options = [(a, b), (b, a)].map(|(u, v)| {
                    let outcome = self.contraction(u, v).filter(&acceptable);
                    outcome.map(|o| (o.sine, u, v))
                });
                let best = (options.into_iter().flatten()).max_by(|p, q| p.0.total_cmp(&q.0));
                if let Some((_, u, v)) = best {
                    self.contract(u, v);
                }
            }
            if self.edits.contracted == before {
                break;
            }
        }
    }

    fn contract(&mut self, u: u32, v: u32) {
        if let Some((_, [a, b])) = self.line_at(u) {
            self.lines.contract(u, v, if a == v { b } else { a });
        }
        self.complex.contract(u, v);
        self.edits.contracted += 1;
    }

    /// What contracting the edge from `u` to `v` would do, if it may be done.
    fn contraction(&self, u: u32, v: u32) -> Option<Outcome> {
        let complex = &self.complex;
        if complex.rank(u) == Rank::Corner {
            return None;
        }
        let (from, to) = (complex.at(u), complex.at(v));
        if complex.rank(u) == Rank::Line {
            let (_, [a, b]) = self.line_at(u)?;
            let far = if a == v { b } else { a };
            if to_segment(from, to, complex.at(far)) > self.sag {
                return None;
            }
        }
        let mut outcome = Outcome {
            sine: 1.0,
            before: 1.0,
            longest: 0.0,
        };
        let mut gap = f64::INFINITY;
        for &t in complex.around(u) {
            let c = complex.corners(t)?;
            let old = complex.shape(c);
            outcome.before = outcome.before.min(old.sine);
            if c.contains(&v) {
                continue;
            }
            let new = complex.shape_with(c, u, to);
            if new.flatness < FLATTEST.min(0.9 * old.flatness)
                || !complex.keeps_direction(t, c, &old, &new)
                || !self.upright(c.map(|w| if w == u { v } else { w }), &new)
            {
                return None;
            }
            outcome.sine = outcome.sine.min(new.sine);
            for w in c.into_iter().filter(|&w| w != u) {
                outcome.longest = outcome.longest.max(self.ratio(w, v));
            }
            gap = gap.min(to_triangle(
                from,
                c.map(|w| if w == u { to } else { complex.at(w) }),
            ));
        }
        // An infinite gap: nothing would be left but triangles of the edge itself.
        (gap <= self.sag && complex.contractible(u, v)).then_some(outcome)
    }

    /// Triangles with a poor angle, worst first.
    pub(super) fn poor_triangles(&self) -> Vec<u32> {
        let mut found: Vec<(u64, u32)> = (0..self.complex.triangle_count() as u32)
            .filter_map(|t| Some((self.complex.shape(self.complex.corners(t)?).sine, t)))
            .filter(|(sine, _)| *sine < POOR)
            .map(|(sine, t)| (sine.to_bits(), t))
            .collect();
        found.sort_unstable();
        found.into_iter().map(|f| f.1).collect()
    }

    /// Contracts any edge at a poor triangle where that betters the worst angle.
    pub(super) fn contract_poor(&mut self) {
        let poor = self.poor_triangles();
        self.contract_at(poor);
    }

    /// The same at some triangles.
    pub(super) fn contract_at(&mut self, triangles: Vec<u32>) {
        for t in triangles {
            let Some(corners) = self.complex.corners(t) else {
                continue;
            };
            let mut best: Option<(f64, u32, u32)> = None;
            for u in corners {
                for v in self.neighbours(u) {
                    let Some(o) = self.contraction(u, v) else {
                        continue;
                    };
                    let good = o.sine > (GAIN * o.before).min(POOR) && o.longest <= 1.2 * LONG;
                    if good && o.sine > GAIN * o.before && best.is_none_or(|b| o.sine > b.0) {
                        best = Some((o.sine, u, v));
                    }
                }
            }
            if let Some((_, u, v)) = best {
                self.contract(u, v);
            }
        }
    }

    pub(super) fn neighbours(&self, u: u32) -> SmallVec<[u32; 16]> {
        let mut all: SmallVec<[u32; 16]> = SmallVec::new();
        for &t in self.complex.around(u) {
            for w in self.complex.corners(t).into_iter().flatten() {
                if w != u && !all.contains(&w) {
                    all.push(w);
                }
            }
        }
        all
    }

    /// Lays down triangles that stand upright on their sheet at its end: where a
    /// border bends between two vertices, and a chord was drawn over the bend.
    pub(super) fn lay_down(&mut self) {
        for t in 0..self.complex.triangle_count() as u32 {
            let Some(corners) = self.complex.corners(t) else {
                continue;
            };
            let inner = |k: &usize| !self.complex.ends_at(corners[*k], corners[(k + 1) % 3]);
            let mut sides = (0..3).filter(inner);
            let (Some(k), None) = (sides.next(), sides.next()) else {
                continue;
            };
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if let Some(wings) = self.complex.wings(a, b)
                && self.is_upright_end(a, b, wings, t)
            {
                self.complex.flip(a, b, wings);
                self.edits.flipped += 1;
            }
        }
    }

    /// Whether triangle `t` beside an edge stands upright on the other one there, and
    /// none would after a flip.
    fn is_upright_end(&self, a: u32, b: u32, wings: [(u32, u32); 2], t: u32) -> bool {
        let [(s, c), (_, d)] = wings;
        let [one, other] = [[a, b, c], [b, a, d]].map(|corners| self.complex.shape(corners));
        let (end, sheet) = if s == t { (one, other) } else { (other, one) };
        let lies = |shape: &Shape| shape.normal.dot(sheet.normal) >= LEANING;
        let new = [[a, d, c], [d, b, c]].map(|corners| self.complex.shape(corners));
        sheet.flatness >= TRUSTED
            && !lies(&end)
            && !self.complex.adjacent(c, d)
            && new.iter().all(|n| n.flatness >= FLATTEST && lies(n))
    }

    /// Flips edges inside sheets where that betters the worst angle.
    pub(super) fn flip_poor(&mut self) {
        self.flip_poor_of(&|_| true);
    }

    /// The same where it is allowed between two triangles.
    pub(super) fn flip_poor_of(&mut self, allowed: &dyn Fn([u32; 2]) -> bool) {
        for _ in 0..PASSES {
            let before = self.edits.flipped;
            for (a, b) in self.complex.edges() {
                if !self.complex.adjacent(a, b) || self.is_left(a, b) || !self.gains_by_flip(a, b) {
                    continue;
                }
                if let Some(wings) = self.complex.wings(a, b)
                    && allowed(wings.map(|w| w.0))
                {
                    self.complex.flip(a, b, wings);
                    self.edits.flipped += 1;
                }
            }
            if self.edits.flipped == before {
                break;
            }
        }
    }

    fn gains_by_flip(&self, a: u32, b: u32) -> bool {
        let Some(flip) = self.complex.flip_of(a, b) else {
            return false;
        };
        let [before, after] = flip.sines();
        let mut halves = flip.triangles().into_iter().zip(&flip.new);
        after > GAIN * before
            && flip.gap <= self.sag
            && halves.all(|(corners, shape)| self.upright(corners, shape))
    }

    /// Middles of all edges but those inside quadrilaterals, on their lines and
    /// sheets, where they are found; low vertex first, in order.
    pub(super) fn middles(&self) -> Vec<([u32; 2], DVec3)> {
        let mut number = 0..;
        let numbers: Vec<Option<u32>> = (0..self.vertices.len() as u32)
            .map(|v| {
                (!self.complex.around(v).is_empty())
                    .then(|| number.next())
                    .flatten()
            })
            .collect();
        let edges = self.complex.edges();
        (edges.into_par_iter())
            .filter_map(|(a, b)| {
                let (middle, chord) = self.halfway(a, b);
                let ends = [numbers[a as usize]?, numbers[b as usize]?];
                (!chord).then_some((ends, middle.at))
            })
            .collect()
    }
}
