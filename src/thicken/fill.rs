//! Small holes closed: boundary curves spanned by the triangles of least area.
//!
//! After Barequet and Sharir, "Filling gaps in the boundary of a polyhedron"
//! (1995), whom the thickening paper follows for the holes of its
//! cross-section.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::mesh::TriMesh;

/// Vertices of a curve up to which it is closed; time grows with their cube.
const MOST_SIDES: usize = 256;

/// Closes boundary curves no longer than `longest`; how many. The mesh must be a
/// manifold whose triangles agree about the side.
pub(super) fn fill(mesh: &mut TriMesh, longest: f64) -> usize {
    let curves = boundary_curves(mesh);
    let mut filled = 0;
    for curve in curves {
        let at = |k: usize| mesh.positions[curve[k % curve.len()] as usize];
        let length: f64 = (0..curve.len()).map(|k| at(k).distance(at(k + 1))).sum();
        if length <= longest && curve.len() <= MOST_SIDES {
            let triangles = spanned(&curve, &mesh.positions);
            mesh.triangles.extend(triangles);
            filled += 1;
        }
    }
    filled
}

/// Boundary curves, against the direction in which triangles run them; in the
/// order of their first triangles.
fn boundary_curves(mesh: &TriMesh) -> Vec<Vec<u32>> {
    let mut before: FxHashMap<u32, u32> = FxHashMap::default();
    let mut starts = Vec::new();
    for uses in mesh.edges().by_edge() {
        if let [one] = uses {
            let [from, to] = if one.forward {
                one.edge
            } else {
                [one.edge[1], one.edge[0]]
            };
            before.insert(to, from);
            starts.push((one.face, to));
        }
    }
    starts.sort_unstable();
    let mut curves = Vec::new();
    for (_, start) in starts {
        let mut curve = Vec::new();
        let mut here = start;
        while let Some(next) = before.remove(&here) {
            curve.push(here);
            here = next;
        }
        // One that does not come back is none: the mesh is pinched there.
        if curve.len() > 2 && here == start {
            curves.push(curve);
        }
    }
    curves
}

/// The triangles of least area over a polygon in space.
fn spanned(polygon: &[u32], positions: &[DVec3]) -> Vec<[u32; 3]> {
    let n = polygon.len();
    let at = |k: usize| positions[polygon[k] as usize];
    let area = |i: usize, k: usize, j: usize| (at(k) - at(i)).cross(at(j) - at(i)).length();
    // Of the part from i to j: its least area, and the corner of the triangle on
    // its chord.
    let mut best = vec![(0.0_f64, 0_usize); n * n];
    for gap in 2..n {
        for i in 0..n - gap {
            let j = i + gap;
            let cost = |k: usize| best[i * n + k].0 + best[k * n + j].0 + area(i, k, j);
            let costs = (i + 1..j).map(|k| (cost(k), k));
            let least = costs.min_by(|a, b| a.0.total_cmp(&b.0));
            best[i * n + j] = least.unwrap_or((f64::INFINITY, i + 1));
        }
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut open = vec![[0, n - 1]];
    while let Some([i, j]) = open.pop() {
        if j > i + 1 {
            let k = best[i * n + j].1;
            triangles.push([i, k, j].map(|corner| polygon[corner]));
            open.extend([[i, k], [k, j]]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of squares without the one in the middle.
    #[test]
    fn a_hole_is_closed_flat_and_the_outline_is_left() {
        let mut mesh = TriMesh::default();
        for i in 0..4 {
            for j in 0..4 {
                mesh.positions
                    .push(DVec3::new(f64::from(i), f64::from(j), 0.0));
            }
        }
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            if (i, j) != (1, 1) {
                let [a, b, c, d] = [4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let open = mesh.clone();
        assert_eq!(fill(&mut mesh, 3.9), 0);
        assert_eq!(fill(&mut mesh, 4.0), 1);
        assert_eq!(mesh.triangles.len(), open.triangles.len() + 2);
        assert!((mesh.area() - 9.0).abs() < 1e-12);
        let census = mesh.edges().census();
        assert_eq!((census.open, census.misoriented), (12, 0));
    }

    /// A bent L: the diagonal from its reflex corner spans the least.
    #[test]
    fn the_least_area_is_found() {
        let corners = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (1.0, 1.0),
            (1.0, 2.0),
            (0.0, 2.0),
        ];
        let positions: Vec<DVec3> = corners.map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        for shift in 0..6 {
            let mut polygon: Vec<u32> = (0..6).collect();
            polygon.rotate_left(shift);
            let mesh = TriMesh {
                positions: positions.clone(),
                triangles: spanned(&polygon, &positions),
            };
            assert_eq!(mesh.triangles.len(), 4);
            assert!(
                (mesh.area() - 3.0).abs() < 1e-12,
                "{shift}: {}",
                mesh.area()
            );
        }
    }
}
