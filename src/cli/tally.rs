//! What there is in a mid-surface: counts, lengths, areas, thickness.

use midsurf::mesh::midsurface::{BorderKind, MidSurface};
use serde::Serialize;

/// Lines of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Lines {
    /// How many.
    pub(super) count: usize,
    /// Those that run in a ring.
    pub(super) closed: usize,
    /// Their length, part units.
    pub(super) length: f64,
}

/// Thickness over the mid-surface, weighted by area, part units.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Thickness {
    pub(super) min: f64,
    pub(super) p5: f64,
    pub(super) p25: f64,
    pub(super) p50: f64,
    pub(super) p75: f64,
    pub(super) p95: f64,
    pub(super) max: f64,
    pub(super) mean: f64,
}

/// Counts and measures of a mid-surface.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Tally {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) sheets: usize,
    pub(super) seams: Lines,
    /// Vertices where seams meet or end.
    pub(super) junctions: usize,
    /// Those of them off the free boundary.
    pub(super) inner_junctions: usize,
    /// A border is cut where its kind or its sheet changes.
    pub(super) coping_borders: Lines,
    pub(super) fading_borders: Lines,
    /// Connected pieces of the free boundary, whatever its kinds.
    pub(super) boundary_components: usize,
    /// Connected pieces of the whole.
    pub(super) components: usize,
    /// Vertices less edges plus triangles.
    pub(super) euler: i64,
    pub(super) area: f64,
    /// Area of each sheet.
    pub(super) sheet_areas: Vec<f64>,
    /// None without triangles.
    pub(super) thickness: Option<Thickness>,
}

impl Tally {
    pub(super) fn of(surface: &MidSurface) -> Tally {
        let edges = edges(surface);
        let used = used_vertices(surface);
        let free: Vec<[u32; 2]> = edges.iter().filter(|e| e.1 == 1).map(|e| e.0).collect();
        let mut on_boundary = vec![false; surface.vertices.len()];
        for end in free.iter().flatten() {
            on_boundary[*end as usize] = true;
        }
        let inner = surface.junctions.iter().filter(|&&v| !on_boundary[v as usize]);
        let areas: Vec<f64> = (0..surface.triangles.len())
            .map(|triangle| area(surface, triangle))
            .collect();
        let mut sheet_areas = vec![0.0; surface.sheet_count as usize];
        for (triangle, area) in surface.triangles.iter().zip(&areas) {
            sheet_areas[triangle.sheet as usize] += area;
        }
        let seams = surface.seams.iter().map(|seam| (&seam.path, seam.closed));
        let borders = |kind: BorderKind| {
            let borders = surface.borders.iter().filter(move |b| b.kind == kind);
            borders.map(|border| (&border.path, border.closed))
        };
        Tally {
            vertices: used,
            triangles: surface.triangles.len(),
            sheets: surface.sheet_count as usize,
            seams: lines(surface, seams),
            junctions: surface.junctions.len(),
            inner_junctions: inner.count(),
            coping_borders: lines(surface, borders(BorderKind::Coping)),
            fading_borders: lines(surface, borders(BorderKind::Fading)),
            boundary_components: pieces(surface, free.iter().copied()),
            components: pieces(surface, edges.iter().map(|edge| edge.0)),
            euler: used as i64 - edges.len() as i64 + surface.triangles.len() as i64,
            area: areas.iter().sum(),
            sheet_areas,
            thickness: thickness(surface, &areas),
        }
    }
}

/// Edges of the triangles, low vertex first, with the number of triangles.
fn edges(surface: &MidSurface) -> Vec<([u32; 2], u32)> {
    let mut all: Vec<[u32; 2]> = Vec::with_capacity(3 * surface.triangles.len());
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.corners;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            all.push([from.min(to), from.max(to)]);
        }
    }
    all.sort_unstable();
    all.chunk_by(|a, b| a == b)
        .map(|uses| (uses[0], uses.len() as u32))
        .collect()
}

fn used_vertices(surface: &MidSurface) -> usize {
    let mut used = vec![false; surface.vertices.len()];
    for corner in surface.triangles.iter().flat_map(|t| t.corners) {
        used[corner as usize] = true;
    }
    used.iter().filter(|&&used| used).count()
}

/// Connected pieces of a graph of edges; vertices without edges do not count.
fn pieces(surface: &MidSurface, edges: impl Iterator<Item = [u32; 2]>) -> usize {
    let mut parent: Vec<u32> = (0..surface.vertices.len() as u32).collect();
    let mut met = vec![false; surface.vertices.len()];
    let mut pieces = 0;
    for ends in edges {
        for end in ends {
            pieces += usize::from(!met[end as usize]);
            met[end as usize] = true;
        }
        let [a, b] = ends.map(|end| root(&mut parent, end));
        if a != b {
            parent[a.max(b) as usize] = a.min(b);
            pieces -= 1;
        }
    }
    pieces
}

/// Representative of a set in a union-find forest; halves the way to it.
fn root(parent: &mut [u32], mut item: u32) -> u32 {
    while parent[item as usize] != item {
        let above = parent[parent[item as usize] as usize];
        parent[item as usize] = above;
        item = above;
    }
    item
}

