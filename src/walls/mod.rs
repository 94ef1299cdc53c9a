//! Which footpoints belong to one wall, and how thick walls are.
//!
//! A mid-surface point has two footpoints on *separate* walls. Two footpoints
//! that a short path over wall triangles joins lie on one wall: the ball sits
//! in a convex edge or round of it, and the sheet between them is a fin
//! (Bloomenthal 2011, section 6, asks for manual pruning of these). The path
//! is the medial geodesic function of Dey and Sun (2006), asked locally:
//! coping cuts it, so a web is never mistaken for a fin, however weak its
//! object angle.

mod path;
pub mod pinch;
pub mod thickness;

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::field::{Field, Footpoint};
use crate::mesh::{FaceId, Part, angle};
use path::straight_crossing;

/// Largest object angle of a fin: that of a convex edge of 45 degrees. A wall
/// that narrows to a sharper edge is a tapered wall, and its sheet is wanted.
pub const MAX_FIN_ANGLE: f64 = 135.0;

/// Longest path, against the chord, that leads round a convex edge, round or
/// rim corner of 45 degrees or more: 1 / sin(45 / 2).
const LONGEST_WAY: f64 = 2.62;

/// A path round one corner narrows towards it: its quarter points are half a
/// chord apart for a sharp corner, 0.71 for a full round. The path round the
/// end of a web does not: 1. A bump lower than 0.3 of its width narrows too,
/// and has no sheet of its own.
const NARROWS: f64 = 0.8;

/// Path against chord of a footpoint that slides along one smooth wall.
const SLIDE_WAY: f64 = 1.1;

/// Path against chord on a plain curved wall: an arc of 50 degrees.
const PLAIN_WAY: f64 = 1.03;

/// Gap of two footpoints, against their distance, that is no jump yet.
const HARDLY_MOVED: f64 = 0.1;

/// Coping triangles joined to flat patches, so that a border that runs along
/// an edge inside a flat end face, or through a corner, meets nothing there.
struct Patches {
    of: Vec<Option<u32>>,
    outlines: Vec<Vec<(FaceId, usize)>>,
}

impl Patches {
    fn new(field: &Field, neighbours: &[[Option<FaceId>; 3]]) -> Patches {
        /// Sine of the angle below which two triangles are in one plane.
        const FLAT: f64 = 1e-6;
        let count = field.face_count();
        let mut patches = Patches {
            of: vec![None; count],
            outlines: Vec::new(),
        };
        for seed in (0..count as u32).map(FaceId) {
            if !field.is_coping(seed) || patches.of[seed.index()].is_some() {
                continue;
            }
            let number = patches.outlines.len() as u32;
            // Every triangle is held against the first one, so that a curved
            // rim of many flat steps does not become one patch.
            let normal = field.normal(seed);
            let mut outline = Vec::new();
            let mut open = vec![seed];
            patches.of[seed.index()] = Some(number);
            while let Some(face) = open.pop() {
                for (k, next) in neighbours[face.index()].into_iter().enumerate() {
                    let next = next.filter(|&n| {
                        field.is_coping(n)
                            && field.normal(n).dot(normal) > 0.0
                            && field.normal(n).cross(normal).length() < FLAT
                    });
                    match next {
                        Some(n) if patches.of[n.index()] == Some(number) => {}
                        Some(n) if patches.of[n.index()].is_none() => {
                            patches.of[n.index()] = Some(number);
                            open.push(n);
                        }
                        _ => outline.push((face, k)),
                    }
                }
            }
            outline.sort_unstable();
            patches.outlines.push(outline);
        }
        patches
    }
}

/// What counts as a separate pair of footpoints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Smallest object angle of a sheet, degrees.
    pub min_angle: f64,
    /// Keep fins stronger than this object angle, degrees; `None` prunes all.
    pub keep_fins_from: Option<f64>,
}

/// Least object angle of a fin that is kept: above the facet angle of usual
/// tessellations.
const KEPT_FIN_ANGLE: f64 = 40.0;

impl Separation {
    /// Of sheets with at least this object angle, degrees, fins pruned or kept.
    pub fn new(min_angle: f64, keep_fins: bool) -> Separation {
        Separation {
            min_angle,
            keep_fins_from: keep_fins.then_some(KEPT_FIN_ANGLE.max(min_angle)),
        }
    }
}

/// Lengths below which things are equal; all in part units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Newton steps and roots stop here: 1e-13 of the part's size.
    pub solve: f64,
    /// Distances that differ by less are tied: 2e-7 of the part's size, a
    /// little more than what single-precision input is off by.
    pub tie: f64,
}

/// The field with what tells walls apart. Shared by all threads.
pub struct Walls<'a> {
    field: &'a Field,
    neighbours: Vec<[Option<FaceId>; 3]>,
    indices: Vec<[u32; 3]>,
    /// Wall triangles at each vertex: `around[first[v]..first[v + 1]]`.
    first: Vec<u32>,
    around: Vec<FaceId>,
    /// Whether coping parts the walls at a vertex, so that they touch there only.
    parted: Vec<bool>,
    /// Number of the connected piece of wall that each triangle belongs to.
    pieces: Vec<u32>,
    patches: Patches,
    separation: Separation,
    tolerances: Tolerances,
}

