//! Shortest distance to a limit surface: (4.2) measured.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::{Grid, Laid, on_side};
use super::limit::LimitSurface;
use super::patch::Jet;
use crate::field::Field;
use crate::mesh::FaceId;

/// Most steps of one search.
const STEPS: usize = 40;

/// Most borders that one search crosses.
const CROSSINGS: usize = 8;

/// A place on the surface.
#[derive(Clone, Copy, Debug)]
struct Place {
    face: usize,
    u: f64,
    v: f64,
}

/// Distance of every inner sample to the limit surface.
///
/// The nearest triangle of the outer samples gives the start, Newton's method
/// on the surface itself the rest. A nearer place whose triangle is farther
/// would be missed; triangles and surface differ by the sagitta only. Never
/// more than the distance to the sample's own outer point.
pub(super) fn thickness(surface: &LimitSurface, grid: &Grid, laid: &Laid) -> Vec<f64> {
    let Laid {
        samples, triangles, ..
    } = laid;
    let corners = triangles
        .iter()
        .map(|t| t.map(|v| samples.outer[v as usize]))
        .collect();
    let field = Field::from_triangles(corners, triangles.clone(), Vec::new());
    // A triangle at the sample's own outer point is a near one to begin with.
    let mut own = vec![FaceId(0); samples.outer.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &corner in corners {
            own[corner as usize] = FaceId(triangle as u32);
        }
    }
    samples
        .inner
        .par_iter()
        .zip(&samples.outer)
        .zip(&own)
        .map(|((&p, &above), &own)| {
            let near = field.footpoint_near(p, own);
            let triangle = near.face.index();
            let corners = triangles[triangle].map(|v| samples.outer[v as usize]);
            let start = place_of(grid, triangle, corners, near.point);
            closest(surface, p, start).min(p.distance(above))
        })
        .collect()
}

/// Parameters of a point in a triangle of the grid.
fn place_of(grid: &Grid, triangle: usize, corners: [DVec3; 3], p: DVec3) -> Place {
    let (n, upper) = (grid.steps(), triangle % 2 == 1);
    let (face, cell) = grid.cell_of(triangle);
    let (i, j) = ((cell / n) as f64, (cell % n) as f64);
    let ends = if upper {
        [(i, j), (i + 1.0, j + 1.0), (i, j + 1.0)]
    } else {
        [(i, j), (i + 1.0, j), (i + 1.0, j + 1.0)]
    };
    let (a, b) = (corners[1] - corners[0], corners[2] - corners[0]);
    let normal = a.cross(b);
    let area = normal.length_squared();
    let share = |x: f64| {
        if area > 0.0 {
            (x / area).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let offset = p - corners[0];
    let s = share(offset.cross(b).dot(normal));
    let t = share(a.cross(offset).dot(normal));
    let blend = |x: [f64; 3]| (x[0] + s * (x[1] - x[0]) + t * (x[2] - x[0])) / n as f64;
    Place {
        face,
        u: blend(ends.map(|end| end.0)),
        v: blend(ends.map(|end| end.1)),
    }
}

/// Distance to the surface from a start on it: damped Newton, over borders.
fn closest(surface: &LimitSurface, p: DVec3, start: Place) -> f64 {
    let mut place = start;
    let mut best = f64::INFINITY;
    for _ in 0..=CROSSINGS {
        let (square, side) = descend(surface, p, &mut place);
        let better = square < best * (1.0 - 1e-14);
        best = best.min(square);
        match side.and_then(|side| across(surface, place, side)) {
            Some(next) if better => place = next,
            _ => break,
        }
    }
    best.sqrt()
}

/// Walks to the nearest place of a face; the side that held it, if one did.
fn descend(surface: &LimitSurface, p: DVec3, place: &mut Place) -> (f64, Option<usize>) {
    let face = surface.face(place.face);
    let mut jet = face.at(place.u, place.v);
    let mut square = jet.point.distance_squared(p);
    let mut damping = 0.0;
    let mut held = None;
    for _ in 0..STEPS {
        let r = jet.point - p;
        let gradient = [r.dot(jet.du), r.dot(jet.dv)];
        let [a, b, c] = curvature(&jet, r, damping);
        // Sides that hold: at the end of a parameter, pulled beyond it.
        let stuck = |t: f64, g: f64| (t <= 0.0 && g > 0.0) || (t >= 1.0 && g < 0.0);
        let (at_u, at_v) = (stuck(place.u, gradient[0]), stuck(place.v, gradient[1]));
        held = if at_u {
            Some(if place.u > 0.5 { 1 } else { 3 })
        } else if at_v {
            Some(if place.v > 0.5 { 2 } else { 0 })
        } else {
            None
        };
        let (du, dv) = match (at_u, at_v) {
            (true, true) => break,
            (true, false) => (0.0, -gradient[1] / c),
            (false, true) => (-gradient[0] / a, 0.0),
            (false, false) => {
                let det = a * c - b * b;
                (
                    (gradient[1] * b - gradient[0] * c) / det,
                    (gradient[0] * b - gradient[1] * a) / det,
                )
            }
        };
        let (u, v) = (
            (place.u + du).clamp(0.0, 1.0),
            (place.v + dv).clamp(0.0, 1.0),
        );
        let moved = (u - place.u).abs() + (v - place.v).abs();
        // Not a number where the surface is degenerate: no way on.
        if moved.is_nan() || moved < 1e-14 {
            break;
        }
        let next = face.at(u, v);
        let next_square = next.point.distance_squared(p);
        if next_square < square {
            let settled = square - next_square <= 1e-15 * square;
            (jet, square, place.u, place.v) = (next, next_square, u, v);
            damping *= 0.1;
            if settled {
                break;
            }
        } else if damping > 1e6 {
            break;
        } else {
            damping = f64::max(1e-3, 10.0 * damping);
        }
    }
    (square, held)
}

/// Second derivatives of half the squared distance, positive definite: those
/// of Gauss and Newton where the true ones are not.
fn curvature(jet: &Jet, r: DVec3, damping: f64) -> [f64; 3] {
    let flat = [
        jet.du.length_squared(),
        jet.du.dot(jet.dv),
        jet.dv.length_squared(),
    ];
    let bent = [
        flat[0] + r.dot(jet.duu),
        flat[1] + r.dot(jet.duv),
        flat[2] + r.dot(jet.dvv),
    ];
    let sound = bent[0] > 0.0 && bent[0] * bent[2] - bent[1] * bent[1] > 1e-9 * flat[0] * flat[2];
    let [a, b, c] = if sound { bent } else { flat };
    [a + damping * flat[0], b, c + damping * flat[2]]
}

/// The same place seen from the neighbour over a side; none at the rim.
fn across(surface: &LimitSurface, place: Place, side: usize) -> Option<Place> {
    let along = [place.u, place.v, 1.0 - place.u, 1.0 - place.v][side];
    let h = (4 * place.face + side) as u32;
    let cage = surface.mesh().cage();
    let twin = cage.twin(h).filter(|_| !cage.is_rim(h))?;
    let (u, v) = on_side(twin % 4, 1.0 - along);
    Some(Place {
        face: twin as usize / 4,
        u,
        v,
    })
}
