//! The part's surface as the detector sees it: areas, normals, bends, and the
//! two queries that everything else is made of.

use glam::DVec3;

use crate::field::Field;
use crate::mesh::{FaceId, TriMesh, angle, weld_exact};

/// A triangle less high than this times its longest side has no direction of
/// its own; what is left of single-precision coordinates is noise below it.
const SLIVER: f64 = 2e-7;

/// Rounds in which slivers take the direction of a neighbour: a fan of slivers
/// is rarely deeper.
const SLIVER_ROUNDS: usize = 3;

/// An edge between two triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub faces: [u32; 2],
    /// From one end to the other.
    pub along: DVec3,
    pub length: f64,
    /// Angle between the outward normals, degrees; positive where the surface
    /// is convex.
    pub bend: f64,
}

impl Edge {
    /// Angle between the normals, degrees.
    pub fn angle(&self) -> f64 {
        self.bend.abs()
    }

    /// Both ways across: from which triangle, to which.
    pub fn ways(&self) -> [(usize, usize); 2] {
        let [a, b] = self.faces.map(|face| face as usize);
        [(a, b), (b, a)]
    }
}

/// Triangles with what is asked of them again and again.
pub(super) struct Surface {
    pub corners: Vec<[DVec3; 3]>,
    pub areas: Vec<f64>,
    /// Unit outward normals; a sliver has that of the neighbour across its
    /// longest edge.
    pub normals: Vec<DVec3>,
    pub slivers: Vec<bool>,
    pub edges: Vec<Edge>,
    /// Edges of any other number of triangles than two.
    pub odd_edges: usize,
    /// Whether some edge is not run equally often both ways.
    pub open: bool,
    pub diagonal: f64,
    volume: f64,
    field: Field,
}

impl Surface {
    pub fn new(mesh: &TriMesh) -> Surface {
        let welded = weld_exact(&mesh.positions).apply(mesh);
        let field = Field::of_mesh(&welded);
        let faces = welded.faces();
        let corners: Vec<[DVec3; 3]> = faces.map(|face| welded.corners(face)).collect();
        let vectors: Vec<DVec3> = welded
            .faces()
            .map(|face| welded.area_vector(face))
            .collect();
        // A closed part turned inside out is read the right way round.
        let volume = welded.volume();
        let turn = if volume < 0.0 { -1.0 } else { 1.0 };
        let longest: Vec<f64> = corners.iter().map(longest_side).collect();
        let mut surface = Surface {
            areas: vectors.iter().map(|v| 0.5 * v.length()).collect(),
            normals: vectors
                .iter()
                .map(|v| turn * v.normalize_or_zero())
                .collect(),
            slivers: vectors
                .iter()
                .zip(&longest)
                .map(|(v, side)| v.length() <= SLIVER * side * side)
                .collect(),
            corners,
            edges: Vec::new(),
            odd_edges: 0,
            open: false,
            diagonal: welded.bounds().diagonal(),
            volume: volume.abs(),
            field,
        };
        surface.join(&welded);
        surface.give_slivers_a_normal(&longest);
        surface.measure_bends();
        surface
    }

    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Whether most edges join no two triangles: a heap of triangles has no inside
    /// to look into.
    pub fn is_loose(&self) -> bool {
        self.edges.len() < self.odd_edges
    }

    /// How many squares as wide as the walls are thick the surface has, taken for
    /// thin walls all over: their volume is half the area times the thickness.
    pub fn squares(&self) -> f64 {
        let area: f64 = self.areas.iter().sum();
        let thickness = 2.0 * self.volume / area;
        area / (thickness * thickness)
    }

    fn join(&mut self, mesh: &TriMesh) {
        let uses = mesh.edges();
        self.open = !uses.census().is_closed();
        for uses in uses.by_edge() {
            let [first, second] = uses else {
                self.odd_edges += 1;
                continue;
            };
            let [from, to] = first.edge.map(|v| mesh.positions[v as usize]);
            self.edges.push(Edge {
                faces: [first.face.0, second.face.0],
                along: to - from,
                length: from.distance(to),
                bend: 0.0,
            });
        }
    }

    fn give_slivers_a_normal(&mut self, longest: &[f64]) {
        let mut open: Vec<bool> = self.slivers.clone();
        for _ in 0..SLIVER_ROUNDS {
            let known = open.clone();
            for edge in &self.edges {
                for (face, other) in edge.ways() {
                    if open[face] && !known[other] && edge.length >= longest[face] * (1.0 - 1e-9) {
                        self.normals[face] = self.normals[other];
                        open[face] = false;
                    }
                }
            }
        }
    }

    /// Convex where the middle of either triangle lies below the other's plane.
    fn measure_bends(&mut self) {
        let middle = |face: usize| self.corners[face].iter().sum::<DVec3>() / 3.0;
        for edge in &mut self.edges {
            let [a, b] = edge.faces.map(|face| face as usize);
            let (na, nb) = (self.normals[a], self.normals[b]);
            let bend = angle(na, nb).to_degrees();
            let way = middle(b) - middle(a);
            let rise = way.dot(na) - way.dot(nb);
            edge.bend = if rise <= 0.0 { bend } else { -bend };
        }
    }

    /// The centre of the triangle whose centre is nearest to a point.
    pub fn middle_of(&self, triangles: &[u32], target: DVec3) -> DVec3 {
        let centre = |&t: &u32| self.corners[t as usize].iter().sum::<DVec3>() / 3.0;
        let off = |p: &DVec3| p.distance_squared(target);
        let centres = triangles.iter().map(centre);
        let nearest = centres.min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or(target)
    }

    /// Way along a direction of unit length to the first triangle, and which;
    /// none within `reach`.
    pub fn ray(&self, from: DVec3, direction: DVec3, reach: f64) -> Option<(f64, u32)> {
        let reach = reach.min(2.0 * self.diagonal);
        let hit = self.field.first_hit(from, from + reach * direction)?;
        Some((hit.t * reach, hit.face.0))
    }

    /// Length of the chord through a point along a direction; infinite if it
    /// is more than `reach`.
    pub fn chord(&self, through: DVec3, direction: DVec3, reach: f64) -> f64 {
        let Some((one, _)) = self.ray(through, direction, reach) else {
            return f64::INFINITY;
        };
        let other = self.ray(through, -direction, reach - one);
        other.map_or(f64::INFINITY, |(other, _)| one + other)
    }

    /// Distance to the nearest triangle, its nearest point, and which it is;
    /// `near` is a triangle near by.
    pub fn nearest(&self, p: DVec3, near: u32) -> (f64, DVec3, u32) {
        let foot = self.field.footpoint_near(p, FaceId(near));
        (foot.distance, foot.point, foot.face.0)
    }
}

fn longest_side([a, b, c]: &[DVec3; 3]) -> f64 {
    a.distance(*b).max(b.distance(*c)).max(c.distance(*a))
}
