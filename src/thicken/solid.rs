//! The thickened solid as a function.
//!
//! Definition 2: points behind the patch, at a distance of at most the
//! thickness, whose closest point is not on the boundary. Its surface is made
//! of pieces that have closed forms, the *elements*:
//!
//! * shell: the offset of one triangle (the paper's inner shell);
//! * patch: the plane of one triangle (the original surface);
//! * strip and sector: planes of the cross-section, at a boundary edge and at
//!   the end of an inner edge around which the solid opens (there the set of
//!   points whose closest point is the vertex begins);
//! * jump: where the closest point leaps to the front of the patch, or to the
//!   boundary, of another place. It has no closed form here: crossings are
//!   found by bisection, and the element knows the direction alone.
//!
//! The sign is that of Definition 2 everywhere. The value is the distance only
//! near shell, patch, strips and sectors, and never more than `CAP` cells as
//! long as the distance to the patch is below the thickness, so that the band
//! (Definition 4's candidate region, Remark 2) leaves no such node out.

use glam::DVec3;

use crate::dual_contour::{Bracket, Crossing, Implicit, Sample, hybrid};
use crate::field::Feature;
use crate::mesh::FaceId;

use super::patch::{Foot, OnRim, Patch};

/// Greatest value within reach of the patch, in cells: below that of a valid
/// node.
const CAP: f64 = 0.99;

/// An element is hidden where another is nearer by this many tolerances.
const HIDDEN: f64 = 1e3;

/// The solid behind a patch.
pub(super) struct ThickSolid<'a> {
    pub patch: &'a Patch,
    pub thickness: f64,
    cap: f64,
    tolerance: f64,
}

/// What a part of the solid's surface belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Element {
    Shell(u32),
    Patch(u32),
    Strip(u32),
    Sector(u32),
    Jump(u32),
}

/// A candidate for the value.
type Piece = (f64, Element);