impl<'a> Walls<'a> {
    /// Joins a field with the adjacency of its part.
    pub fn new(part: &Part, field: &'a Field, separation: Separation) -> Walls<'a> {
        let triangles = &part.mesh().triangles;
        let mut open: FxHashMap<(u32, u32), (u32, usize)> = FxHashMap::default();
        let mut neighbours = vec![[None; 3]; triangles.len()];
        for (f, t) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                match open.remove(&(b, a)) {
                    Some((g, j)) => {
                        neighbours[f][k] = Some(FaceId(g));
                        neighbours[g as usize][j] = Some(FaceId(f as u32));
                    }
                    None => {
                        open.insert((a, b), (f as u32, k));
                    }
                }
            }
        }
        let (low, high) = field.bounds();
        let size = (high - low).length();
        let vertices = part.mesh().positions.len();
        let wall_corners = || {
            let walls = (0..triangles.len() as u32)
                .map(FaceId)
                .filter(|&f| !field.is_coping(f));
            walls.flat_map(|f| triangles[f.index()].map(|v| (v as usize, f)))
        };
        let mut first = vec![0u32; vertices + 1];
        wall_corners().for_each(|(v, _)| first[v + 1] += 1);
        for v in 0..vertices {
            first[v + 1] += first[v];
        }
        let mut around = vec![FaceId(0); first[vertices] as usize];
        let mut next = first.clone();
        for (v, f) in wall_corners() {
            around[next[v] as usize] = f;
            next[v] += 1;
        }
        let mut ends = vec![0u8; vertices];
        for (f, t) in triangles
            .iter()
            .enumerate()
            .filter(|t| is_way(field, FaceId(t.0 as u32)))
        {
            for k in 0..3 {
                let open = neighbours[f][k].is_none_or(|n| !is_way(field, n));
                ends[t[k] as usize] = ends[t[k] as usize].saturating_add(u8::from(open));
            }
        }
        let parted = ends.iter().map(|&ends| ends > 1).collect();
        let pieces = pieces(triangles, vertices, |f| !is_way(field, f));
        Walls {
            field,
            pieces,
            first,
            around,
            parted,
            patches: Patches::new(field, &neighbours),
            neighbours,
            indices: triangles.clone(),
            separation,
            tolerances: Tolerances {
                solve: 1e-13 * size,
                tie: 2e-7 * size,
            },
        }
    }

    /// The field underneath.
    pub fn field(&self) -> &Field {
        self.field
    }

    /// Lengths that count as equal.
    pub fn tolerances(&self) -> Tolerances {
        self.tolerances
    }

    /// The triangle across edge `k` beside `at`, hopping over triangles without
    /// area that fill the gap where a long edge meets several short ones.
    pub fn neighbour_beside(&self, face: FaceId, k: usize, at: DVec3) -> Option<FaceId> {
        const MOST_HOPS: usize = 64;
        let (mut from, mut next) = (face, self.neighbours[face.index()][k]?);
        for _ in 0..MOST_HOPS {
            if self.field.normal(next) != DVec3::ZERO {
                return Some(next);
            }
            let corners = self.field.corners(next);
            let gap = |j: usize| {
                let edge = [corners[j], corners[(j + 1) % 3]];
                straight_crossing(at, at, edge).distance(at)
            };
            let others = self.neighbours[next.index()];
            let out = (0..3)
                .filter(|&j| others[j].is_some_and(|n| n != from))
                .min_by(|&i, &j| gap(i).total_cmp(&gap(j)))?;
            (from, next) = (next, others[out]?);
        }
        None
    }

    /// The outline of the flat patch that a coping triangle belongs to: its
    /// edges, each as a triangle of the patch and the edge's number there.
    pub fn outline(&self, coping: FaceId) -> &[(FaceId, usize)] {
        match self.patches.of[coping.index()] {
            Some(patch) => &self.patches.outlines[patch as usize],
            None => &[],
        }
    }

    /// Wall triangles at a vertex.
    fn around(&self, vertex: u32) -> &[FaceId] {
        &self.around[self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize]
    }

    /// The triangle that holds the footpoint of `x` on the wall that `face` is
    /// part of: descends from triangle to triangle round their corners, over
    /// reflex edges and bends of at most `crease` degrees, never over a
    /// sharper convex edge, where the footpoint would jump.
    pub fn settle(&self, x: DVec3, face: FaceId, crease: f64) -> FaceId {
        const MOST: usize = 256;
        let cosine = crease.to_radians().cos();
        let mut here = self.field.footpoint_on(x, face);
        for _ in 0..MOST {
            let away = (x - here.point).normalize_or_zero();
            let mut best = here;
            for v in self.indices[here.face.index()] {
                for &next in self.around(v) {
                    let foot = self.field.footpoint_on(x, next);
                    let nearer = foot.distance < best.distance * (1.0 - 1e-14);
                    if nearer
                        && ((x - foot.point).normalize_or_zero().dot(away) >= cosine
                            || (self.smooth_neighbours(here.face, next, crease)
                                && self.steps_over(&here, &foot)))
                    {
                        best = foot;
                    }
                }
            }
            if best.face == here.face {
                break;
            }
            here = best;
        }
        here.face
    }

    /// Whether two triangles share an edge that is reflex or bends by at most
    /// `angle` degrees: a footpoint passes it without a jump worth a vertex.
    pub fn smooth_neighbours(&self, a: FaceId, b: FaceId, angle: f64) -> bool {
        let Some(k) = self.neighbours[a.index()]
            .iter()
            .position(|&n| n == Some(b))
        else {
            return false;
        };
        let (na, nb) = (self.field.normal(a), self.field.normal(b));
        if na.dot(nb) >= angle.to_radians().cos() {
            return true;
        }
        let corners = self.field.corners(a);
        // Out of `a` across the edge: at a convex edge the neighbour's normal leans that way.
        let out = (corners[(k + 1) % 3] - corners[k]).cross(na);
        nb.dot(out) < 0.0
    }

    /// Whether two tied footpoints of `x` make `x` a point of the mid-surface.
    pub fn separate(&self, x: DVec3, a: &Footpoint, b: &Footpoint) -> bool {
        if a.face == b.face {
            return false;
        }
        let chord = a.point.distance(b.point);
        if chord <= 4.0 * self.tolerances.tie {
            return false;
        }
        let angle = object_angle(x, a, b);
        if angle > MAX_FIN_ANGLE {
            return true;
        }
        if angle < self.separation.min_angle {
            return false;
        }
        if self
            .separation
            .keep_fins_from
            .is_some_and(|least| angle >= least)
        {
            return true;
        }
        !self
            .path(a, b, LONGEST_WAY * chord)
            .is_some_and(|p| p.waist < NARROWS * chord)
    }

    /// Whether a footpoint may slide from `a` to `b` along one smooth wall.
    pub fn slides(&self, a: &Footpoint, b: &Footpoint) -> bool {
        if a.face == b.face {
            return true;
        }
        let chord = a.point.distance(b.point);
        chord <= 4.0 * self.tolerances.tie || self.path(a, b, longest_slide(a, b)).is_some()
    }

    /// Whether a footpoint may slide over the common edge of two neighbours: round
    /// the corner of a notch in one flat wall it jumps.
    fn steps_over(&self, a: &Footpoint, b: &Footpoint) -> bool {
        let chord = a.point.distance(b.point);
        chord <= 4.0 * self.tolerances.tie
            || self.path_over_one(a, b, longest_slide(a, b)).is_some()
    }

    /// Whether the wall between two footpoints is plain: the way over it is
    /// straight, or bends no more than a smooth wall may, with nothing to go round.
    pub fn plain_between(&self, a: &Footpoint, b: &Footpoint) -> bool {
        let chord = a.point.distance(b.point);
        if a.face == b.face || chord <= 4.0 * self.tolerances.tie {
            return true;
        }
        let flat = self.field.normal(a.face).dot(self.field.normal(b.face)) > 1.0 - 1e-12;
        let way = if flat { 1.0 + 1e-6 } else { PLAIN_WAY };
        self.path(a, b, way * chord).is_some()
    }

    fn is_way(&self, face: FaceId) -> bool {
        is_way(self.field, face)
    }
}

