//! Short paths over the walls, from one footpoint to another.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use rustc_hash::FxHashSet;

use super::Walls;
use crate::field::Footpoint;
use crate::mesh::FaceId;

/// Triangles looked at before a path counts as long.
const PATH_BUDGET: usize = 4096;

/// Longest path, against the chord, through a corner of the part in which two
/// walls only touch: that of a square corner, with some room. Farther from it
/// they are two walls, however short the way through it.
const CORNER_WAY: f64 = 1.46;

impl Walls<'_> {
    /// The path between neighbours, over their common edge.
    pub(super) fn path_over_one(&self, a: &Footpoint, b: &Footpoint, length: f64) -> Option<Path> {
        let corners = self.field.corners(a.face);
        let k = (self.neighbours[a.face.index()].iter()).position(|&n| n == Some(b.face))?;
        let at = straight_crossing(a.point, b.point, [corners[k], corners[(k + 1) % 3]]);
        let path = Path::of(&[a.point, at, b.point]);
        (path.length <= length).then_some(path)
    }

    /// The path over wall triangles from `a` to `b`, if one of at most
    /// `length` is found. Best first (A*), each edge crossed where the way over it would
    /// be straight; the path found is then pulled taut over the edges that it
    /// crosses.
    pub(super) fn path(&self, a: &Footpoint, b: &Footpoint, length: f64) -> Option<Path> {
        /// How much longer than a taut one a path may be while it is searched.
        const SEARCH_SLACK: f64 = 1.15;
        if self.pieces[a.face.index()] != self.pieces[b.face.index()] {
            return None;
        }
        if let Some(path) = self.path_over_one(a, b, length) {
            return Some(path);
        }
        let mut seen: FxHashSet<FaceId> = FxHashSet::default();
        let mut open: BinaryHeap<(Reverse<Total>, u32)> = BinaryHeap::new();
        let mut ways = vec![Way {
            before: u32::MAX,
            face: a.face,
            walked: 0.0,
            at: a.point,
            edge: [a.point; 2],
            corner: false,
        }];
        let chord = a.point.distance(b.point);
        let most = |corner: bool| {
            if corner {
                length.min(CORNER_WAY * chord)
            } else {
                length
            }
        };
        open.push((Reverse(Total(0.0)), 0));
        while let Some((_, number)) = open.pop() {
            let way = ways[number as usize];
            if way.face == b.face {
                return Some(taut(&ways, number, b.point)).filter(|p| p.length <= most(way.corner));
            }
            if !seen.insert(way.face) {
                continue;
            }
            if seen.len() > PATH_BUDGET {
                return None;
            }
            let corners = self.field.corners(way.face);
            let mut step = |next: FaceId, edge: [DVec3; 2], corner: bool| {
                let at = straight_crossing(way.at, b.point, edge);
                let walked = way.walked + way.at.distance(at);
                let total = walked + at.distance(b.point);
                if total <= SEARCH_SLACK * most(corner) {
                    ways.push(Way {
                        before: number,
                        face: next,
                        walked,
                        at,
                        edge,
                        corner,
                    });
                    open.push((Reverse(Total(total)), ways.len() as u32 - 1));
                }
            };
            for k in 0..3 {
                let next = self.neighbours[way.face.index()][k];
                if let Some(next) = next.filter(|&n| self.is_way(n) && !seen.contains(&n)) {
                    step(next, [corners[k], corners[(k + 1) % 3]], way.corner);
                }
                let vertex = self.indices[way.face.index()][k];
                if self.parted[vertex as usize] {
                    for &next in self.around(vertex) {
                        if !seen.contains(&next) {
                            step(next, [corners[k]; 2], true);
                        }
                    }
                }
            }
        }
        None
    }
}

/// Where an edge is crossed by the shortest way from `a` to `b` over it.
pub(super) fn straight_crossing(a: DVec3, b: DVec3, [p, q]: [DVec3; 2]) -> DVec3 {
    let along = (q - p).normalize_or_zero();
    let length = (q - p).length();
    let (sa, sb) = ((a - p).dot(along), (b - p).dot(along));
    let ra = (a - p - sa * along).length();
    let rb = (b - p - sb * along).length();
    // Unfolded into one plane the way is straight and crosses the edge here.
    let s = if ra + rb > 0.0 {
        (sa * rb + sb * ra) / (ra + rb)
    } else {
        0.5 * (sa + sb)
    };
    p + s.clamp(0.0, length) * along
}

/// One triangle entered on a way over the walls.
#[derive(Clone, Copy, Debug)]
struct Way {
    before: u32,
    face: FaceId,
    walked: f64,
    /// Where the triangle was entered, and the edge that was crossed.
    at: DVec3,
    edge: [DVec3; 2],
    /// Whether it led through a corner in which walls only touch.
    corner: bool,
}

/// A path over the walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    pub(super) length: f64,
    /// Distance between the points at a quarter and three quarters of it.
    pub(super) waist: f64,
}

/// A way once its crossings have been moved to where they make it shortest.
fn taut(ways: &[Way], last: u32, end: DVec3) -> Path {
    const PASSES: usize = 12;
    let mut edges: Vec<[DVec3; 2]> = Vec::new();
    let mut points = vec![end];
    let mut number = last;
    while ways[number as usize].before != u32::MAX {
        let way = &ways[number as usize];
        edges.push(way.edge);
        points.push(way.at);
        number = way.before;
    }
    points.push(ways[number as usize].at);
    for _ in 0..PASSES {
        for k in 1..points.len() - 1 {
            points[k] = straight_crossing(points[k - 1], points[k + 1], edges[k - 1]);
        }
    }
    Path::of(&points)
}

impl Path {
    fn of(points: &[DVec3]) -> Path {
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let at = |wanted: f64| {
            let mut walked = 0.0;
            for w in points.windows(2) {
                let step = w[0].distance(w[1]);
                if walked + step >= wanted && step > 0.0 {
                    return w[0].lerp(w[1], (wanted - walked) / step);
                }
                walked += step;
            }
            points[points.len() - 1]
        };
        Path {
            length,
            waist: at(0.25 * length).distance(at(0.75 * length)),
        }
    }
}

/// A length to order by.
#[derive(Clone, Copy, PartialEq)]
struct Total(f64);

impl Eq for Total {}

impl PartialOrd for Total {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Total {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
