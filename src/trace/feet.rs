//! Footpoints of the vertices found.

use rayon::prelude::*;
use smallvec::SmallVec;

use crate::field::Field;
use crate::surface::Ball;
use crate::surface::marked::{MarkedMesh, MarkedVertex};

/// Walls farther than the nearest by more than this share of the distance do
/// not tie. Solvers bring ties to about 1e-9; a wall that was only listed in
/// passing is farther by far.
const TIE: f64 = 1e-4;

/// Feet closer than this share of the distance are one place: walls that
/// share an edge have one foot on it.
const SAME_PLACE: f64 = 1e-6;

/// The ball of each vertex: one footpoint for each place where a wall of the
/// vertex ties.
pub fn balls(mesh: &MarkedMesh, field: &Field) -> Vec<Ball> {
    mesh.vertices.par_iter().map(|v| ball(v, field)).collect()
}

fn ball(vertex: &MarkedVertex, field: &Field) -> Ball {
    let mut found: SmallVec<[_; 4]> = (vertex.walls.iter())
        .map(|&wall| field.footpoint_on(vertex.at, wall))
        .filter(|foot| foot.distance.is_finite())
        .map(|foot| (foot.distance, foot.point))
        .collect();
    found.sort_by(|a: &(f64, _), b| a.0.total_cmp(&b.0));
    let Some(&(nearest, _)) = found.first() else {
        return Ball::default();
    };
    let mut points = SmallVec::new();
    for (_, point) in found
        .into_iter()
        .take_while(|f| f.0 <= nearest * (1.0 + TIE))
    {
        let apart = |p: &glam::DVec3| (*p - point).length() > SAME_PLACE * nearest;
        if points.iter().all(apart) {
            points.push(point);
        }
    }
    Ball::touching(vertex.at, points)
}