impl ThickSolid<'_> {
    pub fn new(patch: &Patch, thickness: f64, cell: f64) -> ThickSolid<'_> {
        let size = patch.mesh.bounds().diagonal() + thickness;
        ThickSolid {
            patch,
            thickness,
            cap: CAP * cell,
            tolerance: 1e-12 * size,
        }
    }

    fn faces(&self) -> u32 {
        self.patch.mesh.triangles.len() as u32
    }

    fn name(&self, element: Element) -> u32 {
        let n = self.faces();
        match element {
            Element::Shell(f) => f,
            Element::Patch(f) => n + f,
            Element::Jump(f) => 2 * n + f,
            Element::Strip(e) => 3 * n + e,
            Element::Sector(s) => 3 * n + self.patch.rim.edges.len() as u32 + s,
        }
    }

    fn element_of(&self, name: u32) -> Element {
        let n = self.faces();
        let strips = self.patch.rim.edges.len() as u32;
        match name / n {
            0 => Element::Shell(name),
            1 => Element::Patch(name - n),
            2 => Element::Jump(name - 2 * n),
            _ if name - 3 * n < strips => Element::Strip(name - 3 * n),
            _ => Element::Sector(name - 3 * n - strips),
        }
    }

    /// A face near an element.
    fn face_of(&self, name: u32) -> u32 {
        match self.element_of(name) {
            Element::Shell(f) | Element::Patch(f) | Element::Jump(f) => f,
            Element::Strip(e) => self.patch.rim.edges[e as usize].face,
            Element::Sector(s) => self.patch.rim.sectors.get(s as usize).map_or(0, |s| s.face),
        }
    }

    fn strip(&self, p: DVec3, edge: u32) -> Piece {
        let e = &self.patch.rim.edges[edge as usize];
        let value = (p - self.patch.position(e.from)).dot(e.outward);
        (value, Element::Strip(edge))
    }

    fn sector(&self, p: DVec3, sector: u32) -> Piece {
        let s = &self.patch.rim.sectors[sector as usize];
        let value = (p - self.patch.position(s.vertex)).dot(s.outward);
        (value, Element::Sector(sector))
    }

    /// Value and element that decides it.
    fn decide(&self, p: DVec3, foot: &Foot) -> Piece {
        let shell = (foot.distance - self.thickness, Element::Shell(foot.face));
        let greater = |a: Piece, b: Piece| if b.0 > a.0 { b } else { a };
        match foot.rim {
            // B(S), left out.
            Some(rim) => {
                let beside = self.beside(p, foot, rim);
                greater(shell, (beside.0.clamp(0.0, self.cap), beside.1))
            }
            None if foot.side >= 0.0 => {
                let ahead = foot.distance.min(self.cap);
                greater(shell, (ahead, Element::Patch(foot.face)))
            }
            None => {
                let mut inside = greater(shell, (-foot.distance, Element::Patch(foot.face)));
                if let Feature::Edge(i) = foot.feature {
                    for s in self.patch.sectors_of_edge(foot.face, i) {
                        inside = greater(inside, self.sector(p, s));
                    }
                }
                for e in self.patch.strips_of(foot.face) {
                    inside = greater(inside, self.strip(p, e));
                }
                if shell.0 > 0.0 {
                    return shell;
                }
                // Rounding may say otherwise at a strip; the sign is the
                // foot's.
                (inside.0.clamp(-self.cap, -f64::MIN_POSITIVE), inside.1)
            }
        }
    }

    /// How far a point of B(S) is from the cross-section beside it.
    fn beside(&self, p: DVec3, foot: &Foot, rim: OnRim) -> Piece {
        let least = |a: Piece, b: Piece| if b.0 < a.0 { b } else { a };
        let greatest = |a: Piece, b: Piece| if b.0 > a.0 { b } else { a };
        let beside = match rim {
            OnRim::Edge(e) => self.strip(p, e),
            OnRim::Vertex(v) => {
                let sectors = self.patch.rim.sectors_at(v).map(|s| self.sector(p, s));
                let strips = self.patch.rim.edges_at(v).into_iter().flatten();
                sectors.reduce(least).unwrap_or_else(|| {
                    strips
                        .map(|e| self.strip(p, e))
                        .reduce(greatest)
                        .unwrap_or((foot.distance, Element::Patch(foot.face)))
                })
            }
        };
        // In front of the patch there is no cross-section.
        let normal = self.patch.normal(foot.face);
        let ahead = (p - foot.point).dot(normal);
        greatest(beside, (ahead, Element::Patch(foot.face)))
    }

    fn outward(&self, p: DVec3, foot: &Foot, element: Element) -> DVec3 {
        match element {
            Element::Shell(_) => (p - foot.point)
                .try_normalize()
                .unwrap_or_else(|| -self.patch.normal(foot.face)),
            other => self.piece(p, other).1,
        }
    }

    /// The strip that goes on where a point lies beyond the end of one, or the
    /// sector between the two.
    fn strip_beside(&self, p: DVec3, edge: u32) -> Option<Element> {
        let rim = &self.patch.rim;
        let beyond = |edge: u32| {
            let e = &rim.edges[edge as usize];
            let [a, b] = [e.from, e.to].map(|v| self.patch.position(v));
            let along = (b - a).normalize_or_zero();
            [(a - p).dot(along), (p - b).dot(along)]
        };
        let [before, after] = beyond(edge);
        let e = &rim.edges[edge as usize];
        let slack = HIDDEN * self.tolerance;
        let (vertex, next, gap) = if before > slack {
            let next = rim.before(edge);
            (e.from, next, beyond(next)[1])
        } else if after > slack {
            let next = rim.edges_at(e.to)?[1];
            (e.to, next, beyond(next)[0])
        } else {
            return None;
        };
        if gap <= slack {
            return Some(Element::Strip(next));
        }
        let sectors = rim.sectors_at(vertex).map(|s| self.sector(p, s));
        let nearest = sectors.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        nearest.map(|(_, sector)| sector)
    }

    /// The element where the closest point leaps; `beyond` is the one on the
    /// outer side.
    ///
    /// Beside the boundary, where the faces around a vertex lean towards each
    /// other, it leaps between neighbours: that little is left to the strip.
    fn leapt(&self, beyond: u32) -> u32 {
        match self.element_of(beyond) {
            Element::Strip(_) | Element::Sector(_) => beyond,
            _ => self.name(Element::Jump(self.face_of(beyond))),
        }
    }

    /// Value and gradient of one element.
    fn piece(&self, p: DVec3, element: Element) -> (f64, DVec3) {
        match element {
            Element::Shell(f) => {
                let foot = self.patch.field.footpoint_on(p, FaceId(f));
                let away = (p - foot.point).try_normalize();
                let away = away.unwrap_or_else(|| -self.patch.normal(f));
                (foot.distance - self.thickness, away)
            }
            Element::Patch(f) => {
                let t = self.patch.mesh.triangles[f as usize];
                let normal = self.patch.normal(f);
                ((p - self.patch.position(t[0])).dot(normal), normal)
            }
            Element::Strip(e) => {
                let outward = self.patch.rim.edges[e as usize].outward;
                (self.strip(p, e).0, outward)
            }
            Element::Sector(s) => {
                let outward = self.patch.rim.sectors[s as usize].outward;
                (self.sector(p, s).0, outward)
            }
            Element::Jump(f) => {
                let foot = self.patch.field.footpoint_on(p, FaceId(f));
                let toward = (foot.point - p).try_normalize();
                (0.0, toward.unwrap_or_else(|| self.patch.normal(f)))
            }
        }
    }
}

