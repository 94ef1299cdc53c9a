//! Flat ends: where the balls of a border are cut off.
//!
//! The thickening paper leaves out B(S), the points whose closest point of the
//! surface is on its boundary. Of a flat sheet that is all beyond the planes
//! through the border's edges that stand on the sheet. Taken to the letter, a
//! faceted sheet would get small notches, because the closest point of what
//! lies over a bend of the border moves with the bend; so here the planes
//! themselves are the end: that of the nearest border edge, and near a corner
//! both, joined where the border turns towards the sheet, cut with each other
//! where it turns away.

use std::collections::VecDeque;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::slab::Slab;
use super::surface::{BallSurface, FlatEdge, edges, key};
use crate::mesh::Bounds;

/// Slabs farther from a border than this, over their greatest radius, do not
/// reach past it.
const PASSES: f64 = 1.01;

/// Border edges farther from a slab than this, over its greatest radius, are
/// nearest to no point of it: a radius to the point, and one from there.
const NEAREST: f64 = 2.5;

/// A cut ends as far from its edge as this, over the slab's greatest radius:
/// beyond it lies another piece of the sheet, if anything.
const REACH: f64 = 2.0;

/// The plane that ends the solid at one border edge.
#[derive(Clone, Copy, Debug)]
struct End {
    points: [DVec3; 2],
    /// Unit, square to the edge and to the sheet, away from the sheet; zero for
    /// an edge without length.
    outward: DVec3,
    /// What goes on at either point.
    next: [Option<Turn>; 2],
}

/// The next flat edge along the border.
#[derive(Clone, Copy, Debug)]
struct Turn {
    end: u32,
    /// The solid is where both planes say so; else where one of them does.
    convex: bool,
}

/// All flat ends of a surface.
#[derive(Clone, Debug)]
pub(super) struct Ends {
    ends: Vec<End>,
    /// Triangle of each.
    triangles: Vec<u32>,
    /// Ends near each slab that reaches past one: `lists[first[s]..first[s + 1]]`.
    first: Vec<u32>,
    lists: Vec<u32>,
}

impl Ends {
    pub fn new(surface: &BallSurface, slabs: &[Slab]) -> Ends {
        let around = edges(&surface.triangles);
        let fans: Vec<[Fan; 2]> = (surface.flat.iter())
            .map(|flat| {
                flat.ends
                    .map(|pivot| Fan::walk(surface, &around, flat, pivot))
            })
            .collect();
        let (ends, triangles): (Vec<End>, Vec<u32>) = (surface.flat.iter().zip(&fans))
            .map(|(flat, fans)| {
                let points = flat.ends.map(|v| surface.positions[v as usize]);
                let normal = fans[0].normal + fans[1].normal;
                let end = End {
                    points,
                    outward: (points[1] - points[0]).cross(normal).normalize_or_zero(),
                    next: [None; 2],
                };
                (end, flat.triangle)
            })
            .unzip();
        let mut ends = Ends {
            ends,
            triangles,
            first: Vec::new(),
            lists: Vec::new(),
        };
        ends.link(surface, &fans);
        ends.list(surface, slabs, &around);
        ends
    }

    /// Number of ends.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Triangle that an end belongs to.
    pub fn triangle(&self, end: u32) -> Option<u32> {
        self.triangles.get(end as usize).copied()
    }

    /// Value and gradient of one end's plane: positive beyond the end.
    pub fn plane(&self, end: u32, p: DVec3) -> (f64, DVec3) {
        let end = &self.ends[end as usize];
        (end.value(p), end.outward)
    }

    /// How far `p` is beyond the border as far as a slab is concerned
    /// (negative before it), and the end that says so. None if the slab does
    /// not reach past a border.
    pub fn beyond(&self, slab: u32, radius: f64, p: DVec3) -> Option<(f64, u32)> {
        let range = self.first[slab as usize] as usize..self.first[slab as usize + 1] as usize;
        let mut best: Option<(f64, u32, Option<usize>)> = None;
        for &at in &self.lists[range] {
            let (square, corner) = self.ends[at as usize].nearest(p);
            if best.is_none_or(|b| square < b.0) {
                best = Some((square, at, corner));
            }
        }
        let (square, at, corner) = best?;
        let end = &self.ends[at as usize];
        let mut value = end.value(p);
        let mut decides = at;
        if let Some(turn) = corner.and_then(|c| end.next[c]) {
            let other = self.ends[turn.end as usize].value(p);
            if (other > value) == turn.convex && other != value {
                (value, decides) = (other, turn.end);
            }
        }
        Some((value.min(REACH * radius - square.sqrt()), decides))
    }

    /// Joins neighbours along the border.
    fn link(&mut self, surface: &BallSurface, fans: &[[Fan; 2]]) {
        let at: FxHashMap<[u32; 2], u32> = (0..)
            .zip(&surface.flat)
            .map(|(i, flat)| (key(flat.ends[0], flat.ends[1]), i))
            .collect();
        for (i, flat) in surface.flat.iter().enumerate() {
            for (k, fan) in fans[i].iter().enumerate() {
                let plain = |end: &&u32| {
                    let end = **end as usize;
                    end != i && self.ends[end].outward != DVec3::ZERO
                };
                if let Some(&end) = at.get(&fan.last).filter(plain) {
                    let pivot = surface.positions[flat.ends[k] as usize];
                    let convex = self.is_convex(i, end as usize, pivot);
                    self.ends[i].next[k] = Some(Turn { end, convex });
                }
            }
        }
    }

