//! Which footpoints belong to one wall, and the per-thread way to ask.
//!
//! A mid-surface point has two footpoints on *separate* walls. Two footpoints
//! that a short path over wall triangles joins lie on one wall: the ball sits
//! in a convex edge or round of it, and the sheet between them is a fin
//! (Bloomenthal 2011, section 6, asks for manual pruning of these). The path
//! is the medial geodesic function of Dey and Sun (2006), asked locally:
//! coping cuts it, so a web is never mistaken for a fin, however weak its
//! object angle.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Field, Footpoint};
use crate::mesh::{FaceId, Part};

/// Largest object angle of a fin: that of a convex edge of 45 degrees. A wall
/// that narrows to a sharper edge is a tapered wall, and its sheet is wanted.
pub const MAX_FIN_ANGLE: f64 = 135.0;

/// Path against chord below which two footpoints lie round one corner whatever
/// the object angle: the corner of the rim where a rib ends, seen from inside
/// the plate, has ratio 1.41. The way round the whole end of that rib, between
/// the footpoints of its own sheet, has ratio 2.
const SHORT_WAY: f64 = 1.65;

/// Slack for a path found by crossing edges one at a time.
const PATH_SLACK: f64 = 1.1;

/// Path against chord of a footpoint that slides along one smooth wall.
const SLIDE_WAY: f64 = 1.1;

