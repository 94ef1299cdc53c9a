//! What a point of the surface sees of the wall behind it.
//!
//! The side of a wall is shallow: the other side is near and the wall runs on
//! far to all sides. The face that closes a wall is deep: the wall goes on
//! behind it, and its two sides are near. Every length is held against one
//! measured at the same point, so units and mesh density play no part.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::samples::Sample;
use super::surface::Surface;

/// Directions in which the shortest chord is sought, over half a turn; then
/// halved [`HALVINGS`] times, to 2 degrees.
const DIRECTIONS: usize = 6;
const HALVINGS: i32 = 4;

/// Where a ball touches within this angle of its first contact, degrees, it
/// meets the next facet of the same curved face, not the wall's other side.
const SAME_FACE: f64 = 50.0;

/// A chord this much longer than the ball is wide is as short as any.
const ENOUGH_SLACK: f64 = 1e-3;

/// Chords of more than this many depths are not measured: the point lies on
/// the side of a wall, whatever the length. 2^2.6.
const LONGEST: f64 = 6.1;

/// Log2 of depth over chord below which a face is no narrow one: a face that
/// leans against its wall by 10 degrees still has -2.5.
const NARROW_FROM: f64 = -2.5;

/// Log2 of depth over chord below which nobody asks for the ends of the chord.
const ENDS_FROM: f64 = -1.5;

/// How far beyond each end of a chord, in chords, the surface must be gone, and
/// by how much of that: past a rounded edge, or before a gap beyond which another wall
/// goes on in the same plane.
const BEYOND: [f64; 2] = [0.25, 0.075];
const GONE: f64 = 0.48;

/// Cosine between a surface's normal and the way to it.
const LOOKS_BACK: f64 = -0.7;

/// Height over the face, in chords, at which a neighbour that rises from it
/// is looked for.
const LIFT: f64 = 0.05;

/// A ball of this share of the half chord must fit behind the face.
const FIT: f64 = 0.7;

/// Log2 of a wall's third extent over its thickness: a post up to the first, a
/// plate from the sum of both.
const POST: [f64; 2] = [0.3, 0.7];

/// Cosine of the greatest angle between a chord and the normal of the wall
/// that it ends on.
pub(super) const LEAN: f64 = 0.5;

/// Cosine between the sides of a wall that look away from each other.
const OPPOSED: f64 = -0.8;

/// Log2 of length over thickness of the wall behind a face from which it
/// counts as one, and from which it counts in full.
const FAR: [f64; 2] = [-1.5, -0.5];

/// Thicknesses behind a face at which its wall should still stand; farther
/// behind it may do so again, beyond another wall that it passes through.
const STANDS: f64 = 0.8;
const STANDS_AT: [f64; 3] = [STANDS, 2.0, 3.0];

/// Depth below the surface, in thicknesses, of the chord that tells which
/// faces a face lies between.
const JUST_UNDER: f64 = 0.02;

/// What one point sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Probe {
    /// Wall thickness here, seen across or along the normal.
    pub thickness: f64,
    /// Log2 of depth over chord: below zero for sides of walls, above for
    /// faces that close them.
    pub ratio: f64,
    /// The ratio within -1..1, and zero where it is positive but the face is
    /// not closed, or no wall lies behind it.
    pub score: f64,
    /// Both ends of the chord lie at convex edges.
    pub closed: bool,
    /// Whether a wall of the chord's thickness still stands a bit behind.
    pub goes_on: bool,
    /// 0 for a post behind the face, 1 for a plate.
    pub plate: f64,
    /// Triangles at the ends of the chord.
    pub sides: Option<[u32; 2]>,
    /// The triangle opposite.
    pub opposite: Option<u32>,
    /// The chord just under the surface, where it ends at convex edges.
    pub across: Option<Across>,
}

/// A narrow face, seen from one end of its width to the other, and what it
/// leans on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Across {
    pub width: f64,
    /// Along the chord, unit length.
    pub direction: DVec3,
    pub ends: [Side; 2],
    /// The ends look away from each other.
    pub opposed: bool,
}

/// How far a wall of a thickness goes on: 0 for a stub to 1.
pub(super) fn far(along: f64, thickness: f64) -> f64 {
    let longer = (along / thickness.max(f64::MIN_POSITIVE)).log2();
    ((longer - FAR[0]) / (FAR[1] - FAR[0])).clamp(0.0, 1.0)
}

impl Across {
    /// How much speaks for a strip between the two sides of a wall that goes on
    /// behind it, 0 to 1.
    pub fn strip(&self) -> f64 {
        let [a, b] = &self.ends;
        if self.opposed && self.is_upright() {
            far(a.along.min(b.along), a.thickness.max(b.thickness))
        } else {
            0.0
        }
    }

    /// The chord stands upright on what it ends on.
    pub fn is_upright(&self) -> bool {
        self.ends.iter().all(|end| end.lean >= LEAN)
    }
}

