//! What leaves a point where several walls tie.
//!
//! Close to such a point every wall distance is linear: `d_k(x + e) = d + u_k . e`,
//! `u_k` being the unit vector from the footpoint to the point. The wall
//! nearest in direction `e` has the least `u_k . e`, which is the support of
//! the convex hull of the `u_k`. So the regions round the point are the hull's
//! vertices, the contours (in 3D: sheets) that leave it are the hull's edges,
//! and in 3D the seams are the hull's facets. This is the paper's circle of
//! footpoint tests (section 4.1) at radius zero: it cannot miss a contour, and
//! needs no radius.

use glam::DVec3;
use smallvec::SmallVec;

use crate::field::{Field, Footpoint};
use crate::mesh::FaceId;
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::distance_to;

/// One contour that leaves a point, in a plane.
#[derive(Clone, Copy, Debug)]
pub struct Spoke {
    /// The walls to its sides, for a walk away from the point.
    pub pair: Pair,
    /// Unit direction in the plane.
    pub direction: DVec3,
}

/// All mid-surface contours that leave a point in a plane, counter-clockwise.
#[derive(Clone, Debug)]
pub struct Fan {
    /// The point.
    pub at: DVec3,
    /// The contours; none where only fins meet.
    pub spokes: SmallVec<[Spoke; 4]>,
    /// Walls that tie here and are nearest in some direction, in order round it.
    pub walls: SmallVec<[FaceId; 6]>,
}

/// Footpoints closer than this, seen from a point at `distance`, are one.
pub fn one_place(distance: f64, tie: f64) -> f64 {
    8.0 * tie + 3.0 * (distance * tie).sqrt()
}

/// How unlike two pairs of walls are, each seen from its point: the sum of the
/// two gaps between the unit vectors from their footpoints, in the better order.
pub fn unlike([at, to]: [DVec3; 2], field: &Field, a: [FaceId; 2], b: [FaceId; 2]) -> f64 {
    let [p, q] = a.map(|w| distance_to(field, at, w).1);
    let [u, v] = b.map(|w| distance_to(field, to, w).1);
    (p.distance(u) + q.distance(v)).min(p.distance(v) + q.distance(u))
}

/// Largest [`unlike`] of one sheet: two gaps of some six degrees.
pub const ALIKE: f64 = 0.2;

/// Whether two pairs of walls that tie at a point make the same sheet there:
/// facets of one curved wall are beside each other, two walls are not.
pub fn alike(field: &Field, at: DVec3, a: [FaceId; 2], b: [FaceId; 2]) -> bool {
    unlike([at; 2], field, a, b) < ALIKE
}

/// Gathers the tied footpoints of `at` into `probe.feet`, one a place.
fn tied_feet(probe: &mut Probe, at: DVec3, distance: f64) -> SmallVec<[(FaceId, DVec3); 8]> {
    let tie = probe.walls().tolerances().tie;
    let mut feet = std::mem::take(&mut probe.feet);
    feet.clear();
    probe
        .field()
        .footpoints_within(at, distance + tie, &mut feet);
    let mut kept: SmallVec<[(FaceId, DVec3); 8]> = SmallVec::new();
    let mut points: SmallVec<[DVec3; 8]> = SmallVec::new();
    // Neighbours share a footpoint on their common edge, and a triangle beside
    // the footpoint is off by the square of its gap only: points at distance
    // `s` from a footpoint tie within `s * s / 2 d`. One footpoint is enough:
    // the nearest, so that rounding does not choose.
    let near = one_place(distance, tie);
    feet.sort_by(|a: &Footpoint, b| a.distance.total_cmp(&b.distance).then(a.face.cmp(&b.face)));
    for foot in &feet {
        if points.iter().all(|p| p.distance(foot.point) > near) {
            points.push(foot.point);
            kept.push((foot.face, (at - foot.point).normalize_or_zero()));
        }
    }
    probe.feet = feet;
    kept
}

/// The contours that leave `at` in the plane of `normal`, where walls tie at
/// `distance`.
pub fn fan(probe: &mut Probe, at: DVec3, normal: DVec3, distance: f64) -> Fan {
    let feet = tied_feet(probe, at, distance);
    let (ex, ey) = normal.any_orthonormal_pair();
    let flat: SmallVec<[(f64, f64); 8]> =
        feet.iter().map(|(_, u)| (u.dot(ex), u.dot(ey))).collect();
    let hull = convex_hull(&flat);
    let mut spokes = SmallVec::new();
    let count = hull.len();
    if count >= 2 {
        for k in 0..count {
            // Counter-clockwise hull: its outside lies to the right of the edge,
            // and the contour leaves towards the inside, the least support.
            let (i, j) = (hull[k], hull[(k + 1) % count]);
            let (dx, dy) = (flat[j].0 - flat[i].0, flat[j].1 - flat[i].1);
            let direction = (-dy * ex + dx * ey).normalize_or_zero();
            if direction == DVec3::ZERO || !probe.separate(at, feet[i].0, feet[j].0) {
                continue;
            }
            // Turning left from the contour makes `left` nearer: it has the
            // lesser projection on the left-hand normal of the contour.
            let hand = normal.cross(direction);
            let pair = if feet[i].1.dot(hand) < feet[j].1.dot(hand) {
                Pair {
                    left: feet[i].0,
                    right: feet[j].0,
                }
            } else {
                Pair {
                    left: feet[j].0,
                    right: feet[i].0,
                }
            };
            spokes.push(Spoke { pair, direction });
        }
    }
    Fan {
        at,
        spokes,
        walls: hull.iter().map(|&k| feet[k].0).collect(),
    }
}

