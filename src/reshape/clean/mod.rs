//! Clean-up of the raw mesh: needles and caps go, the surface stays.
//!
//! Lattice planes cut the mid-surface where they happen to, so the raw mesh
//! has edges down to rounding. They are contracted onto one of their ends, and
//! edges inside sheets are flipped. No vertex moves: each that is left is an
//! exactly solved point of the mid-surface, with its walls.
//!
//! # What is promised
//!
//! - The result is homeomorphic to the raw mesh: the same sheets, seams,
//!   junctions, borders and Euler characteristic. No edge gains triangles.
//! - Lines stay: a coping border where it was, or within its flat coping face;
//!   seams and fading borders within [`Settings::drift`], like the sheets.
//! - No triangle turns over or loses its height, and beside lines none comes to
//!   pass through another.
//! - The same mesh gives the same result, bit for bit.
//!
//! # What is not
//!
//! - That every needle goes. Where the surface bends, where lines run close
//!   together and at borders with bends, some stay.

#[cfg(test)]
mod tests;

use glam::DVec3;
use serde::Serialize;
use smallvec::SmallVec;

use super::complex::{Complex, Rank};
use super::shape::{Shape, to_segment, to_triangle};
use super::uncut::Kept;
use crate::field::Field;
use crate::mesh::{FaceId, clash};
use crate::surface::marked::Line;
use crate::surface::marked::MarkedMesh;

/// How far clean-up may go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Edges shorter than this are contracted, in cells. A quarter of a
    /// median edge: beyond it, triangles of usual shape would go.
    pub short: f64,
    /// How far the surface may move, in cells: sheets, seams and fading
    /// borders. The sum of all moves at a place is held below it.
    pub drift: f64,
    /// How far a coping border may move away from its coping face, in cells.
    pub coping_drift: f64,
    /// Triangles with a smaller angle than this, degrees, are worth an edit
    /// although none of their edges is short.
    pub poor: f64,
    /// Longest edge that such an edit may make, in cells. The lattice's own
    /// longest is the diagonal of a cell.
    pub long: f64,
    /// Rounds of contracting and flipping at most.
    pub rounds: usize,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            short: 0.2,
            drift: 0.02,
            coping_drift: 1e-9,
            poor: 12.0,
            long: 1.8,
            rounds: 6,
        }
    }
}

/// Edits made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Edits {
    /// Edges contracted.
    pub contracted: usize,
    /// Edges flipped.
    pub flipped: usize,
    /// Edges that are short still.
    pub short_left: usize,
}

/// No edit makes a triangle flatter than this, least height over longest
/// edge, unless it was nearly as flat before.
const FLATTEST: f64 = 1e-5;

/// Height over longest edge from which on a triangle can pass through another.
const NO_HEIGHT: f64 = 1e-9;

/// Sine of the angle that is good enough: an edit may lower better ones to it.
const GOOD_ENOUGH: f64 = 0.21;

/// Contracting a short edge may lower the sine of the worst angle to this
/// share: where needles stand side by side, at a knot of short edges, one
/// gets worse before it goes too.
const LOSS: f64 = 0.5;

/// An edit for shape's sake must raise the sine of the worst angle by this.
const GAIN: f64 = 1.05;

/// Passes of one kind at most; each stops earlier when nothing changes.
const MAX_PASSES: usize = 12;

/// Contracts edges much shorter than a cell, and flips edges inside sheets.
pub fn clean(mesh: MarkedMesh, cell: f64) -> MarkedMesh {
    clean_counted(&mesh, cell, &Settings::default(), None, &Kept::default()).0
}

/// As [`clean`], with the field of the part: it tells which coping triangles
/// lie in one plane, so that a border over a flat coping face is cleaned as a
/// seam is. Without it only within each coping triangle. Vertices at places
/// kept stay, with their triangles.
pub fn clean_on(mesh: &MarkedMesh, cell: f64, field: &Field, kept: &Kept) -> MarkedMesh {
    clean_counted(mesh, cell, &Settings::default(), Some(field), kept).0
}