/// Whether a path may lead over a triangle: walls, and triangles without area,
/// which part nothing whatever their tag.
fn is_way(field: &Field, face: FaceId) -> bool {
    !field.is_coping(face) || field.normal(face) == DVec3::ZERO
}

/// Labels walls by connected piece: triangles that share a vertex are of one.
fn pieces(triangles: &[[u32; 3]], vertices: usize, is_coping: impl Fn(FaceId) -> bool) -> Vec<u32> {
    let mut root: Vec<u32> = (0..vertices as u32).collect();
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for (f, t) in triangles.iter().enumerate() {
        if is_coping(FaceId(f as u32)) {
            continue;
        }
        for k in 1..3 {
            let (a, b) = (find(&mut root, t[0]), find(&mut root, t[k]));
            root[a.max(b) as usize] = a.min(b);
        }
    }
    triangles.iter().map(|t| find(&mut root, t[0])).collect()
}

/// Longest path by which a footpoint slides from `a` to `b`: round a corner of a
/// hole the way is long for one that has hardly moved, seen from the point that
/// it belongs to.
fn longest_slide(a: &Footpoint, b: &Footpoint) -> f64 {
    let chord = a.point.distance(b.point);
    let way = if chord <= HARDLY_MOVED * a.distance {
        LONGEST_WAY
    } else {
        SLIDE_WAY
    };
    way * chord
}

/// Object angle of `x`, degrees: 180 between parallel walls.
pub fn object_angle(x: DVec3, a: &Footpoint, b: &Footpoint) -> f64 {
    angle(a.point - x, b.point - x).to_degrees()
}
