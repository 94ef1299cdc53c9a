//! The 3D follower of coping borders (Bloomenthal 2011, section 4.3).
//!
//! The paper steps in space and searches the border anew in each transverse
//! plane, with sweep circles so as not to hop over a branch. A coping border
//! lies on coping triangles, so here the 2D follower walks it from triangle to
//! triangle: it stays on the coping to rounding, bends exactly where the coping
//! bends, and meets every branch that the 2D follower meets.

use glam::DVec3;
use smallvec::SmallVec;

use super::cage::Cage;
use super::contour::{self, Start, Stop};
use super::fan::Fan;
use super::region::{Barrier, Exit, Fence, Region};
use crate::mesh::FaceId;
use crate::trace::probe::{Pair, Probe};
use crate::trace::tolerances::Tolerances;
use crate::walls::pinch::Onward;

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
    from: Start,
) -> (BorderStop, Vec<Kink>) {
    const MOST_FACETS: usize = 20_000;
    /// Facets met at one place at most: those round a corner of the coping.
    const MOST_AT_ONE_PLACE: usize = 256;
    let near = Tolerances::new(probe.walls().tolerances(), cage.size()).same_point;
    let mut kinks: Vec<Kink> = Vec::new();
    let mut at_one_place = 0;
    let (mut x, mut pair, mut coping, mut from) = (start, pair, coping, from);
    for _ in 0..MOST_FACETS {
        let Some((region, faces)) = patch_region(probe, cage, coping) else {
            return (BorderStop::Lost { at: x }, kinks);
        };
        match contour::follow(probe, &region, x, pair, from) {
            Stop::Side {
                side,
                at,
                pair: arrived,
            } => {
                return (
                    BorderStop::Face {
                        face: faces[side],
                        at,
                        pair: arrived,
                        coping,
                    },
                    kinks,
                );
            }
            Stop::Leaves {
                at,
                pair: arrived,
                exit,
            } => {
                let (Exit::Fence(k), Barrier::Fences(fences)) = (exit, &region.barrier) else {
                    return (BorderStop::Lost { at }, kinks);
                };
                let fence = fences[k];
                let next = probe
                    .walls()
                    .neighbour_beside(fence.face, fence.edge, at)
                    .filter(|&f| probe.field().is_coping(f));
                let Some(next) = next else {
                    return (BorderStop::Lost { at }, kinks);
                };
                let normal = probe.field().normal(next);
                at_one_place = if at.distance(x) <= near {
                    at_one_place + 1
                } else {
                    0
                };
                if at_one_place > MOST_AT_ONE_PLACE {
                    return (BorderStop::Lost { at }, kinks);
                }
                add_kink(&mut kinks, start, Kink { at, pair: arrived }, near);
                // The neighbour runs the edge the other way; its inside lies left of that.
                pair = contour::aim(
                    probe,
                    at,
                    normal,
                    arrived,
                    normal.cross(fence.from - fence.to),
                );
                x = at;
                coping = next;
                from = Start::Plain;
            }
            Stop::Node { fan, arrived, .. } => {
                if fan.spokes.len() == 2 {
                    let on = fan.spokes[1 - arrived];
                    let kink = Kink {
                        at: fan.at,
                        pair: on.pair,
                    };
                    add_kink(&mut kinks, start, kink, near);
                    x = fan.at;
                    pair = on.pair;
                    from = Start::Vertex;
                    continue;
                }
                return (
                    BorderStop::Node {
                        fan,
                        arrived,
                        coping,
                    },
                    kinks,
                );
            }
            // A patch of coping has no stations.
            Stop::Station { .. } => return (BorderStop::Lost { at: x }, kinks),
            Stop::Fades { at, .. } | Stop::Lost { at } => {
                let Some(on) = over_pinch(probe, &region, at, near) else {
                    return (BorderStop::Lost { at }, kinks);
                };
                at_one_place += 1;
                if at_one_place > MOST_AT_ONE_PLACE {
                    return (BorderStop::Lost { at }, kinks);
                }
                let [left, right] = on.walls;
                pair = Pair { left, right };
                let corner = Kink {
                    at: on.corner,
                    pair,
                };
                add_kink(&mut kinks, start, corner, near);
                let normal = probe.field().normal(on.coping);
                pair = contour::aim(probe, on.at, normal, pair, on.at - on.corner);
                x = on.at;
                coping = on.coping;
                from = Start::Plain;
            }
        }
    }
    (BorderStop::Lost { at: x }, kinks)
}

/// The way on where a border runs into a corner in which its two walls touch.
fn over_pinch(probe: &Probe, region: &Region, at: DVec3, near: f64) -> Option<Onward> {
    /// How far from the corner walls are told apart again, in lengths that are one point.
    const CLEAR: f64 = 16.0;
    let Barrier::Fences(fences) = &region.barrier else {
        return None;
    };
    let gap = |fence: &&Fence| fence.from.distance(at);
    let corner = (fences.iter()).min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
    if gap(&corner) > 2.0 * CLEAR * near {
        return None;
    }
    probe
        .walls()
        .onward(corner.face, corner.edge, CLEAR * near)
        .filter(|on| region.excess(on.corner) <= near)
}

/// Adds a kink, unless the border is still where it bent last, as round a
/// corner of the coping.
fn add_kink(kinks: &mut Vec<Kink>, start: DVec3, kink: Kink, near: f64) {
    let last = kinks.last().map_or(start, |k| k.at);
    if last.distance(kink.at) > near {
        kinks.push(kink);
    }
}

/// The plane of a coping triangle inside a tetrahedron, fenced by the outline
/// of its flat patch; with the tetrahedron's face under each side.
fn patch_region(
    probe: &Probe,
    cage: &Cage,
    coping: FaceId,
) -> Option<(Region, SmallVec<[usize; 8]>)> {
    let field = probe.field();
    let normal = field.normal(coping);
    let origin = field.corners(coping)[0];
    let (low, high) = cage.bounds();
    let fences = probe
        .walls()
        .outline(coping)
        .iter()
        .filter_map(|&(face, edge)| {
            let c = field.corners(face);
            let (from, to) = (c[edge], c[(edge + 1) % 3]);
            let near = from.min(to).cmple(high).all() && from.max(to).cmpge(low).all();
            near.then_some(Fence {
                from,
                to,
                face,
                edge,
            })
        })
        .collect();
    let (corners, faces) = section(cage, normal, origin);
    let region = Region::new(corners, Barrier::Fences(fences))?;
    Some((region, faces))
}

/// The section of a tetrahedron with a plane, counter-clockwise round its
/// normal, and the face under each side.
fn section(
    cage: &Cage,
    normal: DVec3,
    origin: DVec3,
) -> (SmallVec<[DVec3; 8]>, SmallVec<[usize; 8]>) {
    // A square that holds the section, cut down by the four faces.
    let (ex, ey) = normal.any_orthonormal_pair();
    let middle = 0.25 * cage.corners.iter().sum::<DVec3>();
    let centre = middle - normal * normal.dot(middle - origin);
    let r = 2.0 * cage.size();
    let mut points: SmallVec<[DVec3; 8]> = SmallVec::from_slice(&[
        centre - r * (ex + ey),
        centre + r * (ex - ey),
        centre + r * (ex + ey),
        centre - r * (ex - ey),
    ]);
    let mut tags: SmallVec<[usize; 8]> = SmallVec::from_slice(&[usize::MAX; 4]);
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
                    next_tags.push(i);
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
