//! Normals that make no solver stop.
//!
//! The normal of the mid-surface at a vertex with two footpoints is their
//! direction, exactly, whatever the shape of the triangles there. But it turns
//! fast towards a seam or bend, where the sheet is an arc as short as the wall
//! is thick; a solver that blows triangles up to wedges along the normals would
//! turn small ones there inside out. So normals are averaged over a share of
//! the thickness: then they turn by less than a triangle is wide. Averages stay
//! within what hangs together around the vertex without crossing a seam or a
//! crease, where the walls themselves turn.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

use crate::mesh::sets::Sets;
use crate::surface::edges::Edges;
use crate::surface::{MidSurface, segments};

/// Cosine of the angle between feet and triangles of a fan from which on they
/// are taken to be of one wall.
const OWN_WALL: f64 = 0.5;

/// Bend, degrees, from which on an edge is a crease that was not marked.
const SHARP: f64 = 45.0;

/// Height of a triangle, in ball radii, from which on its bend means something:
/// lower ones tip over by errors of position.
const HIGH: f64 = 0.25;

/// A normal for every corner of every triangle.
pub(super) struct CornerNormals {
    /// Unit normals.
    pub(super) normals: Vec<DVec3>,
    /// Place in `normals` by triangle and corner: one for each fan of
    /// triangles around a vertex, joined over edges inside a smooth sheet.
    pub(super) of: Vec<[u32; 3]>,
}

/// A vertex as one side of it sees it.
struct Fan {
    vertex: u32,
    triangles: Vec<u32>,
}

impl CornerNormals {
    /// Averages over `reach` ball radii.
    pub(super) fn of(surface: &MidSurface, edges: &Edges, reach: f64) -> CornerNormals {
        let smooth = Smooth::new(surface, edges);
        let (of, fans) = smooth.fans();
        let sources: Vec<Source> = fans.par_iter().map(|f| smooth.source(f)).collect();
        let normals = (fans.par_iter().zip(&sources))
            .map(|(fan, own)| smooth.normal(fan, own, &of, &sources, reach))
            .collect();
        CornerNormals { normals, of }
    }
}

/// What a fan knows of its own normal.
struct Source {
    /// Sum of the area vectors of its triangles.
    area: DVec3,
    /// Direction between its two footpoints, on the side of `area`; none where
    /// a third wall ties, or the feet are not known or another wall's.
    feet: Option<DVec3>,
}

/// A surface and which of its edges lie inside a smooth sheet.
struct Smooth<'s> {
    surface: &'s MidSurface,
    edges: &'s Edges,
    creases: FxHashSet<[u32; 2]>,
}