/// As [`clean_on`], with settings; tells what it did.
pub fn clean_counted(
    mesh: &MarkedMesh,
    cell: f64,
    settings: &Settings,
    field: Option<&Field>,
    kept: &Kept,
) -> (MarkedMesh, Edits) {
    let mut cleaner = Cleaner::new(mesh, cell, settings, field, kept);
    for _ in 0..settings.rounds {
        let changed = cleaner.contract_short() + cleaner.flip_poor() + cleaner.contract_poor();
        if changed == 0 {
            break;
        }
    }
    cleaner.edits.short_left = cleaner.short_edges(|_| true).len();
    (cleaner.complex.into_mesh(&mesh.vertices), cleaner.edits)
}

struct Cleaner<'f> {
    complex: Complex,
    field: Option<&'f Field>,
    /// Vertices that stay, with their triangles.
    kept: Vec<bool>,
    /// How far the surface may have moved near each vertex.
    drift: Vec<f64>,
    /// Whether anything changed near a vertex since the last look, for each
    /// of the two contracting passes.
    fresh: [Vec<bool>; 3],
    edits: Edits,
    short: f64,
    long: f64,
    poor: f64,
    drift_limit: f64,
    coping_limit: f64,
}

/// Passes, as places in [`Cleaner::fresh`].
const SHORT: usize = 0;
const FLIP: usize = 1;
const POOR: usize = 2;

/// A vertex with the triangles at it.
struct Ring {
    centre: u32,
    /// By number, corners and shape.
    triangles: SmallVec<[(u32, [u32; 3], Shape); 8]>,
    /// Sine of their worst angle.
    worst: f64,
}

/// What a contraction would do.
struct Outcome {
    /// Sine of the worst angle after.
    sine: f64,
    /// Longest edge made.
    longest: f64,
    /// How far the surface moves.
    drift: f64,
}

