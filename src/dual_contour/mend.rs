//! Creases that were cut short, mended one triangle edge at a time.
//!
//! A crease may pass through a corner of a cell without crossing any of its
//! edges. No vertex of that cell, and no face or edge vertex, can lie on it
//! then, and its neighbours' triangles cut it short: the paper's third
//! limitation, small sharp features harmed. Here each such triangle edge gets
//! a vertex where the surface, or its crease, passes it. That vertex may lie
//! anywhere, so the proof of the contouring does not cover it; instead, the new
//! triangles are tested exactly against all triangles near them, and the split
//! is left undone if they cut one.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;
use smallvec::SmallVec;

use super::grid::{CellBox, Grid};
use super::implicit::Implicit;
use super::polygon::NEEDLE;
use super::vertex::{Candidate, Finder, Vertex, stray};
use crate::mesh::{clash, is_thin};

/// An edge over a crease strays by more than this fraction of a cell, or is
/// left as it is.
const LEAST: f64 = 0.003;

/// Normals at the ends of an edge over a crease differ by more than this (18
/// degrees), unless an end is on a crease itself.
const TURNED: f32 = 0.95;

/// Times that the halves of an edge are split again.
const ROUNDS: usize = 4;

/// Shortest edge that is split, in cells.
const SHORTEST: f64 = 0.02;

/// What mending did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MendCounts {
    /// Edges that strayed.
    pub strayed: u64,
    /// Edges that were split.
    pub split: u64,
    /// Splits left undone because triangles would have cut each other, or one
    /// of them would have been none.
    pub refused: u64,
    /// Closest-point queries.
    pub queries: u64,
}

/// Splits triangle edges that pass over a crease and stray from it by more
/// than `tolerance`.
pub(super) fn mend(
    solid: &impl Implicit,
    grid: &Grid,
    tolerance: f64,
    vertices: &mut Vec<Vertex>,
    triangles: &mut Vec<[u32; 3]>,
) -> MendCounts {
    let mut counts = MendCounts::default();
    if tolerance == f64::INFINITY {
        return counts;
    }
    let tolerance = tolerance.max(LEAST * grid.cell());
    let (asked, mut edges) = strayed(solid, tolerance, vertices, triangles);
    counts.queries = asked;
    counts.strayed = edges.len() as u64;
    // Doubling the lists for a few more would show in the peak memory.
    vertices.reserve_exact(edges.len());
    triangles.reserve_exact(2 * edges.len());
    let mut work = Work {
        solid,
        grid,
        tolerance,
        near: Near::new(grid, &edges, vertices, triangles),
        vertices,
        triangles,
        counts,
    };
    for _ in 0..ROUNDS {
        edges = edges
            .into_iter()
            .flat_map(|edge| work.split(edge).unwrap_or_default())
            .collect();
    }
    for slot in work.over_corners() {
        work.poke(slot);
    }
    work.counts
}

/// Edges whose middle strays, lower vertex first, sorted.
fn strayed(
    solid: &impl Implicit,
    tolerance: f64,
    vertices: &[Vertex],
    triangles: &[[u32; 3]],
) -> (u64, Vec<[u32; 2]>) {
    // Every edge is run once in each direction.
    let asked = |&[a, b]: &[u32; 2]| {
        let [v, w] = [a, b].map(|v| &vertices[v as usize]);
        let turned = v.sharp || w.sharp || v.normal.dot(w.normal) < TURNED;
        a < b && turned && stray(v, w) > 0.5 * tolerance
    };
    let edges: Vec<[u32; 2]> = triangles
        .par_iter()
        .flat_map_iter(|&[a, b, c]| [[a, b], [b, c], [c, a]].into_iter().filter(asked))
        .collect();
    let count = edges.len() as u64;
    let mut strayed: Vec<[u32; 2]> = edges
        .into_par_iter()
        .filter(|edge| {
            let [a, b] = edge.map(|v| vertices[v as usize].position);
            solid.sample(0.5 * (a + b), 0).value.abs() > tolerance
        })
        .collect();
    strayed.sort_unstable();
    (count, strayed)
}

struct Work<'a, I> {
    solid: &'a I,
    grid: &'a Grid,
    tolerance: f64,
    near: Near,
    vertices: &'a mut Vec<Vertex>,
    triangles: &'a mut Vec<[u32; 3]>,
    counts: MendCounts,
}