/// Triangles looked at before a path counts as long.
const PATH_BUDGET: usize = 4096;

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
        let mut patches = Patches { of: vec![None; count], outlines: Vec::new() };
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
                for k in 0..3 {
                    let next = neighbours[face.index()][k].filter(|&n| {
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
            let walls = (0..triangles.len() as u32).map(FaceId).filter(|&f| !field.is_coping(f));
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
        Walls {
            field,
            first,
            around,
            patches: Patches::new(field, &neighbours),
            neighbours,
            indices: triangles.clone(),
            separation,
            tolerances: Tolerances { solve: 1e-13 * size, tie: 2e-7 * size },
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

    /// The triangle across edge `k` (from corner `k` to `k + 1`).
    pub fn neighbour(&self, face: FaceId, k: usize) -> Option<FaceId> {
        self.neighbours[face.index()][k]
    }

    /// The outline of the flat patch that a coping triangle belongs to: its
    /// edges, each as a triangle of the patch and the edge's number there.
    pub fn outline(&self, coping: FaceId) -> &[(FaceId, usize)] {
        match self.patches.of[coping.index()] {
            Some(patch) => &self.patches.outlines[patch as usize],
            None => &[],
        }
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
                let (from, to) = (self.first[v as usize], self.first[v as usize + 1]);
                for &next in &self.around[from as usize..to as usize] {
                    let foot = self.field.footpoint_on(x, next);
                    let nearer = foot.distance < best.distance * (1.0 - 1e-14);
                    if nearer
                        && ((x - foot.point).normalize_or_zero().dot(away) >= cosine
                            || self.smooth_neighbours(here.face, next, crease))
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

    /// Whether two triangles share a corner.
    pub fn touch(&self, a: FaceId, b: FaceId) -> bool {
        let (s, t) = (self.indices[a.index()], self.indices[b.index()]);
        s.iter().any(|v| t.contains(v))
    }

    /// Whether two triangles share an edge that is reflex or bends by at most
    /// `angle` degrees: a footpoint passes it without a jump worth a vertex.
    pub fn smooth_neighbours(&self, a: FaceId, b: FaceId, angle: f64) -> bool {
        let Some(k) = self.neighbours[a.index()].iter().position(|&n| n == Some(b)) else { return false };
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
        if self.separation.keep_fins_from.is_some_and(|least| angle >= least) {
            return true;
        }
        if self.joined(a, b, SHORT_WAY * chord) {
            return false;
        }
        // A convex edge or round lies within the two tangent planes: the ball,
        // shrinking into it, meets wall before their apex, and the way over the
        // wall is no longer than that over the apex.
        let apex = (0.5 * angle).to_radians().cos().recip();
        if PATH_SLACK * apex <= SHORT_WAY {
            return true;
        }
        let inward = ((a.point - x).normalize_or_zero() + (b.point - x).normalize_or_zero()).normalize_or_zero();
        let reach = a.distance.max(b.distance) * apex * 1.001;
        !(self.wall_ahead(x, x + reach * inward) && self.joined(a, b, PATH_SLACK * apex * chord))
    }

    /// Whether the first triangle on the way is wall.
    fn wall_ahead(&self, from: DVec3, to: DVec3) -> bool {
        let mut hits = Vec::new();
        self.field.hits(from, to, &mut hits);
        hits.first().is_some_and(|first| {
            // At an edge between wall and coping both are hit.
            hits.iter().take_while(|h| h.t <= first.t + 1e-9).all(|h| !self.field.is_coping(h.face))
        })
    }

    /// Whether a footpoint may slide from `a` to `b` along one smooth wall.
    pub fn slides(&self, a: &Footpoint, b: &Footpoint) -> bool {
        if a.face == b.face {
            return true;
        }
        let chord = a.point.distance(b.point);
        chord <= 4.0 * self.tolerances.tie || self.joined(a, b, SLIDE_WAY * chord)
    }

    /// Whether a path over wall triangles of at most `length` leads from `a`
    /// to `b`. Best first (A*), each edge crossed where the way over it would
    /// be straight, so that the length is that of a path, if not of the
    /// shortest one.
    fn joined(&self, a: &Footpoint, b: &Footpoint, length: f64) -> bool {
        let mut seen: FxHashSet<FaceId> = FxHashSet::default();
        let mut open: BinaryHeap<(Reverse<Way>, FaceId)> = BinaryHeap::new();
        open.push((Reverse(Way { total: 0.0, walked: 0.0, at: a.point }), a.face));
        while let Some((Reverse(way), face)) = open.pop() {
            if face == b.face {
                return true;
            }
            if !seen.insert(face) {
                continue;
            }
            if seen.len() > PATH_BUDGET {
                return false;
            }
            let corners = self.field.corners(face);
            for k in 0..3 {
                let Some(next) = self.neighbours[face.index()][k] else { continue };
                if self.field.is_coping(next) || seen.contains(&next) {
                    continue;
                }
                let at = straight_crossing(way.at, b.point, corners[k], corners[(k + 1) % 3]);
                let walked = way.walked + way.at.distance(at);
                let total = walked + at.distance(b.point);
                if total <= length {
                    open.push((Reverse(Way { total, walked, at }), next));
                }
            }
        }
        false
    }
}

/// Object angle of `x`, degrees: 180 between parallel walls.
pub fn object_angle(x: DVec3, a: &Footpoint, b: &Footpoint) -> f64 {
    let (u, v) = (a.point - x, b.point - x);
    u.cross(v).length().atan2(u.dot(v)).to_degrees()
}

/// Where the segment `p q` is crossed by the shortest way from `a` to `b` over it.
fn straight_crossing(a: DVec3, b: DVec3, p: DVec3, q: DVec3) -> DVec3 {
    let along = (q - p).normalize_or_zero();
    let length = (q - p).length();
    let (sa, sb) = ((a - p).dot(along), (b - p).dot(along));
    let ra = (a - p - sa * along).length();
    let rb = (b - p - sb * along).length();
    // Unfolded into one plane the way is straight and crosses the edge here.
    let s = if ra + rb > 0.0 { (sa * rb + sb * ra) / (ra + rb) } else { 0.5 * (sa + sb) };
    p + s.clamp(0.0, length) * along
}

/// A way walked so far, ordered by what it comes to at least.
#[derive(Clone, Copy, Debug)]
struct Way {
    total: f64,
    walked: f64,
    at: DVec3,
}

impl PartialEq for Way {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Way {}

impl PartialOrd for Way {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Way {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.total.total_cmp(&other.total)
    }
}