/// What the chord of a narrow face ends on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Side {
    pub face: u32,
    /// Cosine between chord and the side's normal.
    pub lean: f64,
    /// Thickness of the wall whose side this is.
    pub thickness: f64,
    /// How far that side goes on behind the face.
    pub along: f64,
    /// Whether a wall of that thickness still stands behind.
    pub stands: bool,
}

/// Looks from every sample; in parallel, in the order of the samples.
pub(super) fn look(surface: &Surface, samples: &[Sample]) -> Vec<Probe> {
    let one = |sample: &Sample| Looker { surface, sample }.look();
    samples.par_iter().map(one).collect()
}

#[derive(Clone, Copy, Debug)]
struct Chord {
    lengths: [f64; 2],
    faces: [u32; 2],
    direction: DVec3,
}

impl Chord {
    fn width(&self) -> f64 {
        self.lengths[0] + self.lengths[1]
    }
}

struct Looker<'a> {
    surface: &'a Surface,
    sample: &'a Sample,
}

impl Looker<'_> {
    fn look(&self) -> Probe {
        let (p, n) = (self.sample.point, self.sample.normal);
        // Rounding at the surface itself is no opposite wall.
        let skin = 1e-7 * self.surface.diagonal;
        let opposite = self
            .surface
            .ray(p - skin * n, -n, f64::INFINITY)
            .map(|(way, face)| (way + skin, face));
        let Some((depth, facing)) = opposite else {
            return Probe::blind(skin);
        };
        let radius = self.ball(depth);
        let chord = self.shortest_chord(p - radius * n, LONGEST * depth, 2.0 * radius);
        let Some(chord) = chord else {
            return Probe {
                ratio: -LONGEST.log2(),
                score: -1.0,
                opposite: Some(facing),
                ..Probe::blind(depth)
            };
        };
        self.weigh(depth, facing, &chord)
    }

    fn weigh(&self, depth: f64, facing: u32, chord: &Chord) -> Probe {
        let (p, n) = (self.sample.point, self.sample.normal);
        let width = chord.width();
        let ratio = (depth / width).log2();
        let closed = ratio > ENDS_FROM && self.is_closed(chord);
        // The middle of the wall's width, from where the wall is looked into.
        let middle = p + chord.direction * (0.5 * (chord.lengths[0] - chord.lengths[1]));
        let mut probe = Probe {
            thickness: depth.min(width),
            ratio,
            score: ratio.clamp(-1.0, 1.0),
            closed,
            goes_on: true,
            plate: 1.0,
            sides: Some(chord.faces),
            opposite: Some(facing),
            across: None,
        };
        if ratio > 0.0 {
            let half = 0.5 * width;
            let inner = middle - half * n;
            let third = self.surface.chord(
                inner,
                n.cross(chord.direction),
                width * (POST[0] + POST[1]).exp2(),
            );
            probe.plate = (((third / width).log2() - POST[0]) / POST[1]).clamp(0.0, 1.0);
            let fits = self.fits_behind(inner, chord, half);
            probe.goes_on = STANDS_AT.iter().any(|at| {
                let behind = middle - (at * width).min(0.5 * depth) * n;
                let reach = 2.0 * width;
                self.surface
                    .chord(behind, chord.direction, reach)
                    .is_finite()
            });
            let rim = closed && fits && probe.goes_on;
            probe.score *= if rim { probe.plate } else { 0.0 };
        }
        if ratio > NARROW_FROM {
            probe.across = self.across(probe.thickness);
        }
        probe
    }

    /// Whether a ball fits behind the face, `half` a width below it. Where the face
    /// leans, the wall has moved aside there: the ball stands in its middle.
    fn fits_behind(&self, inner: DVec3, chord: &Chord, half: f64) -> bool {
        let way = |way| self.surface.ray(inner, way, 2.0 * half);
        let aside = match (way(chord.direction), way(-chord.direction)) {
            (Some((one, _)), Some((other, _))) => 0.5 * (one - other),
            _ => 0.0,
        };
        let centre = inner + aside * chord.direction;
        self.surface.nearest(centre, self.sample.face).0 > FIT * half
    }

    /// Radius of the ball inside that touches here (shrinking ball: Ma, Bae
    /// and Choi 2012). Facets of the same face do not stop it.
    fn ball(&self, depth: f64) -> f64 {
        const STEPS: usize = 30;
        let (p, n) = (self.sample.point, self.sample.normal);
        let least = SAME_FACE.to_radians().cos();
        let mut radius = 0.5 * depth;
        let mut near = self.sample.face;
        for _ in 0..STEPS {
            let (distance, touch, face) = self.surface.nearest(p - radius * n, near);
            if distance >= radius * (1.0 - 1e-7) {
                break;
            }
            near = face;
            let way = p - touch;
            let height = 2.0 * n.dot(way);
            if height <= 0.0 {
                break;
            }
            let smaller = way.length_squared() / height;
            let turn = n.dot(touch - (p - smaller * n)) / smaller;
            if turn > least || smaller >= radius {
                break;
            }
            radius = smaller;
        }
        radius
    }

    /// The shortest chord through a point, square to the normal; none if all
    /// are longer than `reach`. One of `enough` cannot be bettered.
    fn shortest_chord(&self, through: DVec3, reach: f64, enough: f64) -> Option<Chord> {
        let mut search = ChordSearch {
            surface: self.surface,
            through,
            axes: self.axes(),
            limit: reach,
            best: None,
        };
        let enough = enough * (1.0 + ENOUGH_SLACK);
        let step = PI / DIRECTIONS as f64;
        for i in 0..DIRECTIONS {
            search.attempt(step * i as f64);
            if search.limit <= enough {
                break;
            }
        }
        for halving in 1..=HALVINGS {
            let (at, _) = search.best?;
            if search.limit <= enough {
                break;
            }
            let finer = step * 0.5_f64.powi(halving);
            search.attempt(at - finer);
            search.attempt(at + finer);
        }
        search.best.map(|(_, chord)| chord)
    }

    /// Two directions square to the normal and to each other.
    fn axes(&self) -> [DVec3; 2] {
        let u = self.sample.normal.any_orthonormal_vector();
        [u, self.sample.normal.cross(u)]
    }

    /// Whether the face ends at both ends of a chord, at convex edges: beyond
    /// them the surface is gone, and nothing rises from the face.
    fn is_closed(&self, chord: &Chord) -> bool {
        let (p, n) = (self.sample.point, self.sample.normal);
        let width = chord.width();
        let ways = [chord.direction, -chord.direction];
        ways.iter().zip(chord.lengths).all(|(&way, length)| {
            let is_gone = |beyond: f64| {
                let place = p + (length + beyond * width) * way;
                let (distance, _, other) = self.surface.nearest(place, self.sample.face);
                // What looks back is another wall, across a gap.
                distance > GONE * beyond * width
                    || self.surface.normals[other as usize].dot(way) < LOOKS_BACK
            };
            let above = p + LIFT * width * n;
            BEYOND.into_iter().any(is_gone) && self.surface.ray(above, way, 0.5 * length).is_none()
        })
    }

    /// For faces that lean against the wall, and for bars: the chord just
    /// under the surface, and what lies behind its ends.
    fn across(&self, thickness: f64) -> Option<Across> {
        let (p, n) = (self.sample.point, self.sample.normal);
        let under = p - JUST_UNDER * thickness * n;
        let reach = 4.0 * LONGEST * thickness;
        let chord = self.shortest_chord(under, reach, 0.0)?;
        if !self.is_closed(&chord) {
            return None;
        }
        let width = chord.width();
        let side = |face: u32| self.side(under, &chord, face);
        let [a, b] = chord.faces.map(|face| self.surface.normals[face as usize]);
        Some(Across {
            width,
            direction: chord.direction,
            ends: chord.faces.map(side),
            opposed: a.dot(b) < OPPOSED,
        })
    }

    /// The wall that one end of a chord lies on, if the end is a wall.
    fn side(&self, under: DVec3, chord: &Chord, face: u32) -> Side {
        /// Sine between face and side below which the side has no way behind.
        const FLUSH: f64 = 0.3;
        let (n, side) = (self.sample.normal, self.surface.normals[face as usize]);
        let width = chord.width();
        let lean = chord.direction.dot(side).abs();
        let thickness = width * lean;
        // Along the side, away from the face.
        let behind = n.dot(side) * side - n;
        let length = behind.length();
        let mut along = 0.0;
        if length > FLUSH {
            let ray = self.surface.ray(under, behind / length, f64::INFINITY);
            along = ray.map_or(f64::INFINITY, |(way, _)| way);
        }
        let way = (STANDS * thickness).min(0.5 * along);
        let stands = along > 0.0
            && self
                .surface
                .chord(under + way * behind / length, side, 2.0 * thickness)
                .is_finite();
        Side {
            face,
            lean,
            thickness,
            along,
            stands,
        }
    }
}

struct ChordSearch<'a> {
    surface: &'a Surface,
    through: DVec3,
    axes: [DVec3; 2],
    /// Width of the best; what is longer is not looked at.
    limit: f64,
    /// With its angle.
    best: Option<(f64, Chord)>,
}

impl ChordSearch<'_> {
    /// Takes the chord at an angle, if it is shorter than the best so far.
    fn attempt(&mut self, turn: f64) {
        let direction = turn.cos() * self.axes[0] + turn.sin() * self.axes[1];
        let ray = |way, reach| self.surface.ray(self.through, way, reach);
        let Some((one, first)) = ray(direction, self.limit) else {
            return;
        };
        let Some((other, second)) = ray(-direction, self.limit - one) else {
            return;
        };
        if one + other < self.limit {
            self.limit = one + other;
            let chord = Chord {
                lengths: [one, other],
                faces: [first, second],
                direction,
            };
            self.best = Some((turn, chord));
        }
    }
}

impl Probe {
    /// A point that nothing faces.
    fn blind(thickness: f64) -> Probe {
        Probe {
            thickness,
            ratio: 0.0,
            score: 0.0,
            closed: false,
            goes_on: true,
            plate: 1.0,
            sides: None,
            opposite: None,
            across: None,
        }
    }
}