impl<I: Implicit> Work<'_, I> {
    /// Splits an edge if that mends it; the new edges that still stray.
    fn split(&mut self, [a, b]: [u32; 2]) -> Option<SmallVec<[[u32; 2]; 4]>> {
        // An edge between new vertices may be split from its other end first.
        let left = *self.near.halves.get(&[a, b])?;
        let right = *self.near.halves.get(&[b, a])?;
        let ends = [a, b].map(|v| self.vertices[v as usize].position);
        if ends[0].distance(ends[1]) < SHORTEST * self.grid.cell() {
            return None;
        }
        let found = self.vertex(ends)?;
        let c = opposite(self.triangles[left as usize], [a, b])?;
        let d = opposite(self.triangles[right as usize], [b, a])?;
        let m = self.vertices.len() as u32;
        self.vertices.push(found);
        let fresh = [[a, m, c], [m, b, c], [b, m, d], [m, a, d]];
        if self.cuts(&fresh, &[left, right]) {
            self.vertices.pop();
            self.counts.refused += 1;
            return None;
        }
        let slots = [
            left,
            self.triangles.len() as u32,
            right,
            self.triangles.len() as u32 + 1,
        ];
        self.triangles.extend([[0; 3]; 2]);
        for half in [[a, b], [b, a]] {
            self.near.halves.remove(&half);
        }
        for (slot, triangle) in slots.into_iter().zip(fresh) {
            self.triangles[slot as usize] = triangle;
            self.near.add(self.vertices, slot, triangle);
        }
        self.counts.split += 1;
        let mut next = SmallVec::new();
        for v in [a, b, c, d] {
            let middle = 0.5 * (self.vertices[v as usize].position + found.position);
            self.counts.queries += 1;
            if self.solid.sample(middle, 0).value.abs() > self.tolerance {
                next.push([v, m]);
            }
        }
        Some(next)
    }

    /// Triangles between three creases whose centre strays: a corner where the
    /// creases meet may stand over it.
    fn over_corners(&mut self) -> Vec<u32> {
        let sharp = |t: &[u32; 3]| t.iter().all(|&v| self.vertices[v as usize].sharp);
        let asked: Vec<u32> = (0..self.triangles.len() as u32)
            .filter(|&slot| sharp(&self.triangles[slot as usize]))
            .collect();
        self.counts.queries += asked.len() as u64;
        asked
            .into_par_iter()
            .filter(|&slot| {
                let [a, b, c] = self.corners(self.triangles[slot as usize]);
                let value = self.solid.sample((a + b + c) / 3.0, 0).value;
                value.abs() > self.tolerance
            })
            .collect()
    }

    /// Joins a triangle's corners to the corner of the surface over it.
    fn poke(&mut self, slot: u32) -> Option<()> {
        let old = self.triangles[slot as usize];
        let corners = self.corners(old);
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let mut finder = finder(self.solid, self.grid, centre);
        // The middles between two creases lie under the three sides.
        let samples = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| {
            let middle = 0.5 * (corners[i] + corners[j]);
            finder.sample(0.9 * middle + 0.1 * centre, 0)
        });
        let mut elements = samples.map(|(_, element)| element);
        let found = finder.meet(&mut elements, centre);
        self.counts.queries += finder.queries;
        let mut vertex = found?.vertex();
        vertex.sharp = true;
        vertex.position = self.grid.numbers().round_point(vertex.position);
        let size = corners.iter().map(|c| c.distance(centre));
        if vertex.position.distance(centre) > 1.5 * size.fold(0.0, f64::max) {
            return None;
        }
        let m = self.vertices.len() as u32;
        self.vertices.push(vertex);
        let [a, b, c] = old;
        let fresh = [[a, b, m], [b, c, m], [c, a, m]];
        if self.cuts(&fresh, &[slot]) {
            self.vertices.pop();
            self.counts.refused += 1;
            return None;
        }
        let next = self.triangles.len() as u32;
        self.triangles.extend([[0; 3]; 2]);
        for (slot, triangle) in [slot, next, next + 1].into_iter().zip(fresh) {
            self.triangles[slot as usize] = triangle;
            self.near.add(self.vertices, slot, triangle);
        }
        self.counts.split += 1;
        Some(())
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.vertices[v as usize].position)
    }

    /// The vertex that mends a chord.
    fn vertex(&mut self, [a, b]: [DVec3; 2]) -> Option<Vertex> {
        let middle = 0.5 * (a + b);
        let mut finder = finder(self.solid, self.grid, middle);
        // A crease near an end has all but that end on one side.
        let samples = [0.01, 0.5, 0.99].map(|t| finder.sample(a.lerp(b, t), 0));
        let worst = samples
            .iter()
            .fold(0.0, |worst: f64, (s, _)| worst.max(s.value.abs()));
        let found = finder.pass(&samples);
        self.counts.queries += finder.queries;
        let found = found?;
        let mut vertex = Vertex {
            sharp: true,
            ..found.vertex()
        };
        vertex.position = self.grid.numbers().round_point(vertex.position);
        let mends = found.value.abs() < 0.5 * worst;
        let beside = vertex.position.distance(middle) < 0.75 * a.distance(b);
        (mends && beside).then_some(vertex)
    }

    /// Whether new triangles cut each other or any that stay, as far as known,
    /// or are none.
    fn cuts(&self, fresh: &[[u32; 3]], gone: &[u32]) -> bool {
        let clash = |s: [u32; 3], t: [u32; 3]| clash([self.corners(s), self.corners(t)], [s, t]);
        let needle = |t: &[u32; 3]| is_thin(self.corners(*t), NEEDLE);
        fresh.iter().any(needle)
            || (0..fresh.len()).any(|i| {
                let Some(near) = self.near.around(self.vertices, fresh[i]) else {
                    return true;
                };
                let stays = |slot: &&u32| !gone.contains(*slot);
                (0..i).any(|j| clash(fresh[i], fresh[j]))
                    || (near.iter().filter(stays))
                        .any(|&slot| clash(fresh[i], self.triangles[slot as usize]))
            })
    }
}

