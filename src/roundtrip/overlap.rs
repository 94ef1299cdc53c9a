//! Volume that two closed meshes have in common, along many parallel lines.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::mesh::{Bounds, TriMesh};

/// Lines, about.
const LINES: f64 = 100_000.0;

/// A line enters or leaves a mesh.
#[derive(Clone, Copy)]
struct Hit {
    line: u32,
    depth: f64,
    /// 0 or 1.
    mesh: usize,
    /// 1 on the way in, -1 on the way out.
    step: i32,
}

/// Lines along the shortest side of a box, on a square grid.
struct Lines {
    /// Axes: two across, then along.
    axes: [usize; 3],
    low: DVec2,
    step: f64,
    counts: [u32; 2],
}

impl Lines {
    fn new(bounds: &Bounds) -> Lines {
        let size = bounds.size();
        let along = size.min_position();
        let axes = [(along + 1) % 3, (along + 2) % 3, along];
        let across = DVec2::new(size[axes[0]], size[axes[1]]);
        // Not thinner than this, so that the counts stay small.
        let across = across.max(DVec2::splat(1e-3 * size.length()));
        let step = (across.element_product() / LINES).sqrt();
        // Off round numbers, which edges of parts love.
        let low = DVec2::new(bounds.min[axes[0]], bounds.min[axes[1]]) + 0.471_3 * step;
        Lines {
            axes,
            low,
            step,
            counts: (across / step).ceil().to_array().map(|n| n as u32),
        }
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new(p[self.axes[0]], p[self.axes[1]])
    }

    /// Numbers of the lines between two coordinates across.
    fn between(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<u32> {
        let number = |x: f64| ((x - self.low[axis]) / self.step).ceil().max(0.0) as u32;
        number(low)..(number(high) + 1).min(self.counts[axis])
    }

    /// Hits with one triangle. A line through an edge hits one of its two
    /// triangles, one through a vertex as many as close up.
    fn hits(&self, corners: [DVec3; 3], mesh: usize, out: &mut Vec<Hit>) {
        let flat = corners.map(|p| self.flat(p));
        let low = flat[0].min(flat[1]).min(flat[2]);
        let high = flat[0].max(flat[1]).max(flat[2]);
        for j in self.between(1, low.y, high.y) {
            for i in self.between(0, low.x, high.x) {
                let at = self.low + self.step * DVec2::new(f64::from(i), f64::from(j));
                let sides = [[1, 2], [2, 0], [0, 1]].map(|[a, b]| side(flat[a], flat[b], at));
                let positive = sides.iter().all(|s| s.0);
                if !positive && sides.iter().any(|s| s.0) {
                    continue;
                }
                let sum: f64 = sides.iter().map(|s| s.1).sum();
                let weighted = sides
                    .iter()
                    .zip(corners)
                    .map(|(s, p)| s.1 * p[self.axes[2]]);
                let depth = weighted.sum::<f64>() / sum;
                if depth.is_finite() {
                    out.push(Hit {
                        line: j * self.counts[0] + i,
                        depth,
                        mesh,
                        // Counter-clockwise seen from the far end: the outside
                        // is there.
                        step: if positive { -1 } else { 1 },
                    });
                }
            }
        }
    }
}

/// Whether a point is to the left of the way from `a` to `b`, and twice the
/// area between them; the other way says the opposite, even on a tie.
fn side(a: DVec2, b: DVec2, p: DVec2) -> (bool, f64) {
    let turned = (b.x, b.y) < (a.x, a.y);
    let (a, b) = if turned { (b, a) } else { (a, b) };
    let coord = |p: DVec2| robust::Coord { x: p.x, y: p.y };
    let area = robust::orient2d(coord(a), coord(b), coord(p));
    ((area >= 0.0) != turned, if turned { -area } else { area })
}

/// Volume in both meshes over volume in either.
pub(super) fn overlap(meshes: [&TriMesh; 2]) -> f64 {
    let lines = Lines::new(&Bounds::of(
        meshes.iter().flat_map(|m| m.positions.iter().copied()),
    ));
    let mut hits = Vec::new();
    for (number, mesh) in meshes.into_iter().enumerate() {
        for face in mesh.faces() {
            lines.hits(mesh.corners(face), number, &mut hits);
        }
    }
    hits.par_sort_unstable_by(|a, b| {
        let by_depth = a.line.cmp(&b.line).then(a.depth.total_cmp(&b.depth));
        by_depth.then((a.mesh, a.step).cmp(&(b.mesh, b.step)))
    });
    let (mut both, mut either) = (0.0, 0.0);
    for line in hits.chunk_by(|a, b| a.line == b.line) {
        let mut depth = [0, 0];
        let mut last = line[0].depth;
        for hit in line {
            let way = hit.depth - last;
            let inside = depth.map(|d| d > 0);
            both += if inside == [true; 2] { way } else { 0.0 };
            either += if inside.contains(&true) { way } else { 0.0 };
            depth[hit.mesh] += hit.step;
            last = hit.depth;
        }
    }
    if either > 0.0 { both / either } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid(low: DVec3, high: DVec3) -> TriMesh {
        let corner = |k: usize| {
            let pick = |axis: usize| {
                if k >> axis & 1 == 1 {
                    high[axis]
                } else {
                    low[axis]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        TriMesh {
            positions: (0..8).map(corner).collect(),
            triangles: (quads.iter())
                .flat_map(|&[a, b, c, d]: &[u32; 4]| [[a, b, c], [a, c, d]])
                .collect(),
        }
    }

    #[test]
    fn boxes_overlap_by_what_they_share() {
        let a = cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0));
        assert!((overlap([&a, &a]) - 1.0).abs() < 1e-12);
        let thicker = cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.5));
        assert!((overlap([&a, &thicker]) - 0.8).abs() < 1e-12);
        let shifted = cuboid(DVec3::X, DVec3::new(5.0, 3.0, 2.0));
        assert!((overlap([&a, &shifted]) - 0.6).abs() < 5e-3);
        let away = cuboid(DVec3::splat(9.0), DVec3::splat(10.0));
        assert_eq!(overlap([&a, &away]), 0.0);
        assert_eq!(overlap([&TriMesh::default(), &TriMesh::default()]), 0.0);
    }
}
