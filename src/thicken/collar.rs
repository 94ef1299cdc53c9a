//! The collar: the cross-section between the patch's boundary and the cut.
//!
//! Both run along the boundary curve, one on it and one at a height on the
//! strips above it, so a row of triangles between the two covers the collar.
//! Of all rows the one of least area is taken: on a flat strip every row that
//! does not fold has the same area, and at the bends between strips the row
//! that follows them has the least (Fuchs, Kedem and Uselton, "Optimal surface
//! reconstruction from planar contours", 1977; the paper fills its holes by
//! least area too, after Barequet and Sharir).
//!
//! The paper chooses or makes a boundary vertex for each boundary-curve cell
//! and splits the patch's triangles there. Here the boundary keeps the vertices
//! that it has, so not even a boundary triangle is split.

use glam::DVec3;

use crate::dual_contour::Numbers;
use crate::mesh::TriMesh;

use super::cut::Cut;
use super::patch::{OnRim, Patch};

/// Vertices of the cut nearer to each other than this, over its height, are
/// one.
const SAME: f64 = 1e-6;

/// A place along the boundary: edge, and fraction of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub edge: u32,
    pub way: f64,
}

/// Puts the vertices of the cut onto the strips and sectors they are next to,
/// at a distance of `level` from the patch; gives their places.
pub(super) fn settle(
    patch: &Patch,
    cut: &mut Cut,
    level: f64,
    numbers: Numbers,
) -> Vec<Vec<Place>> {
    let mut all = Vec::with_capacity(cut.curves.len());
    for curve in 0..cut.curves.len() {
        let mut places = Vec::with_capacity(cut.curves[curve].len());
        for &v in &cut.curves[curve] {
            let x = &mut cut.mesh.positions[v as usize];
            let (place, moved) = on_strip(patch, *x, level);
            *x = numbers.round_point(moved);
            places.push(place);
        }
        // What lay beside the line where two strips meet is now on it.
        let points: Vec<DVec3> = cut.curves[curve]
            .iter()
            .map(|&v| cut.mesh.positions[v as usize])
            .collect();
        let least = SAME * level;
        let kept = cut.merge(curve, |i, j| points[i].distance(points[j]) < least);
        all.push(kept.into_iter().map(|i| places[i]).collect());
    }
    all
}

/// The place next to a point, and the point moved to the height of the cut.
fn on_strip(patch: &Patch, x: DVec3, level: f64) -> (Place, DVec3) {
    let foot = patch.foot(x, 0);
    let rim = &patch.rim;
    let (edge, way) = match foot.rim {
        Some(OnRim::Vertex(v)) => {
            // A vertex of the boundary has edges.
            let after = rim.edges_at(v).map_or(0, |[_, after]| after);
            return (
                Place {
                    edge: after,
                    way: 0.0,
                },
                at_vertex(patch, x, v, level),
            );
        }
        Some(OnRim::Edge(e)) => (e, fraction(patch, x, e)),
        None => nearest(patch, x),
    };
    let e = &rim.edges[edge as usize];
    if way <= 0.0 || way >= 1.0 {
        let (v, edge) = if way <= 0.0 {
            (e.from, edge)
        } else {
            (e.to, rim.edges_at(e.to).map_or(edge, |[_, after]| after))
        };
        return (Place { edge, way: 0.0 }, at_vertex(patch, x, v, level));
    }
    let base = patch.position(e.from).lerp(patch.position(e.to), way);
    (Place { edge, way }, base + level * e.down)
}

fn fraction(patch: &Patch, x: DVec3, edge: u32) -> f64 {
    let e = &patch.rim.edges[edge as usize];
    let [a, b] = [e.from, e.to].map(|v| patch.position(v));
    ((x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0)
}

/// The boundary edge nearest to a point, and the fraction of it.
fn nearest(patch: &Patch, x: DVec3) -> (u32, f64) {
    let mut best = (f64::INFINITY, 0, 0.0);
    for (edge, e) in (0..).zip(&patch.rim.edges) {
        let way = fraction(patch, x, edge);
        let base = patch.position(e.from).lerp(patch.position(e.to), way);
        let square = base.distance_squared(x);
        if square < best.0 {
            best = (square, edge, way);
        }
    }
    (best.1, best.2)
}

/// The point over a boundary vertex: in the nearest of its sectors, or on the
/// line where its two strips meet.
fn at_vertex(patch: &Patch, x: DVec3, vertex: u32, level: f64) -> DVec3 {
    let rim = &patch.rim;
    let v = patch.position(vertex);
    let sectors = rim
        .sectors_at(vertex)
        .map(|s| rim.sectors[s as usize].outward);
    let nearest = sectors.min_by(|a, b| {
        let off = |n: &DVec3| (x - v).dot(*n).abs();
        off(a).total_cmp(&off(b))
    });
    if let Some(n) = nearest {
        let flat = (x - v) - (x - v).dot(n) * n;
        return v + level * flat.normalize_or_zero();
    }
    let Some([before, after]) = rim.edges_at(vertex) else {
        return x;
    };
    let [a, b] = [before, after].map(|e| &rim.edges[e as usize]);
    let mean = (a.down + b.down).normalize_or_zero();
    // Strips of nearly one plane do not fix a line.
    let line = a.outward.cross(b.outward);
    let along = if line.length() > 0.3 {
        line.normalize() * line.dot(mean).signum()
    } else {
        mean
    };
    let down = along.dot(a.down).min(along.dot(b.down)).max(0.1);
    v + (level / down) * along
}

/// Triangles of all collars; vertices of the cut are numbered from `first` on.
///
/// None if not every boundary curve has exactly one curve of the cut along it.
pub(super) fn join(
    patch: &Patch,
    cut: &Cut,
    places: &[Vec<Place>],
    first: u32,
) -> Option<Vec<[u32; 3]>> {
    let rim = &patch.rim;
    let mut along: Vec<Option<usize>> = vec![None; rim.loops.len()];
    for (i, places) in places.iter().enumerate() {
        let curve = |p: &Place| rim.edges[p.edge as usize].curve;
        let own = places.first().map(curve)?;
        let alone = along[own as usize].replace(i).is_none();
        if !alone || places.iter().any(|p| curve(p) != own) {
            return None;
        }
    }
    let mut triangles = Vec::new();
    for (&[from, to], cut_curve) in rim.loops.iter().zip(&along) {
        let i = (*cut_curve)?;
        // The cut runs against the boundary.
        let over: Vec<(u32, Place)> = cut.curves[i]
            .iter()
            .copied()
            .zip(places[i].iter().copied())
            .rev()
            .collect();
        let below: Vec<u32> = (from..to).map(|e| rim.edges[e as usize].from).collect();
        row(patch, &cut.mesh, &below, from, &over, first, &mut triangles);
    }
    Some(triangles)
}

/// Which end moves on in a triangle of the row.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Step {
    Below,
    Over,
}

