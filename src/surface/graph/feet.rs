//! Footpoints of the vertices.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use crate::field::Field;
use crate::surface::marked::{RawMesh, RawVertex};

/// Walls farther than the nearest by more than this share of the distance do
/// not tie. Solvers bring ties to about 1e-9; a wall that was only listed in
/// passing is farther by far.
const TIE: f64 = 1e-4;

/// Feet closer than this share of the distance are one place: walls that
/// share an edge have one foot on it.
const SAME_PLACE: f64 = 1e-6;

type Points = SmallVec<[DVec3; 2]>;

/// Footpoints of all vertices.
pub(super) struct Feet {
    points: Vec<Points>,
    /// Thickness and object angle in degrees.
    spread: Vec<(f64, f64)>,
}

impl Feet {
    /// The feet of each vertex's walls: one for each place, at most those
    /// that tie.
    pub(super) fn find(mesh: &RawMesh, kept: &[u32], field: &Field) -> Feet {
        let points: Vec<Points> = kept
            .par_iter()
            .map(|&v| feet(&mesh.vertices[v as usize], field))
            .collect();
        let spread = (kept.par_iter().zip(&points))
            .map(|(&v, feet)| (thickness(feet), angle(mesh.vertices[v as usize].at, feet)))
            .collect();
        Feet { points, spread }
    }

    /// Largest distance between two footpoints.
    pub(super) fn thickness(&self, v: u32) -> f64 {
        self.spread[v as usize].0
    }

    /// Largest angle between two footpoint vectors, degrees.
    pub(super) fn angle(&self, v: u32) -> f64 {
        self.spread[v as usize].1
    }

    /// Vertices with fewer than two footpoints.
    pub(super) fn lone(&self) -> usize {
        self.points.iter().filter(|p| p.len() < 2).count()
    }

    pub(super) fn into_points(self) -> Vec<Points> {
        self.points
    }
}

fn feet(vertex: &RawVertex, field: &Field) -> Points {
    let mut found: SmallVec<[(f64, DVec3); 4]> = (vertex.walls.iter())
        .map(|&wall| field.footpoint_on(vertex.at, wall))
        .filter(|foot| foot.distance.is_finite())
        .map(|foot| (foot.distance, foot.point))
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(nearest, _)) = found.first() else {
        return Points::new();
    };
    let mut points = Points::new();
    for (_, point) in found
        .into_iter()
        .take_while(|f| f.0 <= nearest * (1.0 + TIE))
    {
        if points
            .iter()
            .all(|p| (*p - point).length() > SAME_PLACE * nearest)
        {
            points.push(point);
        }
    }
    points
}

fn pairs(points: &[DVec3]) -> impl Iterator<Item = (DVec3, DVec3)> {
    (points.iter().enumerate()).flat_map(|(n, &p)| points[..n].iter().map(move |&q| (p, q)))
}

/// Largest distance between two of the footpoints.
///
/// Near a T the web keeps its true thickness: both feet stand on the two
/// reflex corners, while the ball grows. On a seam, where three walls tie, it
/// is the largest of the pairs. Fewer than two feet have none: 0.
pub(super) fn thickness(points: &[DVec3]) -> f64 {
    pairs(points)
        .map(|(p, q)| (p - q).length())
        .fold(0.0, f64::max)
}

fn angle(at: DVec3, points: &[DVec3]) -> f64 {
    pairs(points)
        .map(|(p, q)| (p - at).angle_between(q - at).to_degrees())
        .filter(|a| a.is_finite())
        .fold(0.0, f64::max)
}