/// One curve that leaves a junction: a hull facet with a wanted sheet in it.
#[derive(Clone, Debug)]
pub struct Ray {
    /// Unit direction.
    pub direction: DVec3,
    /// Walls that tie along it, in order round it.
    pub walls: SmallVec<[FaceId; 6]>,
    /// The sheets along it, as indices of two walls and the sheet's number in the star.
    pub sheets: SmallVec<[(usize, usize, usize); 4]>,
}

/// Everything that leaves a point in space.
#[derive(Clone, Debug)]
pub struct Star {
    /// The point.
    pub at: DVec3,
    /// Curves with at least one sheet.
    pub rays: Vec<Ray>,
    /// Number of sheets (hull edges) wanted; each lies along two rays.
    pub sheets: usize,
}

/// The curves and sheets that leave `at`, where walls tie at `distance`;
/// `None` where more walls tie than a junction of a part can have (the centre
/// of a sphere) or where they do not span space (no junction at all).
pub fn star(probe: &mut Probe, at: DVec3, distance: f64) -> Option<Star> {
    const MOST_WALLS: usize = 40;
    const FLAT: f64 = 1e-5;
    let feet = tied_feet(probe, at, distance);
    let n = feet.len();
    if !(4..=MOST_WALLS).contains(&n) {
        return None;
    }
    let mut facets: Vec<(DVec3, SmallVec<[usize; 6]>)> = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let mut normal = (feet[j].1 - feet[i].1).cross(feet[k].1 - feet[i].1);
                if normal.length() < 1e-9 {
                    continue;
                }
                normal = normal.normalize();
                let offset = normal.dot(feet[i].1);
                let (mut above, mut below) = (false, false);
                for foot in &feet {
                    let s = normal.dot(foot.1) - offset;
                    above |= s > FLAT;
                    below |= s < -FLAT;
                }
                if above == below {
                    // Inside the hull, or all in one plane.
                    if !above {
                        return None;
                    }
                    continue;
                }
                let inward = if above { normal } else { -normal };
                let offset = inward.dot(feet[i].1);
                let on: SmallVec<[usize; 6]> = (0..n)
                    .filter(|&m| (inward.dot(feet[m].1) - offset).abs() <= FLAT)
                    .collect();
                if facets.iter().all(|f| f.1 != on) {
                    facets.push((inward, on));
                }
            }
        }
    }
    // Sheets are numbered by their walls.
    let mut sheets: Vec<(usize, usize)> = Vec::new();
    let mut rays = Vec::new();
    for (direction, on) in facets {
        let (ex, ey) = direction.any_orthonormal_pair();
        let flat: SmallVec<[(f64, f64); 8]> = on
            .iter()
            .map(|&m| (feet[m].1.dot(ex), feet[m].1.dot(ey)))
            .collect();
        let ring: SmallVec<[usize; 8]> = convex_hull(&flat).iter().map(|&m| on[m]).collect();
        let mut ray = Ray {
            direction,
            walls: ring.iter().map(|&m| feet[m].0).collect(),
            sheets: SmallVec::new(),
        };
        for k in 0..ring.len() {
            let l = (k + 1) % ring.len();
            let (i, j) = (ring[k].min(ring[l]), ring[k].max(ring[l]));
            if !probe.separate(at, feet[i].0, feet[j].0) {
                continue;
            }
            let sheet = sheets.iter().position(|&s| s == (i, j)).unwrap_or_else(|| {
                sheets.push((i, j));
                sheets.len() - 1
            });
            ray.sheets.push((k, l, sheet));
        }
        if !ray.sheets.is_empty() {
            rays.push(ray);
        }
    }
    Some(Star {
        at,
        rays,
        sheets: sheets.len(),
    })
}

/// Counter-clockwise convex hull by monotone chain: indices of its corners,
/// points on its sides left out.
fn convex_hull(points: &[(f64, f64)]) -> SmallVec<[usize; 8]> {
    /// Twice the area below which a corner is none, the points lying in the unit disc.
    const FLAT: f64 = 1e-9;
    let mut order: SmallVec<[usize; 8]> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        points[a]
            .0
            .total_cmp(&points[b].0)
            .then(points[a].1.total_cmp(&points[b].1))
    });
    order.dedup_by(|a, b| {
        let (p, q) = (points[*a], points[*b]);
        (p.0 - q.0).abs() + (p.1 - q.1).abs() < 1e-9
    });
    if order.len() < 3 {
        return order;
    }
    let turn = |a: usize, b: usize, c: usize| {
        let (p, q, r) = (points[a], points[b], points[c]);
        (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0)
    };
    let mut hull: SmallVec<[usize; 8]> = SmallVec::new();
    for pass in 0..2 {
        let base = hull.len();
        for &p in &order {
            while hull.len() >= base + 2
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= FLAT
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        if pass == 0 {
            order.reverse();
        }
    }
    hull
}
