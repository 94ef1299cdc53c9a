//! A mid-surface as it was written, for remeshing without its part.
//!
//! Points go to the nearest place of their own patch, the piece of a sheet
//! between lines, so that nothing slips over a seam. Lines stay the polylines
//! that they are. Thickness and radius are linear over the triangles.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use super::ground::Ground;
use crate::field::Field;
use crate::mesh::sets::Sets;
use crate::mesh::{FaceId, TriMesh};
use crate::surface::edges::Edges;
use crate::surface::marked::{Line, MarkedVertex};
use crate::surface::{Ball, MidSurface, segments};
use crate::walls::Walls;

/// Thickness against the diameter of the ball from which on walls count as
/// opposite each other: an object angle of 157 degrees. Below, the sheet dips
/// towards a seam or bend, which is no bend of its walls.
const OPPOSITE: f64 = 0.98;

/// A point of a line lies on a patch at this share of its reach.
const ON_PATCH: f64 = 1e-3;

/// The triangles of a mid-surface, patch by patch.
pub(super) struct Facets<'s> {
    surface: &'s MidSurface,
    /// Patch of each triangle.
    patch_of: Vec<u32>,
    patches: Vec<Patch>,
    /// Normals of a patch at the corners of each triangle.
    normals: Vec<[DVec3; 3]>,
}

/// A piece of a sheet between lines.
struct Patch {
    field: Field,
    /// Triangles of the surface, by those of the field.
    triangles: Vec<u32>,
}

impl<'s> Facets<'s> {
    pub(super) fn new(surface: &'s MidSurface) -> Facets<'s> {
        let (patch_of, count) = patches(surface);
        let mut triangles = vec![Vec::new(); count];
        for (t, &patch) in (0..).zip(&patch_of) {
            triangles[patch as usize].push(t);
        }
        let positions: Vec<DVec3> = surface.vertices().iter().map(|v| v.position).collect();
        let patches = (triangles.into_iter())
            .map(|triangles: Vec<u32>| {
                let corners = |&t: &u32| surface.triangles()[t as usize].corners;
                // Only the vertices of the patch, so that many patches cost no more.
                let mut number: FxHashMap<u32, u32> = FxHashMap::default();
                let mut mesh = TriMesh::default();
                for corners in triangles.iter().map(corners) {
                    let corners = corners.map(|v| {
                        *number.entry(v).or_insert_with(|| {
                            mesh.positions.push(positions[v as usize]);
                            mesh.positions.len() as u32 - 1
                        })
                    });
                    mesh.triangles.push(corners);
                }
                let field = Field::of_mesh(&mesh);
                Patch { field, triangles }
            })
            .collect();
        let normals = normals(surface, &patch_of);
        Facets {
            surface,
            patch_of,
            patches,
            normals,
        }
    }

    /// The vertices of the surface, each with a triangle of every patch at it.
    pub(super) fn vertices(&self) -> Vec<MarkedVertex> {
        let mut vertices: Vec<MarkedVertex> = (self.surface.vertices().iter())
            .map(|v| MarkedVertex {
                at: v.position,
                walls: SmallVec::new(),
                coping: None,
            })
            .collect();
        for (t, triangle) in (0..).zip(self.surface.triangles()) {
            for v in triangle.corners {
                let walls = &mut vertices[v as usize].walls;
                if walls
                    .iter()
                    .all(|w| self.patch(*w) != self.patch(FaceId(t)))
                {
                    walls.push(FaceId(t));
                }
            }
        }
        vertices
    }

    /// The ball at a vertex, between those of its triangle's corners.
    pub(super) fn ball(&self, vertex: &MarkedVertex) -> Ball {
        let nearest = (vertex.walls.iter())
            .map(|&face| (face, self.shares(face, vertex.at)))
            .min_by(|(_, p), (_, q)| p.1.total_cmp(&q.1));
        let Some((face, (shares, _))) = nearest else {
            return Ball::default();
        };
        let corners = self.surface.triangles()[face.index()].corners;
        let mut ball = Ball::default();
        for (v, share) in corners.into_iter().zip(shares) {
            let own = &self.surface.vertices()[v as usize].ball;
            ball.radius += share * own.radius;
            ball.thickness += share * own.thickness;
        }
        ball
    }

    fn patch(&self, face: FaceId) -> u32 {
        self.patch_of[face.index()]
    }

    /// Shares of a triangle's corners in its point closest to `p`, and how far
    /// that is.
    fn shares(&self, face: FaceId, p: DVec3) -> ([f64; 3], f64) {
        let [a, b, c] =
            (self.surface.triangles()[face.index()].corners).map(|v| self.surface.position(v));
        let normal = (b - a).cross(c - a);
        let part = |u: DVec3, v: DVec3| (u - p).cross(v - p).dot(normal).max(0.0);
        let parts = [part(b, c), part(c, a), part(a, b)];
        let sum: f64 = parts.iter().sum();
        let shares = match sum > 0.0 {
            true => parts.map(|part| part / sum),
            false => [1.0 / 3.0; 3],
        };
        let at = shares[0] * a + shares[1] * b + shares[2] * c;
        (shares, at.distance(p))
    }

    fn normal_on(&self, face: FaceId, p: DVec3) -> DVec3 {
        let (shares, _) = self.shares(face, p);
        let corners = self.normals[face.index()];
        let sum: DVec3 = corners.iter().zip(shares).map(|(&n, s)| s * n).sum();
        sum.normalize_or_zero()
    }

    /// The triangle of a patch that is nearest to a point, its closest point and
    /// how far that is.
    fn nearest(&self, patch: u32, p: DVec3) -> (FaceId, DVec3, f64) {
        let patch = &self.patches[patch as usize];
        let foot = patch.field.footpoint(p);
        (
            FaceId(patch.triangles[foot.face.index()]),
            foot.point,
            foot.distance,
        )
    }

    /// Whether a sheet runs in the middle of its walls at a vertex.
    fn is_plain(&self, vertex: &MarkedVertex) -> bool {
        let ball = self.ball(vertex);
        ball.thickness >= OPPOSITE * 2.0 * ball.radius
    }
}

impl Ground for Facets<'_> {
    fn on_sheet(&self, guess: DVec3, hints: &[FaceId], reach: f64) -> Option<MarkedVertex> {
        // The patch that all vertices near by have in common; of a line's
        // vertices each has several.
        let mut counts: SmallVec<[(u32, u32); 6]> = SmallVec::new();
        for &face in hints {
            let patch = self.patch(face);
            match counts.iter_mut().find(|c| c.0 == patch) {
                Some(count) => count.1 += 1,
                None => counts.push((patch, 1)),
            }
        }
        let most = counts.iter().map(|c| c.1).max()?;
        let (face, at, distance) = (counts.iter())
            .filter(|c| c.1 == most)
            .map(|c| self.nearest(c.0, guess))
            .min_by(|p, q| p.2.total_cmp(&q.2))?;
        (distance <= reach).then(|| MarkedVertex {
            at,
            walls: SmallVec::from_slice(&[face]),
            coping: None,
        })
    }