impl Implicit for ThickSolid<'_> {
    fn sample(&self, p: DVec3, hint: u32) -> Sample {
        let foot = self.patch.foot(p, self.face_of(hint));
        let (value, element) = self.decide(p, &foot);
        Sample {
            value,
            gradient: self.outward(p, &foot, element),
            // Within reach of the patch the surface may be anywhere.
            unsigned: (foot.distance - self.thickness).max(0.0),
            element: self.name(element),
        }
    }

    fn element(&self, p: DVec3, element: u32) -> (f64, DVec3) {
        self.piece(p, self.element_of(element))
    }

    /// The shell and the patch are where their nearest triangle has them; a
    /// strip ends with its edge.
    fn covered(&self, p: DVec3, element: u32, _: f64) -> Option<u32> {
        let (face, height, kind): (_, _, fn(u32) -> Element) = match self.element_of(element) {
            Element::Shell(face) => (face, self.thickness, Element::Shell),
            Element::Patch(face) => (face, 0.0, Element::Patch),
            Element::Strip(edge) => return self.strip_beside(p, edge).map(|e| self.name(e)),
            _ => return None,
        };
        let foot = self.patch.foot(p, face);
        let hidden = foot.face != face && (foot.distance - height).abs() > HIDDEN * self.tolerance;
        hidden.then(|| self.name(kind(foot.face)))
    }

    /// The closed form of the outer end's element guesses, then the inner
    /// one's.
    fn crossing(&self, ends: [DVec3; 2], samples: [Sample; 2]) -> Crossing {
        let field = &self.patch.field;
        let guess = |bracket: &Bracket| {
            let [from, to] = bracket.ends;
            let closed = |name: u32| {
                let way = match self.element_of(name) {
                    Element::Shell(f) => field.leaves(FaceId(f), from, to, self.thickness)?,
                    element => {
                        let [a, b] = bracket.ends.map(|p| self.piece(p, element).0);
                        (a < 0.0 && b > 0.0).then(|| a / (a - b))?
                    }
                };
                (way > 0.0 && way < 1.0).then_some(way)
            };
            let [near, far] = bracket.samples.map(|s| s.element);
            (!bracket.shaky)
                .then(|| closed(far).or_else(|| closed(near)))
                .flatten()
        };
        let found = hybrid(self, ends, samples, 1.0, self.tolerance, guess);
        let leapt = found.leapt.map(|beyond| self.leapt(beyond));
        Crossing {
            element: leapt.unwrap_or(found.crossing.element),
            ..found.crossing
        }
    }
}