impl<'s> Smooth<'s> {
    fn new(surface: &'s MidSurface, edges: &'s Edges) -> Smooth<'s> {
        let marked = (surface.creases().iter())
            .flat_map(|c| segments(&c.path, c.closed))
            .map(|[a, b]| [a.min(b), a.max(b)]);
        let sharp = (0..edges.len()).filter(|&e| is_sharp(surface, edges, e));
        let creases = marked.chain(sharp.map(|e| edges.ends[e])).collect();
        Smooth {
            surface,
            edges,
            creases,
        }
    }

    /// The triangle across a side, if the sheet goes on smoothly there.
    fn across(&self, triangle: u32, side: usize) -> Option<u32> {
        let edge = self.edges.of_face[triangle as usize][side] as usize;
        let [a, b] = self.edges.pair(edge)?;
        let other = if a == triangle { b } else { a };
        (!self.creases.contains(&self.edges.ends[edge])).then_some(other)
    }

    /// Number of the fan at every corner, and the fans in order of their first
    /// corner.
    fn fans(&self) -> (Vec<[u32; 3]>, Vec<Fan>) {
        let triangles = self.surface.triangles();
        let mut joined = Sets::new(3 * triangles.len());
        for t in 0..triangles.len() as u32 {
            for side in 0..3 {
                let Some(other) = self.across(t, side).filter(|&o| o > t) else {
                    continue;
                };
                let theirs = triangles[other as usize].corners;
                for k in [side, (side + 1) % 3] {
                    let vertex = triangles[t as usize].corners[k];
                    if let Some(at) = theirs.iter().position(|&v| v == vertex) {
                        joined.join(3 * t + k as u32, 3 * other + at as u32);
                    }
                }
            }
        }
        let mut fans: Vec<Fan> = Vec::new();
        let mut of = vec![[0; 3]; triangles.len()];
        for corner in 0..3 * triangles.len() as u32 {
            let (t, k) = (corner as usize / 3, corner as usize % 3);
            let first = joined.find(corner);
            if first == corner {
                of[t][k] = fans.len() as u32;
                fans.push(Fan {
                    vertex: triangles[t].corners[k],
                    triangles: vec![t as u32],
                });
            } else {
                of[t][k] = of[first as usize / 3][first as usize % 3];
                fans[of[t][k] as usize].triangles.push(t as u32);
            }
        }
        (of, fans)
    }

    /// Twice the area times the normal.
    fn area(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.surface.triangles()[triangle as usize]
            .corners
            .map(|v| self.surface.position(v));
        (b - a).cross(c - a)
    }

    fn source(&self, fan: &Fan) -> Source {
        let area: DVec3 = fan.triangles.iter().map(|&t| self.area(t)).sum();
        let ball = &self.surface.vertices()[fan.vertex as usize].ball;
        let feet = match ball.footpoints[..] {
            [a, b] => (b - a).try_normalize(),
            _ => None,
        };
        // Where walls meet, the feet may be those of another sheet's wall.
        let own = |f: &DVec3| f.dot(area).abs() >= OWN_WALL * area.length();
        Source {
            area,
            feet: (feet.filter(own)).map(|f| if f.dot(area) < 0.0 { -f } else { f }),
        }
    }

    /// Average of the normals near a fan; its own where there is none.
    fn normal(
        &self,
        fan: &Fan,
        own: &Source,
        of: &[[u32; 3]],
        sources: &[Source],
        reach: f64,
    ) -> DVec3 {
        let centre = self.surface.position(fan.vertex);
        let radius = reach * self.surface.vertices()[fan.vertex as usize].ball.radius;
        let (mut feet, mut area) = (DVec3::ZERO, DVec3::ZERO);
        for t in self.near(fan, centre, radius) {
            let vector = self.area(t);
            for (k, &v) in self.surface.triangles()[t as usize]
                .corners
                .iter()
                .enumerate()
            {
                let weight = falloff(centre.distance(self.surface.position(v)), radius);
                area += weight * vector;
                if let Some(normal) = sources[of[t as usize][k] as usize].feet {
                    feet += weight * vector.length() * normal;
                }
            }
        }
        let own_feet = own.feet.filter(|_| radius == 0.0).unwrap_or(DVec3::ZERO);
        [own_feet, feet, area, own.area]
            .into_iter()
            .find_map(|n| n.try_normalize())
            .unwrap_or(DVec3::Z)
    }

    /// The triangles of a fan, and those that hang together with them over
    /// smooth edges and have a corner within `radius`.
    fn near(&self, fan: &Fan, centre: DVec3, radius: f64) -> Vec<u32> {
        let mut found = fan.triangles.clone();
        let mut seen: FxHashSet<u32> = found.iter().copied().collect();
        let close = |&t: &u32| {
            let corners = self.surface.triangles()[t as usize].corners;
            let near = |&v: &u32| centre.distance(self.surface.position(v)) < radius;
            corners.iter().any(near)
        };
        let mut next = 0;
        while let Some(&t) = found.get(next) {
            next += 1;
            for side in 0..3 {
                let other = self.across(t, side).filter(close);
                if let Some(other) = other.filter(|&o| seen.insert(o)) {
                    found.push(other);
                }
            }
        }
        found
    }
}

/// Whether two triangles of a sheet, neither of them a sliver, bend so much that
/// the sheet has a crease there, marked or not.
fn is_sharp(surface: &MidSurface, edges: &Edges, e: usize) -> bool {
    let Some(pair) = edges.pair(e) else {
        return false;
    };
    let [p, q] = edges.ends[e].map(|v| &surface.vertices()[v as usize]);
    let Some(along) = (q.position - p.position).try_normalize() else {
        return false;
    };
    let away = pair.map(|t| {
        let corners = surface.triangles()[t as usize].corners;
        let far = corners.into_iter().find(|v| !edges.ends[e].contains(v));
        let way = surface.position(far.unwrap_or(corners[0])) - p.position;
        way.reject_from_normalized(along)
    });
    let least = HIGH * p.ball.radius.min(q.ball.radius);
    away.iter().all(|way| way.length() > least)
        && away[0].angle_between(-away[1]) > SHARP.to_radians()
}

/// Weight at a distance: 1 at the centre, falling smoothly to 0 at the radius.
fn falloff(distance: f64, radius: f64) -> f64 {
    let left = (1.0 - (distance / radius).powi(2)).max(0.0);
    if left.is_finite() { left * left } else { 0.0 }
}