    fn on_line(
        &self,
        _line: Line,
        guess: DVec3,
        _along: DVec3,
        hints: &MarkedVertex,
        reach: f64,
    ) -> Option<MarkedVertex> {
        let mut patches: SmallVec<[u32; 4]> = hints.walls.iter().map(|&w| self.patch(w)).collect();
        patches.sort_unstable();
        patches.dedup();
        let walls: SmallVec<[FaceId; 4]> = (patches.into_iter())
            .map(|patch| self.nearest(patch, guess))
            .filter(|(.., distance)| *distance <= ON_PATCH * reach)
            .map(|(face, ..)| face)
            .collect();
        (!walls.is_empty()).then_some(MarkedVertex {
            at: guess,
            walls,
            coping: None,
        })
    }

    fn normal(&self, vertex: &MarkedVertex) -> DVec3 {
        match vertex.walls.first() {
            Some(&face) => self.normal_on(face, vertex.at),
            None => DVec3::ZERO,
        }
    }

    fn turns(&self, from: &MarkedVertex, to: &MarkedVertex) -> [f64; 2] {
        let Some(&here) = from.walls.first() else {
            return [0.0; 2];
        };
        let there = to
            .walls
            .iter()
            .find(|&&w| self.patch(w) == self.patch(here));
        match there {
            Some(&there) if self.is_plain(from) && self.is_plain(to) => {
                let normals = [(here, from.at), (there, to.at)].map(|(f, p)| self.normal_on(f, p));
                let turn = normals[0].angle_between(normals[1]);
                [if turn.is_finite() { turn } else { 0.0 }; 2]
            }
            _ => [0.0; 2],
        }
    }

    fn walls(&self) -> Option<&Walls<'_>> {
        None
    }
}

/// Patch of each triangle, and how many there are.
fn patches(surface: &MidSurface) -> (Vec<u32>, usize) {
    let corners: Vec<[u32; 3]> = surface.triangles().iter().map(|t| t.corners).collect();
    let edges = Edges::new(&corners);
    let creases: FxHashSet<[u32; 2]> = (surface.creases().iter())
        .flat_map(|c| segments(&c.path, c.closed))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    let mut joined = Sets::new(corners.len());
    for e in 0..edges.len() {
        if let Some([a, b]) = edges.pair(e)
            && !creases.contains(&edges.ends[e])
        {
            joined.join(a, b);
        }
    }
    joined.labels()
}

/// Normals at the corners of each triangle: the mean of those of the triangles
/// of the patch there, weighted by area, so that slivers do not count.
fn normals(surface: &MidSurface, patch_of: &[u32]) -> Vec<[DVec3; 3]> {
    let mut sums: FxHashMap<(u32, u32), DVec3> = FxHashMap::default();
    for (triangle, &patch) in surface.triangles().iter().zip(patch_of) {
        let [a, b, c] = triangle.corners.map(|v| surface.position(v));
        for v in triangle.corners {
            *sums.entry((patch, v)).or_default() += (b - a).cross(c - a);
        }
    }
    let normal = |patch: u32, v: u32| {
        let sum = sums.get(&(patch, v)).copied();
        sum.unwrap_or_default().normalize_or_zero()
    };
    (surface.triangles().iter().zip(patch_of))
        .map(|(triangle, &patch)| triangle.corners.map(|v| normal(patch, v)))
        .collect()
}