impl<'f> Cleaner<'f> {
    fn new(
        mesh: &MarkedMesh,
        cell: f64,
        settings: &Settings,
        field: Option<&'f Field>,
        kept: &Kept,
    ) -> Cleaner<'f> {
        let complex = Complex::new(mesh);
        let count = complex.vertex_count();
        Cleaner {
            kept: (0..count as u32)
                .map(|v| kept.contains(complex.at(v)))
                .collect(),
            complex,
            field,
            drift: vec![0.0; count],
            fresh: std::array::from_fn(|_| vec![true; count]),
            edits: Edits::default(),
            short: settings.short * cell,
            long: settings.long * cell,
            poor: settings.poor.to_radians().sin(),
            drift_limit: settings.drift * cell,
            coping_limit: settings.coping_drift * cell,
        }
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        (self.complex.at(a) - self.complex.at(b)).length()
    }

    fn shape(&self, corners: [u32; 3]) -> Shape {
        self.complex.shape(corners)
    }

    /// Notes that the surroundings of a vertex are others now.
    fn touch(&mut self, v: u32) {
        let around: SmallVec<[u32; 16]> = SmallVec::from_slice(self.complex.around(v));
        for t in around {
            for w in self.complex.corners(t).into_iter().flatten() {
                for fresh in &mut self.fresh {
                    fresh[w as usize] = true;
                }
            }
        }
    }

    /// Short edges with a chosen end, shortest first.
    fn short_edges(&self, chosen: impl Fn(u32) -> bool) -> Vec<(u64, u32, u32)> {
        let mut found = Vec::new();
        for t in 0..self.complex.triangle_count() as u32 {
            let Some(c) = self.complex.corners(t) else {
                continue;
            };
            for k in 0..3 {
                let (a, b) = (c[k].min(c[(k + 1) % 3]), c[k].max(c[(k + 1) % 3]));
                if chosen(a) || chosen(b) {
                    let length = self.length(a, b);
                    if length < self.short {
                        // Bits of a positive number sort as the number does.
                        found.push((length.to_bits(), a, b));
                    }
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Contracts short edges, shortest first, until none can be.
    fn contract_short(&mut self) -> usize {
        let mut changed = 0;
        for _ in 0..MAX_PASSES {
            let fresh = std::mem::take(&mut self.fresh[SHORT]);
            let edges = self.short_edges(|v| fresh[v as usize]);
            self.fresh[SHORT] = vec![false; fresh.len()];
            let before = changed;
            for (_, a, b) in edges {
                if !self.complex.adjacent(a, b) {
                    continue;
                }
                if let Some((u, v, outcome)) = self.best_contraction(a, b)
                    && self.contracts_clear(u, v)
                {
                    self.contract(u, v, outcome.drift);
                    changed += 1;
                }
            }
            if changed == before {
                break;
            }
        }
        changed
    }

    /// Contracts any edge of a poor triangle if that betters the worst angle.
    fn contract_poor(&mut self) -> usize {
        let fresh = std::mem::take(&mut self.fresh[POOR]);
        self.fresh[POOR] = vec![false; fresh.len()];
        let mut changed = 0;
        for (_, t) in self.poor_triangles(&fresh) {
            let Some(c) = self.complex.corners(t) else {
                continue;
            };
            if self.shape(c).sine >= self.poor {
                continue;
            }
            let mut best: Option<(u32, u32, Outcome)> = None;
            // Each corner onto each of its neighbours: a cap's apex may go to
            // the far side.
            for ring in c.into_iter().filter_map(|u| self.ring(u)) {
                let mut seen: SmallVec<[u32; 16]> = SmallVec::new();
                for v in ring.triangles.iter().flat_map(|(_, c, _)| *c) {
                    if v == ring.centre || seen.contains(&v) {
                        continue;
                    }
                    seen.push(v);
                    let worth = (GAIN * ring.worst).min(GOOD_ENOUGH);
                    let so_far = best.as_ref().map_or(worth, |b| b.2.sine.max(worth));
                    let Some(outcome) = self.contraction(&ring, v, so_far) else {
                        continue;
                    };
                    if outcome.sine > so_far && outcome.longest <= self.long {
                        best = Some((ring.centre, v, outcome));
                    }
                }
            }
            if let Some((u, v, outcome)) = best
                && self.contracts_clear(u, v)
            {
                self.contract(u, v, outcome.drift);
                changed += 1;
            }
        }
        changed
    }

    /// Triangles with a small angle and a fresh corner, worst first.
    fn poor_triangles(&self, fresh: &[bool]) -> Vec<(u64, u32)> {
        let mut found = Vec::new();
        for t in 0..self.complex.triangle_count() as u32 {
            if let Some(c) = self.complex.corners(t)
                && c.iter().any(|v| fresh[*v as usize])
            {
                let sine = self.shape(c).sine;
                if sine < self.poor {
                    found.push((sine.to_bits(), t));
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// The better way to contract an edge, of those that are acceptable: the
    /// lower rank goes, then the worst angle decides, then the lower number
    /// stays.
    fn best_contraction(&self, a: u32, b: u32) -> Option<(u32, u32, Outcome)> {
        let try_one = |u: u32, v: u32| {
            let ring = self.ring(u)?;
            self.contraction(&ring, v, LOSS * ring.worst.min(GOOD_ENOUGH))
        };
        match (self.complex.rank(a), self.complex.rank(b)) {
            (ra, rb) if ra < rb => try_one(a, b).map(|o| (a, b, o)),
            (ra, rb) if ra > rb => try_one(b, a).map(|o| (b, a, o)),
            _ => match (try_one(b, a), try_one(a, b)) {
                (Some(to_a), Some(to_b)) if to_b.sine > to_a.sine => Some((a, b, to_b)),
                (Some(to_a), _) => Some((b, a, to_a)),
                (None, to_b) => to_b.map(|o| (a, b, o)),
            },
        }
    }

    fn contract(&mut self, u: u32, v: u32, drift: f64) {
        let moved = self.drift[u as usize].max(self.drift[v as usize]) + drift;
        self.complex.contract(u, v);
        self.drift[v as usize] = moved;
        self.touch(v);
        self.edits.contracted += 1;
    }

    /// The surroundings of a vertex, unless they are to stay.
    fn ring(&self, centre: u32) -> Option<Ring> {
        let complex = &self.complex;
        let mut triangles = SmallVec::new();
        let mut worst = 1.0_f64;
        for &t in complex.around(centre) {
            let c = complex.corners(t)?;
            if c.iter().any(|&w| self.kept[w as usize]) {
                return None;
            }
            let shape = self.shape(c);
            worst = worst.min(shape.sine);
            triangles.push((t, c, shape));
        }
        (!triangles.is_empty()).then_some(Ring {
            centre,
            triangles,
            worst,
        })
    }

    /// What contracting the edge from the centre of a ring to `v` would do, if it may be
    /// done and leaves no sine below `least`.
    fn contraction(&self, ring: &Ring, v: u32, least: f64) -> Option<Outcome> {
        let complex = &self.complex;
        let u = ring.centre;
        let (from, to) = (complex.at(u), complex.at(v));
        let mut outcome = Outcome {
            sine: 1.0,
            longest: 0.0,
            drift: 0.0,
        };
        if complex.rank(u) == Rank::Line {
            outcome.drift = self.line_drift(u, v)?;
        }
        let mut to_new = f64::INFINITY;
        for (t, c, old) in &ring.triangles {
            if c.contains(&v) {
                continue;
            }
            let moved = c.map(|w| if w == u { v } else { w });
            let new = self.shape(moved);
            let flat = new.flatness < FLATTEST && new.flatness < LOSS * old.flatness;
            // Where several vertices are at one place, one goes after the other.
            let as_flat = old.flatness <= NO_HEIGHT && new.flatness <= NO_HEIGHT;
            let spoilt = flat || new.flatness <= 0.0 || !complex.keeps_direction(*t, *c, old, &new);
            if new.sine < least || spoilt && !as_flat {
                return None;
            }
            outcome.sine = outcome.sine.min(new.sine);
            for w in moved {
                outcome.longest = outcome.longest.max((complex.at(w) - to).length());
            }
            to_new = to_new.min(to_triangle(from, moved.map(|w| complex.at(w))));
        }
        // Only triangles of the edge itself: nothing would be left of them.
        if to_new == f64::INFINITY {
            return None;
        }
        outcome.drift = outcome.drift.max(to_new);
        let so_far = self.drift[u as usize].max(self.drift[v as usize]);
        (so_far + outcome.drift <= self.drift_limit && complex.contractible(u, v))
            .then_some(outcome)
    }

    fn contracts_clear(&self, u: u32, v: u32) -> bool {
        let old = self.complex.around(u);
        let new: SmallVec<[[u32; 3]; 8]> = (old.iter())
            .filter_map(|&t| self.complex.corners(t))
            .filter(|c| !c.contains(&v))
            .map(|c| c.map(|w| if w == u { v } else { w }))
            .collect();
        self.keeps_clear(old, &new)
    }

    fn flips_clear(&self, a: u32, b: u32, [(s, c), (t, d)]: [(u32, u32); 2]) -> bool {
        self.keeps_clear(&[s, t], &[[a, d, c], [d, b, c]])
    }

    /// Whether the triangles that an edit makes pass through none of those
    /// around them, unless the old ones did. Away from lines sheets are single
    /// and smooth, and the promised directions are enough.
    fn keeps_clear(&self, old: &[u32], new: &[[u32; 3]]) -> bool {
        let complex = &self.complex;
        let mut ring: SmallVec<[u32; 64]> = (new.iter().flatten())
            .flat_map(|&v| complex.around(v).iter().copied())
            .filter(|t| !old.contains(t))
            .collect();
        ring.sort_unstable();
        ring.dedup();
        let ring: SmallVec<[[u32; 3]; 64]> = ring
            .into_iter()
            .filter_map(|t| complex.corners(t))
            .collect();
        if (ring.iter().flatten()).all(|&v| complex.rank(v) == Rank::Inner) {
            return true;
        }
        let places = |c: &[u32; 3]| c.map(|v| complex.at(v));
        let span = |[a, b, c]: [DVec3; 3]| (a.min(b).min(c), a.max(b).max(c));
        let spans: SmallVec<[_; 64]> = ring.iter().map(|r| span(places(r))).collect();
        let clashes = |t: &[u32; 3]| {
            let (low, high) = span(places(t));
            ring.iter().zip(&spans).any(|(r, (least, most))| {
                let sound = |c: [u32; 3]| self.shape(c).flatness > NO_HEIGHT;
                (least.cmple(high) & most.cmpge(low)).all()
                    && sound(*t)
                    && sound(*r)
                    && clash([places(t), places(r)], [*t, *r])
            })
        };
        let mut before = old.iter().filter_map(|&t| complex.corners(t));
        !new.iter().any(clashes) || before.any(|t| clashes(&t))
    }

    /// How far a line moves when its vertex `u` is contracted onto its
    /// neighbour `v`; `None` if that is too far.
    fn line_drift(&self, u: u32, v: u32) -> Option<f64> {
        let complex = &self.complex;
        let class = complex.class(u, v)?;
        let [a, b] = complex.line_through(u)?;
        let far = if a == v { b } else { a };
        let drift = to_segment(complex.at(u), complex.at(v), complex.at(far));
        if class.mark == Some(Line::CopingBorder) {
            let [here, this, that] = [u, v, far].map(|w| complex.coping(w));
            // Both ends on one coping triangle: so is all between them.
            let on_face = this.is_some() && this == that
                || self.in_one_plane(here, this) && self.in_one_plane(this, that);
            if !on_face && drift > self.coping_limit {
                return None;
            }
        }
        (drift <= self.drift_limit).then_some(drift)
    }

    /// Whether two coping triangles lie in one plane.
    ///
    /// A line that stays within [`Settings::drift`] between two points of a
    /// flat coping face stays on that face, far from its rim.
    fn in_one_plane(&self, a: Option<FaceId>, b: Option<FaceId>) -> bool {
        let (Some(field), Some(a), Some(b)) = (self.field, a, b) else {
            return false;
        };
        let known = |face: FaceId| face.index() < field.face_count();
        if a == b || !known(a) || !known(b) {
            return a == b;
        }
        let (normal, origin) = (field.normal(a), field.corners(a)[0]);
        let apart = |p: DVec3| normal.dot(p - origin).abs() > self.coping_limit;
        normal.dot(field.normal(b)) > 0.5 && !field.corners(b).into_iter().any(apart)
    }

    /// Flips edges of poor triangles where that betters the worst angle.
    fn flip_poor(&mut self) -> usize {
        let mut changed = 0;
        for _ in 0..MAX_PASSES {
            let fresh = std::mem::take(&mut self.fresh[FLIP]);
            self.fresh[FLIP] = vec![false; fresh.len()];
            let before = changed;
            for (_, t) in self.poor_triangles(&fresh) {
                let Some(c) = self.complex.corners(t) else {
                    continue;
                };
                let best = (0..3)
                    .filter_map(|k| {
                        let (a, b) = (c[k], c[(k + 1) % 3]);
                        self.flip_gain(a, b).map(|(gain, gap)| (gain, gap, a, b))
                    })
                    .max_by(|x, y| x.0.total_cmp(&y.0));
                if let Some((_, gap, a, b)) = best
                    && let Some(wings) = self.complex.wings(a, b)
                    && self.flips_clear(a, b, wings)
                {
                    self.complex.flip(a, b, wings);
                    for v in [a, b, wings[0].1, wings[1].1] {
                        self.drift[v as usize] += gap;
                        self.touch(v);
                    }
                    self.edits.flipped += 1;
                    changed += 1;
                }
            }
            if changed == before {
                break;
            }
        }
        changed
    }

    /// Sine of the worst angle after flipping an edge, and how far the surface
    /// moves; `None` if it may not be flipped or is no better after.
    fn flip_gain(&self, a: u32, b: u32) -> Option<(f64, f64)> {
        let flip = self.complex.flip_of(a, b)?;
        if flip.corners.iter().any(|&v| self.kept[v as usize]) {
            return None;
        }
        let [before, after] = flip.sines();
        if after <= GAIN * before || flip.new.iter().any(|s| s.flatness < FLATTEST) {
            return None;
        }
        let so_far = flip.corners.map(|v| self.drift[v as usize]);
        let so_far = so_far.into_iter().fold(0.0, f64::max);
        (so_far + flip.gap <= self.drift_limit).then_some((after, flip.gap))
    }
}
