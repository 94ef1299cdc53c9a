//! Vertices moved to where their triangles have better shapes.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::Remesher;
use super::edits::POOR;
use crate::reshape::complex::Rank;
use crate::surface::marked::MarkedVertex;

/// How far a vertex may be put back onto the surface, against the target edge
/// length there.
const REACH: f64 = 0.3;

/// A move may lower the sine of the worst angle down to that of 30 degrees.
const FREE: f64 = 0.5;

/// Moves shorter than this, against the target edge length, are left.
const STILL: f64 = 1e-3;

/// Where a vertex goes.
pub(super) struct Move {
    pub(super) vertex: MarkedVertex,
    chord: bool,
    /// Place along its line.
    place: Option<(u32, f64)>,
}

impl Remesher<'_> {
    /// Moves every vertex towards the middle of its neighbours, along its sheet
    /// or line. All moves are found at once and made in order, each only if it
    /// turns no triangle over and makes no worst angle worse than it may.
    pub(super) fn relax(&mut self) {
        let this = &*self;
        let moves: Vec<Option<Move>> = (0..self.vertices.len() as u32)
            .into_par_iter()
            .map(|v| this.relaxed(v))
            .collect();
        for (v, found) in moves.into_iter().enumerate() {
            if let Some(found) = found {
                self.try_move(v as u32, found, |new, old| new >= old.min(FREE));
            }
        }
    }

    pub(super) fn try_move(&mut self, v: u32, to: Move, better: impl Fn(f64, f64) -> bool) -> bool {
        let old = self.complex.worst_around(v);
        let Some(new) = self.complex.moved(v, to.vertex.at) else {
            return false;
        };
        let around = self.complex.around(v).iter();
        let corners = around.filter_map(|&t| self.complex.corners(t));
        let upright = |c: [u32; 3]| self.upright(c, &self.complex.shape_with(c, v, to.vertex.at));
        if !corners.into_iter().all(upright) {
            return false;
        }
        if !better(new, old) {
            return false;
        }
        if let Some((line, place)) = to.place {
            self.lines.set_place(line, v, place);
        }
        self.settle(v, to.vertex, to.chord);
        true
    }

    fn relaxed(&self, v: u32) -> Option<Move> {
        if self.complex.around(v).is_empty() {
            return None;
        }
        match self.complex.rank(v) {
            Rank::Corner => None,
            Rank::Line => self.relaxed_on_line(v),
            Rank::Inner => self.on_sheet(v, self.centre(v)?),
        }
    }

    pub(super) fn relaxed_on_line(&self, v: u32) -> Option<Move> {
        if self.frozen {
            return None;
        }
        let (line, [a, b]) = self.line_at(v)?;
        let [s, t] = self.lines.span(&self.complex, line, v, a);
        let [s_again, u] = self.lines.span(&self.complex, line, v, b);
        let (back, on) = (t - s, u - s_again);
        // Ways to the neighbours in proportion to the edges wanted there.
        let [wa, wb] = [a, b].map(|w| 0.5 * (self.size[w as usize] + self.size[v as usize]));
        let balance = (back * wb + on * wa) / (wa + wb);
        self.on_line(v, line, s + balance)
    }

    fn on_line(&self, v: u32, line: u32, place: f64) -> Option<Move> {
        let length = self.lines.course(line).length();
        let place = if place < 0.0 { place + length } else { place };
        let (vertex, chord) = self.line_point(line, place);
        let still = STILL * self.size[v as usize];
        (vertex.at.distance(self.complex.at(v)) > still).then_some(Move {
            vertex,
            chord,
            place: Some((line, place)),
        })
    }

    /// Middle of the triangles round a vertex, weighted by their area against
    /// the area wanted there.
    fn centre(&self, v: u32) -> Option<DVec3> {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for &t in self.complex.around(v) {
            let c = self.complex.corners(t)?;
            let [p, q, r] = c.map(|w| self.complex.at(w));
            let size: f64 = c.iter().map(|&w| self.size[w as usize]).sum::<f64>() / 3.0;
            let w = (q - p).cross(r - p).length() / (size * size);
            sum += w * (p + q + r) / 3.0;
            weight += w;
        }
        (weight > 0.0).then(|| sum / weight)
    }

    /// A vertex of a sheet moved towards `to`, within its tangent plane and
    /// back onto the surface.
    pub(super) fn on_sheet(&self, v: u32, to: DVec3) -> Option<Move> {
        let here = &self.vertices[v as usize];
        if let Some(support) = self.support_of(v) {
            let at = support.onto(to);
            let still = at.distance(here.at) <= STILL * self.size[v as usize];
            let vertex = MarkedVertex { at, ..here.clone() };
            let (chord, place) = (false, None);
            return (!still).then_some(Move {
                vertex,
                chord,
                place,
            });
        }
        let normal = self.ground.normal(here);
        let guess = to - normal * normal.dot(to - here.at);
        let size = self.size[v as usize];
        if guess.distance(here.at) <= STILL * size {
            return None;
        }
        let vertex = self.ground.on_sheet(guess, &here.walls, REACH * size)?;
        let (chord, place) = (false, None);
        Some(Move {
            vertex,
            chord,
            place,
        })
    }

    /// Searches better places for the vertices of poor triangles, in shrinking
    /// steps.
    pub(super) fn nudge_poor(&mut self) {
        for t in self.poor_triangles() {
            let Some(corners) = self.complex.corners(t) else {
                continue;
            };
            if self.complex.shape(corners).sine >= POOR {
                continue;
            }
            for v in corners {
                self.nudge(v);
            }
        }
    }

    fn nudge(&mut self, v: u32) {
        const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];
        for share in STEPS {
            let worst = self.complex.worst_around(v);
            let options = self.options(v, share * self.size[v as usize], &|to| {
                self.complex.moved(v, to).is_some_and(|new| new > worst)
            });
            let best = (options.into_iter())
                .filter_map(|m| Some((self.complex.moved(v, m.vertex.at)?, m)))
                .max_by(|p, q| p.0.total_cmp(&q.0));
            if let Some((_, to)) = best {
                self.try_move(v, to, |new, old| new > 1.001 * old);
            }
        }
    }

    /// Eight directions in the tangent plane of a vertex.
    fn directions(&self, v: u32) -> [DVec3; 8] {
        let normal = self.ground.normal(&self.vertices[v as usize]);
        let normal = if normal == DVec3::ZERO {
            DVec3::Z
        } else {
            normal
        };
        let (x, y) = normal.any_orthonormal_pair();
        std::array::from_fn(|k| {
            let angle = k as f64 * std::f64::consts::FRAC_PI_4;
            angle.cos() * x + angle.sin() * y
        })
    }

    /// Places a step away from a vertex, along its line or in its sheet; only
    /// those that are hopeful before they are put back onto the surface: most end
    /// there, at little cost.
    pub(super) fn options(
        &self,
        v: u32,
        step: f64,
        hopeful: &dyn Fn(DVec3) -> bool,
    ) -> SmallVec<[Move; 8]> {
        match self.complex.rank(v) {
            Rank::Corner => SmallVec::new(),
            Rank::Line if self.frozen => SmallVec::new(),
            Rank::Line => {
                let Some((line, [a, _])) = self.line_at(v) else {
                    return SmallVec::new();
                };
                let place = self.lines.span(&self.complex, line, v, a)[0];
                let places = [place - step, place + step].into_iter();
                places.filter_map(|p| self.on_line(v, line, p)).collect()
            }
            Rank::Inner => {
                let places = self.directions(v).map(|d| self.complex.at(v) + step * d);
                let places = places.into_iter().filter(|&to| hopeful(to));
                places.filter_map(|to| self.on_sheet(v, to)).collect()
            }
        }
    }
}