    /// Whether the border turns towards the sheet where two ends meet.
    fn is_convex(&self, a: usize, b: usize, pivot: DVec3) -> bool {
        let (a, b) = (&self.ends[a], &self.ends[b]);
        let middle = |end: &End| 0.5 * (end.points[0] + end.points[1]) - pivot;
        let unit = |v: DVec3| v.normalize_or_zero();
        a.outward.dot(unit(middle(b))) + b.outward.dot(unit(middle(a))) < 0.0
    }

    /// Lists, for each slab that reaches past an end, the ends near it on the
    /// same sheet, found from triangle to triangle.
    fn list(
        &mut self,
        surface: &BallSurface,
        slabs: &[Slab],
        around: &FxHashMap<[u32; 2], Vec<u32>>,
    ) {
        let neighbours: Vec<[Option<u32>; 3]> = (0..)
            .zip(&surface.triangles)
            .map(|(t, c)| {
                [[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]].map(|[a, b]| {
                    match around.get(&key(a, b)).map(Vec::as_slice) {
                        Some(&[x, y]) => Some(if x == t { y } else { x }),
                        _ => None,
                    }
                })
            })
            .collect();
        let mut seen = vec![u32::MAX; slabs.len()];
        let mut queue = VecDeque::new();
        // Calls `found` with every slab within `reach` radii of each end.
        let mut each_near = |reach: f64, found: &mut dyn FnMut(u32, u32)| {
            seen.fill(u32::MAX);
            // An edge without length or without a sheet has no plane.
            let planes = (0..)
                .zip(&self.ends)
                .filter(|(_, end)| end.outward != DVec3::ZERO);
            for (e, end) in planes {
                let own = self.triangles[e as usize];
                let bounds = Bounds::of(end.points);
                seen[own as usize] = e;
                queue.push_back(own);
                while let Some(t) = queue.pop_front() {
                    found(t, e);
                    for next in neighbours[t as usize].into_iter().flatten() {
                        let slab = &slabs[next as usize];
                        let fresh = seen[next as usize] != e;
                        if fresh && gap(&bounds, slab) <= reach * slab.greatest_radius() {
                            seen[next as usize] = e;
                            queue.push_back(next);
                        }
                    }
                }
            }
        };
        let mut passes = vec![false; slabs.len()];
        each_near(PASSES, &mut |slab, _| passes[slab as usize] = true);
        let mut pairs = Vec::new();
        each_near(NEAREST, &mut |slab, end| {
            if passes[slab as usize] {
                pairs.push((slab, end));
            }
        });
        pairs.sort_unstable();
        self.first = vec![0; slabs.len() + 1];
        for &(slab, _) in &pairs {
            self.first[slab as usize + 1] += 1;
        }
        for i in 0..slabs.len() {
            self.first[i + 1] += self.first[i];
        }
        self.lists = pairs.into_iter().map(|(_, end)| end).collect();
    }
}

impl End {
    fn value(&self, p: DVec3) -> f64 {
        (p - self.points[0]).dot(self.outward)
    }

    /// Square of the distance to the edge, and the end of it that is nearest
    /// unless the nearest point lies between.
    fn nearest(&self, p: DVec3) -> (f64, Option<usize>) {
        let [a, b] = self.points;
        let way = b - a;
        let t = (p - a).dot(way) / way.length_squared();
        // An edge without length is a point.
        if t >= 1.0 {
            (p.distance_squared(b), Some(1))
        } else if t > 0.0 {
            (p.distance_squared(a + t * way), None)
        } else {
            (p.distance_squared(a), Some(0))
        }
    }
}

/// The triangles around one end of a flat edge, up to the next edge that is
/// not between two triangles: along the sheet, not over a seam.
struct Fan {
    /// Sum of their normals by area, all to the side of the first one's.
    normal: DVec3,
    /// The edge where the walk ended.
    last: [u32; 2],
}

impl Fan {
    fn walk(
        surface: &BallSurface,
        around: &FxHashMap<[u32; 2], Vec<u32>>,
        flat: &FlatEdge,
        pivot: u32,
    ) -> Fan {
        let mut fan = Fan {
            normal: DVec3::ZERO,
            last: key(flat.ends[0], flat.ends[1]),
        };
        let mut triangle = flat.triangle;
        let mut side = 1.0;
        // A fan has at most as many triangles as the surface.
        for _ in 0..surface.triangles.len() {
            let corners = surface.triangles[triangle as usize];
            let [a, b, c] = corners.map(|v| surface.positions[v as usize]);
            fan.normal += side * (b - a).cross(c - a);
            let Some(next) = other_edge(corners, pivot, fan.last) else {
                break;
            };
            fan.last = next;
            let Some(&[x, y]) = around.get(&next).map(Vec::as_slice) else {
                break;
            };
            let beyond = if x == triangle { y } else { x };
            if runs(corners, next) == runs(surface.triangles[beyond as usize], next) {
                side = -side;
            }
            triangle = beyond;
        }
        fan
    }
}

/// Whether a triangle runs an edge of its own from its first vertex to the
/// second.
fn runs(corners: [u32; 3], [a, b]: [u32; 2]) -> bool {
    (0..3).any(|i| corners[i] == a && corners[(i + 1) % 3] == b)
}

/// The other edge of a triangle at a vertex.
fn other_edge(corners: [u32; 3], pivot: u32, edge: [u32; 2]) -> Option<[u32; 2]> {
    let sides = [0, 1, 2].map(|i| key(corners[i], corners[(i + 1) % 3]));
    sides
        .into_iter()
        .find(|side| *side != edge && side.contains(&pivot))
}

/// Lower bound of the distance from a slab's triangle to a box.
fn gap(bounds: &Bounds, slab: &Slab) -> f64 {
    let own = Bounds::of(slab.corners());
    let gap = (own.min - bounds.max).max(bounds.min - own.max);
    gap.max(DVec3::ZERO).length()
}