/// A finder free to go a few cells from a place.
fn finder<'a, I>(solid: &'a I, grid: &'a Grid, place: DVec3) -> Finder<'a, I> {
    let half = DVec3::splat(0.5 * grid.cell());
    Finder {
        solid,
        grid,
        cell: CellBox {
            low: place - half,
            high: place + half,
        },
        crossings: &[],
        flat: None,
        queries: 0,
    }
}

impl<I: Implicit> Finder<'_, I> {
    /// Where a crease passes a chord of which three points were sampled.
    fn pass(&mut self, samples: &[(Candidate, u32); 3]) -> Option<Candidate> {
        [[0, 2], [0, 1], [1, 2]].into_iter().find_map(|pair| {
            let [(p, e), (q, f)] = pair.map(|i| samples[i]);
            let start = 0.5 * (p.position + q.position);
            p.turned(&q).then(|| self.meet(&mut [e, f], start))?
        })
    }
}

/// The corner of a triangle beside one of its edges, run in its direction.
fn opposite(triangle: [u32; 3], edge: [u32; 2]) -> Option<u32> {
    let [a, b, c] = triangle;
    [[a, b, c], [b, c, a], [c, a, b]]
        .into_iter()
        .find(|&[a, b, _]| [a, b] == edge)
        .map(|[_, _, c]| c)
}

/// Triangles near the edges to be split by place, and those at such edges and
/// all new ones by half-edge.
struct Near {
    /// Edge length of a bucket.
    size: f64,
    /// Buckets that all triangles were put into.
    known: FxHashSet<IVec3>,
    buckets: FxHashMap<IVec3, Vec<u32>>,
    halves: FxHashMap<[u32; 2], u32>,
}

impl Near {
    fn new(grid: &Grid, edges: &[[u32; 2]], vertices: &[Vertex], triangles: &[[u32; 3]]) -> Near {
        let mut near = Near {
            size: 2.0 * grid.cell(),
            known: FxHashSet::default(),
            buckets: FxHashMap::default(),
            halves: FxHashMap::default(),
        };
        for edge in edges {
            let [a, b] = edge.map(|v| near.bucket(vertices[v as usize].position));
            near.known.extend(between(a.min(b) - 1, a.max(b) + 1));
        }
        let asked: FxHashSet<[u32; 2]> =
            edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        let chosen: Vec<u32> = triangles
            .par_iter()
            .enumerate()
            .filter(|(_, t)| near.span(vertices, **t).any(|b| near.known.contains(&b)))
            .map(|(slot, _)| slot as u32)
            .collect();
        for slot in chosen {
            let triangle = triangles[slot as usize];
            near.place(vertices, slot, triangle);
            for half in halves(triangle).filter(|half| asked.contains(half)) {
                near.halves.insert(half, slot);
            }
        }
        near
    }

    fn bucket(&self, p: DVec3) -> IVec3 {
        (p / self.size).floor().as_ivec3()
    }

    /// Buckets that a triangle's box touches.
    fn span(&self, vertices: &[Vertex], triangle: [u32; 3]) -> impl Iterator<Item = IVec3> + use<> {
        let [a, b, c] = triangle.map(|v| self.bucket(vertices[v as usize].position));
        between(a.min(b).min(c), a.max(b).max(c))
    }

    /// Adds a new triangle, now in this slot.
    fn add(&mut self, vertices: &[Vertex], slot: u32, triangle: [u32; 3]) {
        self.place(vertices, slot, triangle);
        self.halves
            .extend(halves(triangle).map(|half| (half, slot)));
    }

    fn place(&mut self, vertices: &[Vertex], slot: u32, triangle: [u32; 3]) {
        for bucket in self.span(vertices, triangle) {
            let list = self.buckets.entry(bucket).or_default();
            if !list.contains(&slot) {
                list.push(slot);
            }
        }
    }

    /// Slots of triangles that may touch a new one; none if it reaches where
    /// they are not known.
    fn around(&self, vertices: &[Vertex], triangle: [u32; 3]) -> Option<Vec<u32>> {
        if !self
            .span(vertices, triangle)
            .all(|b| self.known.contains(&b))
        {
            return None;
        }
        let mut slots: Vec<u32> = self
            .span(vertices, triangle)
            .filter_map(|bucket| self.buckets.get(&bucket))
            .flatten()
            .copied()
            .collect();
        slots.sort_unstable();
        slots.dedup();
        Some(slots)
    }
}

/// The edges of a triangle in its direction.
fn halves([a, b, c]: [u32; 3]) -> impl Iterator<Item = [u32; 2]> {
    [[a, b], [b, c], [c, a]].into_iter()
}

fn between(low: IVec3, high: IVec3) -> impl Iterator<Item = IVec3> {
    (low.z..=high.z).flat_map(move |z| {
        (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| IVec3::new(x, y, z)))
    })
}
