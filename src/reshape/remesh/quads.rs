//! Quadrilaterals: triangles are paired ([`matching`](super::matching)), cut up
//! ([`halve`](super::halve)), and vertices move so that corners come nearer to
//! right angles. What is bad then falls back to triangles, which are mended as
//! triangles are and paired once more. The halves stay in the mesh: whoever
//! takes no quadrilaterals takes them.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::Remesher;
use super::faces::{Faces, HOPEFUL, Pairing, SOLVABLE, quality};
use super::relax::Move;
use crate::reshape::complex::Rank;

/// Rounds of moving vertices.
const ROUNDS: usize = 8;

/// Rounds of searching better places for the corners of poor ones after that.
const POLISH: usize = 4;

/// Edges shorter than this, against their target, are contracted after halving,
/// which leaves none below seven tenths where nothing forces them.
const SHORT: f64 = 0.4;

/// A move may lower the worst quality down to this.
const FREE: f64 = 0.8;

/// Faces of a lower quality are poor.
const POOR: f64 = 0.6;

/// Steps of that search, against the size wanted.
const STEPS: [f64; 4] = [0.2, 0.1, 0.05, 0.02];

/// No half of a quadrilateral gets a sine of its least angle below this: that of
/// 17 degrees.
const FLATTEST: f64 = 0.3;

impl Remesher<'_> {
    /// Cuts all up to quadrilaterals, betters their shapes, and gives the pairs of
    /// triangles of those that are good, lower triangle first, by the numbers of
    /// the finished mesh.
    pub(super) fn quadrilaterals(&mut self, straight: bool) -> Vec<[u32; 2]> {
        let mut faces = self.halve();
        if straight {
            self.straighten(&|this| this.relax_faces(&faces));
        }
        for _ in 0..ROUNDS {
            self.relax_faces(&faces);
        }
        for _ in 0..POLISH {
            self.approach(1.0);
            self.nudge_faces(&faces);
            self.relax_faces(&faces);
            faces = self.paired_again(faces, HOPEFUL);
        }
        self.nudge_faces(&faces);
        let faces = self.paired_again(faces, SOLVABLE);
        let mut first = 0;
        let mut pairs = Vec::new();
        for face in &faces.all {
            if face.len() == 4 {
                pairs.push([first, first + 1]);
            }
            first += face.len() as u32 - 2;
        }
        pairs
    }

    /// Breaks up bad faces, contracts and flips what is poor of the triangles, and
    /// pairs them anew.
    fn paired_again(&mut self, faces: Faces, wanted: Pairing) -> Faces {
        let all = self.broken_up(faces.all, wanted);
        let faces = self.cut(all);
        let is_lone = |t: u32| {
            // Triangles made later are none.
            let face = faces.of.get(t as usize);
            face.is_some_and(|&f| faces.all[f as usize].len() == 3)
        };
        let poor = self.poor_triangles().into_iter();
        self.contract_at(poor.filter(|&t| is_lone(t)).collect());
        self.flip_poor_of(&|[s, t]| is_lone(s) && is_lone(t));
        self.contract_shorter(SHORT);
        let all = self.matched(wanted, &faces.of);
        self.cut(all)
    }

    /// Moves vertices towards the middle of the faces round them.
    fn relax_faces(&mut self, faces: &Faces) {
        let this = &*self;
        let moves: Vec<Option<Move>> = (0..self.vertices.len() as u32)
            .into_par_iter()
            .map(|v| match this.complex.rank(v) {
                Rank::Inner => this.on_sheet(v, this.face_centre(v, faces)?),
                Rank::Line => this.relaxed_on_line(v),
                Rank::Corner => None,
            })
            .collect();
        for (v, found) in (0..).zip(moves) {
            let Some(found) = found else { continue };
            let old = self.worst_face(v, self.complex.at(v), faces);
            if self.worst_face(v, found.vertex.at, faces) >= old.min(FREE) {
                self.try_move(v, found, |new, old| new >= old.min(FLATTEST));
            }
        }
    }

    /// Middle of the neighbours across the sides of faces, not across the
    /// diagonals of quadrilaterals.
    fn face_centre(&self, v: u32, faces: &Faces) -> Option<DVec3> {
        let around = self.complex.around(v);
        let mut met: SmallVec<[u32; 16]> = SmallVec::new();
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for &t in around {
            let number = faces.of[t as usize];
            let face = &faces.all[number as usize];
            let Some(k) = face.iter().position(|&w| w == v) else {
                continue;
            };
            if met.contains(&number) {
                continue;
            }
            met.push(number);
            let sides = face.len();
            for w in [face[(k + 1) % sides], face[(k + sides - 1) % sides]] {
                sum += self.complex.at(w);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// Searches better places for the corners of poor faces.
    fn nudge_faces(&mut self, faces: &Faces) {
        for face in &faces.all {
            let at: SmallVec<[DVec3; 4]> = face.iter().map(|&v| self.complex.at(v)).collect();
            if quality(&at) < POOR {
                for &v in face {
                    self.nudge_corner(v, faces);
                }
            }
        }
    }

    fn nudge_corner(&mut self, v: u32, faces: &Faces) {
        for share in STEPS {
            let old = self.worst_face(v, self.complex.at(v), faces);
            let options = self.options(v, share * self.size[v as usize], &|to| {
                self.worst_face(v, to, faces) > old
            });
            let best = (options.into_iter())
                .map(|m| (self.worst_face(v, m.vertex.at, faces), m))
                .filter(|(new, _)| *new > 1.001 * old)
                .max_by(|p, q| p.0.total_cmp(&q.0));
            if let Some((_, to)) = best {
                self.try_move(v, to, |new, old| new >= old.min(FLATTEST));
            }
        }
    }
}
