//! Where the surface is looked at: points spread evenly over each smooth face.

use glam::DVec3;

use super::surface::Surface;
use crate::mesh::sets::Sets;

/// Edges that bend by less do not bound a face, where both sides are of one
/// kind, degrees: sixteen facets a turn.
pub(super) const SMOOTH: f64 = 22.0;

/// Points that a smooth face gets at least, however small: enough to average
/// over its ends and corners.
const LEAST_A_FACE: f64 = 12.0;

/// Points that a triangle gets at most: more of one plane tell nothing new.
const MOST_A_TRIANGLE: usize = 12;

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub face: u32,
    pub point: DVec3,
    /// Outward.
    pub normal: DVec3,
    /// Area that it stands for.
    pub weight: f64,
}

/// Spreads about `total` points, in proportion to area and in the order of
/// triangles. Inside a triangle they follow the plane's golden-ratio sequence
/// (Roberts, 2018): even, and nothing random.
pub(super) fn spread(surface: &Surface, total: usize) -> Vec<Sample> {
    let (of, count) = smooth_faces(surface);
    let mut areas = vec![0.0; count];
    for (face, &area) in surface.areas.iter().enumerate() {
        areas[of[face]] += area;
    }
    let whole: f64 = areas.iter().sum();
    let total = total as f64;
    let least = LEAST_A_FACE.min((4.0 * total / count.max(1) as f64).max(1.0));
    let wanted: Vec<f64> = areas
        .iter()
        .map(|area| (total * area / whole).max(least))
        .collect();

    // Fractions of a point are carried from triangle to triangle of a face, so
    // that many small ones get their share too.
    let mut carried = vec![0.5 - 1e-9; count];
    let mut samples = Vec::new();
    let mut weights = vec![0.0; count];
    for (face, &group) in of.iter().enumerate() {
        if surface.slivers[face] || surface.areas[face] <= 0.0 {
            continue;
        }
        carried[group] += surface.areas[face] * wanted[group] / areas[group];
        let whole = carried[group].floor();
        carried[group] -= whole;
        let points = (whole as usize).min(MOST_A_TRIANGLE);
        // A crowded triangle's points stand for the triangle, not for their
        // even share of the face.
        let even = areas[group] / wanted[group];
        let weight = if points == MOST_A_TRIANGLE {
            even.max(surface.areas[face] / points as f64)
        } else {
            even
        };
        for point in in_triangle(surface.corners[face], points) {
            weights[group] += weight;
            samples.push(Sample {
                face: face as u32,
                point,
                normal: surface.normals[face],
                weight,
            });
        }
    }
    for sample in &mut samples {
        let group = of[sample.face as usize];
        sample.weight *= areas[group] / weights[group];
    }
    samples
}

/// Triangles that hang together without a crease: the face of each, and how
/// many there are.
fn smooth_faces(surface: &Surface) -> (Vec<usize>, usize) {
    let mut sets = Sets::new(surface.len());
    for edge in surface.edges.iter().filter(|e| e.angle() < SMOOTH) {
        sets.join(edge.faces[0], edge.faces[1]);
    }
    let (labels, count) = sets.labels();
    (labels.into_iter().map(|l| l as usize).collect(), count)
}

fn in_triangle([a, b, c]: [DVec3; 3], count: usize) -> impl Iterator<Item = DVec3> {
    /// The root of `x^3 = x + 1`.
    const GOLDEN: f64 = 1.324_717_957_244_746;
    let step = [1.0 / GOLDEN, 1.0 / (GOLDEN * GOLDEN)];
    (0..count).map(move |i| {
        let mut at = step.map(|s| (0.5 + (i + 1) as f64 * s).fract());
        if count == 1 {
            at = [1.0 / 3.0; 2];
        } else if at[0] + at[1] > 1.0 {
            at = at.map(|x| 1.0 - x);
        }
        // Off the edges, where a probe would slip out.
        let [u, v] = at.map(|x| if count == 1 { x } else { 0.02 + 0.94 * x });
        a + u * (b - a) + v * (c - a)
    })
}