fn lines<'a>(
    surface: &MidSurface,
    lines: impl Iterator<Item = (&'a Vec<u32>, bool)>,
) -> Lines {
    let at = |vertex: u32| surface.vertices[vertex as usize].position;
    let mut sum = Lines::default();
    for (path, closed) in lines {
        sum.count += 1;
        sum.closed += usize::from(closed);
        let steps = path.windows(2).map(|ends| at(ends[0]).distance(at(ends[1])));
        sum.length += steps.sum::<f64>();
        if let ([first, .., last], true) = (path.as_slice(), closed) {
            sum.length += at(*first).distance(at(*last));
        }
    }
    sum
}

fn area(surface: &MidSurface, triangle: usize) -> f64 {
    let corners = surface.triangles[triangle].corners;
    let [a, b, c] = corners.map(|v| surface.vertices[v as usize].position);
    0.5 * (b - a).cross(c - a).length()
}

/// Every vertex counts with a third of the area of its triangles.
fn thickness(surface: &MidSurface, areas: &[f64]) -> Option<Thickness> {
    let mut weights = vec![0.0; surface.vertices.len()];
    for (triangle, area) in surface.triangles.iter().zip(areas) {
        for corner in triangle.corners {
            weights[corner as usize] += area / 3.0;
        }
    }
    let mut samples: Vec<(f64, f64)> = surface
        .vertices
        .iter()
        .zip(weights)
        .filter(|(_, weight)| *weight > 0.0)
        .map(|(vertex, weight)| (vertex.thickness, weight))
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last) = (samples.first()?.0, samples.last()?.0);
    let total: f64 = samples.iter().map(|sample| sample.1).sum();
    let percentile = |percent: f64| {
        let mut sum = 0.0;
        let reached = samples.iter().find(|sample| {
            sum += sample.1;
            sum >= 0.01 * percent * total
        });
        reached.map_or(last, |sample| sample.0)
    };
    Some(Thickness {
        min: first,
        p5: percentile(5.0),
        p25: percentile(25.0),
        p50: percentile(50.0),
        p75: percentile(75.0),
        p95: percentile(95.0),
        max: last,
        mean: samples.iter().map(|(t, weight)| t * weight).sum::<f64>() / total,
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use midsurf::mesh::midsurface::{
        BorderLine, MidTriangle, MidVertex, SeamLine, VertexKind,
    };
    use smallvec::SmallVec;

    use super::*;

    /// Three unit squares that meet in the edge from vertex 0 to vertex 1,
    /// and a triangle apart.
    fn three_wings() -> MidSurface {
        let mut points = vec![DVec3::ZERO, DVec3::Z];
        let mut triangles = Vec::new();
        for (sheet, way) in [DVec3::X, DVec3::Y, DVec3::NEG_X].into_iter().enumerate() {
            let a = points.len() as u32;
            points.extend([way, way + DVec3::Z]);
            for corners in [[0, a, a + 1], [0, a + 1, 1]] {
                let sheet = sheet as u32;
                triangles.push(MidTriangle { corners, sheet });
            }
        }
        let a = points.len() as u32;
        points.extend([5.0, 6.0, 7.0].map(|x| DVec3::new(x, x * x, 0.0)));
        let corners = [a, a + 1, a + 2];
        triangles.push(MidTriangle { corners, sheet: 3 });
        let vertex = |position: DVec3| MidVertex {
            position,
            kind: VertexKind::Sheet,
            thickness: 2.0 + position.z,
            footpoints: SmallVec::new(),
        };
        MidSurface {
            vertices: points.into_iter().map(vertex).collect(),
            triangles,
            seams: vec![SeamLine { path: vec![0, 1], sheets: vec![0, 1, 2], closed: false }],
            borders: vec![BorderLine {
                path: vec![a, a + 1, a + 2],
                sheet: 3,
                kind: BorderKind::Fading,
                closed: true,
            }],
            junctions: vec![0, 1],
            sheet_count: 4,
        }
    }

    #[test]
    fn counts_of_three_wings_and_an_island() {
        let tally = Tally::of(&three_wings());
        assert_eq!((tally.junctions, tally.inner_junctions), (2, 0));
        assert_eq!((tally.vertices, tally.triangles, tally.sheets), (11, 7, 4));
        assert_eq!((tally.components, tally.boundary_components), (2, 2));
        // A disc each.
        assert_eq!(tally.euler, 2);
        assert_eq!(tally.seams, Lines { count: 1, closed: 0, length: 1.0 });
        assert_eq!(tally.coping_borders, Lines::default());
        assert_eq!((tally.fading_borders.count, tally.fading_borders.closed), (1, 1));
        let round = 122f64.sqrt() + 170f64.sqrt() + 580f64.sqrt();
        assert!((tally.fading_borders.length - round).abs() < 1e-12);
        assert!((tally.area - 4.0).abs() < 1e-12);
        assert_eq!(tally.sheet_areas.len(), 4);
        let thickness = tally.thickness.unwrap();
        assert_eq!((thickness.min, thickness.max), (2.0, 3.0));
        assert!((thickness.mean - (2.5 * 3.0 + 2.0) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_has_no_thickness() {
        let tally = Tally::of(&MidSurface::default());
        assert_eq!((tally.components, tally.euler), (0, 0));
        assert!(tally.thickness.is_none());
    }
}
