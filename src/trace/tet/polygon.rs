//! Triangles for one polygon of a tetrahedron.

use glam::DVec3;

/// Cuts a polygon into triangles (indices of its corners); `None` where every
/// cut would use a forbidden diagonal.
///
/// Among all cuts the one of least area is taken, so that a polygon bent
/// along a crease is cut along the crease; where areas are equal, the one with
/// the better-shaped triangles. `forbidden(i, j)` tells diagonals that would
/// lie in a face of the tetrahedron: the neighbour might choose the same one,
/// and four triangles would meet there.
pub fn triangulate(
    points: &[DVec3],
    forbidden: impl Fn(usize, usize) -> bool,
) -> Option<Vec<[usize; 3]>> {
    /// Weight of shape against area.
    const SHAPE: f64 = 0.02;
    /// Area against the squares of the sides below which there is none: a
    /// thousand times what rounding leaves of a straight border.
    const FLAT: f64 = 1e-9;
    let n = points.len();
    if n < 3 {
        return Some(Vec::new());
    }
    let up = normal(points).normalize_or_zero();
    // A triangle that faces the other way than the polygon costs more than
    // any cut without one.
    let folded: f64 = 10.0
        * (0..n)
            .map(|k| points[0].distance_squared(points[k]))
            .fold(0.0, f64::max);
    let folded = folded * n as f64;
    let cost = |i: usize, j: usize, k: usize| {
        let (a, b, c) = (points[i], points[j], points[k]);
        let cross = (b - a).cross(c - a);
        let area = 0.5 * cross.length();
        let sides = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
        let quality = 4.0 * 3f64.sqrt() * area / sides.max(1e-300);
        // Beside a concave bend of a border a triangle may lie over another;
        // three points of a straight border make none.
        let fold = if cross.dot(up) < -FLAT * sides {
            folded
        } else if area <= FLAT * sides {
            0.5 * folded
        } else {
            0.0
        };
        area + SHAPE * sides * (1.0 - quality) + fold
    };
    let allowed = |i: usize, j: usize| j == i + 1 || (i == 0 && j == n - 1) || !forbidden(i, j);
    // best[i][j]: cost of the polygon i, i+1, .. j closed by the diagonal j-i.
    let mut best = vec![f64::INFINITY; n * n];
    let mut apex = vec![usize::MAX; n * n];
    for i in 0..n - 1 {
        best[i * n + i + 1] = 0.0;
    }
    for span in 2..n {
        for i in 0..n - span {
            let j = i + span;
            if !allowed(i, j) {
                continue;
            }
            for k in i + 1..j {
                let total = best[i * n + k] + best[k * n + j] + cost(i, k, j);
                if total < best[i * n + j] {
                    best[i * n + j] = total;
                    apex[i * n + j] = k;
                }
            }
        }
    }
    if !best[n - 1].is_finite() {
        return None;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    let mut open = vec![(0, n - 1)];
    while let Some((i, j)) = open.pop() {
        if j < i + 2 {
            continue;
        }
        let k = apex[i * n + j];
        triangles.push([i, k, j]);
        open.push((i, k));
        open.push((k, j));
    }
    Some(triangles)
}

/// Normal of a polygon by Newell's sum, twice its area long.
pub fn normal(points: &[DVec3]) -> DVec3 {
    let n = points.len();
    (0..n).map(|i| points[i].cross(points[(i + 1) % n])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_cut_in_two_and_a_forbidden_diagonal_avoided() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let cut = triangulate(&square, |i, j| (i, j) == (0, 2)).unwrap();
        assert_eq!(cut.len(), 2);
        assert!(cut.iter().all(|t| t.contains(&1) && t.contains(&3)));
        assert!(triangulate(&square, |_, _| true).is_none());
    }

    #[test]
    fn a_roof_is_cut_along_its_ridge() {
        let roof = [
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(2.0, 0.0, 0.0),
            DVec3::new(2.0, 3.0, 0.0),
            DVec3::new(1.0, 3.0, 1.0),
            DVec3::new(0.0, 3.0, 0.0),
        ];
        // The gables lie in faces of the tetrahedron.
        let cut = triangulate(&roof, |i, j| (i, j) == (0, 2) || (i, j) == (3, 5)).unwrap();
        let ridge = cut
            .iter()
            .filter(|t| t.contains(&1) && t.contains(&4))
            .count();
        assert_eq!(ridge, 2);
    }
}