/// Least-area row between a boundary curve and a curve of the cut.
fn row(
    patch: &Patch,
    cut: &TriMesh,
    below: &[u32],
    first_edge: u32,
    over: &[(u32, Place)],
    first: u32,
    out: &mut Vec<[u32; 3]>,
) {
    let (n, m) = (below.len(), over.len());
    // Position of each vertex over, in edges from the first; wrapped so that
    // the list begins nearest to the first boundary vertex.
    let param = |p: &Place| f64::from(p.edge - first_edge) + p.way;
    let start = (0..m)
        .min_by(|&i, &j| {
            let off = |k: usize| {
                let x = cut.positions[over[k].0 as usize];
                x.distance_squared(patch.position(below[0]))
            };
            off(i).total_cmp(&off(j))
        })
        .unwrap_or(0);
    let lower = |i: usize| patch.position(below[i % n]);
    let upper = |j: usize| cut.positions[over[(start + j) % m].0 as usize];
    // Unwrapped positions: from about 0 to about n.
    let mut at = Vec::with_capacity(m + 1);
    let mut last = 0.0;
    for j in 0..=m {
        let mut s = param(&over[(start + j) % m].1);
        let turns = ((last - s) / n as f64).round();
        s += turns * n as f64;
        last = s;
        at.push(s);
    }
    // Only pairs that are near each other along the boundary are tried.
    let windows: Vec<[usize; 2]> = (0..=n).map(|i| window(&at, i, n, m)).collect();
    let mut cost: Vec<Vec<(f64, Step)>> = Vec::with_capacity(n + 1);
    for i in 0..=n {
        let [from, to] = windows[i];
        let mut line = Vec::with_capacity(to - from + 1);
        for j in from..=to {
            let mut best = (f64::INFINITY, Step::Over);
            if i == 0 && j == 0 {
                best.0 = 0.0;
            }
            if i > 0 {
                let [low, high] = windows[i - 1];
                if (low..=high).contains(&j) {
                    let before = cost[i - 1][j - low].0;
                    let c = before + price(lower(i - 1), lower(i), upper(j));
                    if c < best.0 {
                        best = (c, Step::Below);
                    }
                }
            }
            if j > from {
                let before: (f64, Step) = line[j - 1 - from];
                let c = before.0 + price(upper(j - 1), upper(j), lower(i));
                if c < best.0 {
                    best = (c, Step::Over);
                }
            }
            line.push(best);
        }
        cost.push(line);
    }
    let (mut i, mut j) = (n, m);
    while i + j > 0 {
        let [low, high] = windows[i];
        let step = if (low..=high).contains(&j) {
            cost[i][j - low].1
        } else {
            Step::Over
        };
        let name = |j: usize| first + over[(start + j) % m].0;
        match step {
            Step::Below if i > 0 => {
                out.push([below[i % n], below[i - 1], name(j)]);
                i -= 1;
            }
            _ if j > 0 => {
                out.push([name(j - 1), name(j), below[i % n]]);
                j -= 1;
            }
            _ => {
                out.push([below[i % n], below[i - 1], name(j)]);
                i -= 1;
            }
        }
    }
}

/// Vertices over that boundary vertex `i` may be joined to: all whose place
/// is between its neighbours', and a few more.
fn window(at: &[f64], i: usize, n: usize, m: usize) -> [usize; 2] {
    const MORE: usize = 12;
    let (low, high) = (i as f64 - 1.0, i as f64 + 1.0);
    let first = at.iter().position(|&s| s >= low).unwrap_or(m);
    let last = at.iter().rposition(|&s| s <= high).unwrap_or(0);
    let from = if i == 0 {
        0
    } else {
        first.min(last).saturating_sub(MORE)
    };
    let to = if i == n {
        m
    } else {
        (first.max(last) + MORE).min(m)
    };
    [from, to]
}

/// Area, and a little for long diagonals, to choose between flat rows.
fn price(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.distance_squared(q));
    (b - a).cross(c - a).length() + 1e-3 * (sides[0] + sides[1] + sides[2])
}
