//! The 3D follower of coping borders (Bloomenthal 2011, section 4.3).
//!
//! The paper steps in space and searches the border anew in each transverse
//! plane, with sweep circles so as not to hop over a branch. A coping border
//! lies on coping triangles, so here the 2D follower walks it from triangle to
//! triangle: it stays on the coping to rounding, bends exactly where the coping
//! bends, and meets every branch that the 2D follower meets.

use glam::DVec3;
use smallvec::SmallVec;

use super::contour::{self, Region, Stop};
use super::fan::Fan;
use super::seam::Cage;
use super::{Pair, Probe};
use crate::mesh::FaceId;

/// Place where a border bends from one coping facet to the next.
#[derive(Clone, Copy, Debug)]
pub struct Kink {
    /// Where.
    pub at: DVec3,
    /// The walls there.
    pub pair: Pair,
}

/// How a border ends inside or on a tetrahedron.
#[derive(Clone, Debug)]
pub enum BorderStop {
    /// On a face of the tetrahedron.
    Face {
        /// Which face.
        face: usize,
        /// Where.
        at: DVec3,
        /// The pair on arrival.
        pair: Pair,
        /// The coping triangle.
        coping: FaceId,
    },
    /// Where other walls tie: the end of a seam, or of a fading border.
    Node {
        /// What leaves it in the plane of the coping.
        fan: Fan,
        /// The spoke on which the border arrived.
        arrived: usize,
        /// The coping triangle.
        coping: FaceId,
    },
    /// The follower could not go on.
    Lost {
        /// Where it gave up.
        at: DVec3,
    },
}

/// Follows a border over the coping inside a tetrahedron, starting in the
/// plane of `coping` with a pair that heads the right way there.
pub fn follow(
    probe: &mut Probe,
    cage: &Cage,
    start: DVec3,
    pair: Pair,
    coping: FaceId,
) -> (BorderStop, Vec<Kink>) {
    const MOST_FACETS: usize = 20_000;
    let mut kinks: Vec<Kink> = Vec::new();
    let (mut x, mut pair, mut coping) = (start, pair, coping);
    for _ in 0..MOST_FACETS {
        let field = probe.field();
        let (corners, tags) = clip(field.corners(coping), cage);
        let region = Region::new(corners, false).filter(|r| r.normal.dot(field.normal(coping)) > 0.0);
        let Some(region) = region else { return (BorderStop::Lost { at: x }, kinks) };
        match contour::follow(probe, &region, x, pair) {
            Stop::Side { side, at, pair: arrived } => match tags[side] {
                Tag::Face(face) => {
                    return (BorderStop::Face { face, at, pair: arrived, coping }, kinks);
                }
                Tag::Edge(k) => {
                    let next = probe.walls().neighbour(coping, k).filter(|&f| probe.field().is_coping(f));
                    let Some(next) = next else { return (BorderStop::Lost { at }, kinks) };
                    let field = probe.field();
                    if field.normal(coping).dot(field.normal(next)) < 1.0 - 1e-12 {
                        kinks.push(Kink { at, pair: arrived });
                    }
                    let c = field.corners(coping);
                    let (p, q) = (c[k], c[(k + 1) % 3]);
                    // The neighbour runs the edge the other way; its inside lies left of that.
                    let into = field.normal(next).cross(p - q);
                    pair = contour::aim(probe, at, field.normal(next), arrived, into);
                    x = at;
                    coping = next;
                }
            },
            Stop::Node { fan, arrived } => {
                if fan.spokes.len() == 2 {
                    let on = fan.spokes[1 - arrived];
                    kinks.push(Kink { at: fan.at, pair: on.pair });
                    x = fan.at;
                    pair = on.pair;
                    continue;
                }
                return (BorderStop::Node { fan, arrived, coping }, kinks);
            }
            Stop::Leaves { at, .. } | Stop::Fades { at, .. } | Stop::Lost { at } => {
                return (BorderStop::Lost { at }, kinks);
            }
        }
    }
    (BorderStop::Lost { at: x }, kinks)
}

/// What a side of a clipped coping triangle lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tag {
    /// Edge `k` of the triangle.
    Edge(usize),
    /// Face of the tetrahedron.
    Face(usize),
}

/// The part of a triangle inside a tetrahedron, with what each side lies on
/// (Sutherland and Hodgman's clipping).
fn clip(corners: [DVec3; 3], cage: &Cage) -> (SmallVec<[DVec3; 8]>, SmallVec<[Tag; 8]>) {
    let mut points: SmallVec<[DVec3; 8]> = corners.into_iter().collect();
    let mut tags: SmallVec<[Tag; 8]> = (0..3).map(Tag::Edge).collect();
    for i in 0..4 {
        let height = |p: DVec3| cage.inward[i].dot(p - cage.on_face(i));
        let mut next_points = SmallVec::new();
        let mut next_tags = SmallVec::new();
        for k in 0..points.len() {
            let (p, q) = (points[k], points[(k + 1) % points.len()]);
            let (a, b) = (height(p), height(q));
            if a >= 0.0 {
                next_points.push(p);
                next_tags.push(tags[k]);
                if b < 0.0 {
                    next_points.push(p.lerp(q, a / (a - b)));
                    next_tags.push(Tag::Face(i));
                }
            } else if b >= 0.0 {
                next_points.push(p.lerp(q, a / (a - b)));
                next_tags.push(tags[k]);
            }
        }
        points = next_points;
        tags = next_tags;
    }
    (points, tags)
}
