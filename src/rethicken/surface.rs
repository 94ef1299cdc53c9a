//! The surface with its balls: what is re-thickened.

use std::borrow::Cow;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::RethickenError;
use crate::mesh::{Bounds, Frame, TriMesh, weld_exact};
use crate::surface::{BorderKind, MidSurface, segments};

/// Triangles, any number of them to an edge, with the radius of a ball at
/// every vertex.
///
/// Invariants, held by [`BallSurface::new`]: indices in range, positions and
/// radii finite, no radius negative, one at least positive, at least one
/// triangle.
#[derive(Clone, Debug)]
pub struct BallSurface {
    pub(super) positions: Vec<DVec3>,
    pub(super) radii: Vec<f64>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) flat: Vec<FlatEdge>,
}

/// A free edge at which the solid ends flat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FlatEdge {
    /// Vertices, in the order in which the triangle runs them.
    pub ends: [u32; 2],
    pub triangle: u32,
}

/// An edge, lower vertex first.
pub(super) fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl BallSurface {
    /// `radii[v]` belongs to `positions[v]`. Of the edges of one triangle, the
    /// solid ends flat at those that `flat` names, and round at the others.
    ///
    /// # Errors
    ///
    /// [`RethickenError`] for what the invariants exclude.
    pub fn new(
        positions: Vec<DVec3>,
        radii: Vec<f64>,
        triangles: Vec<[u32; 3]>,
        flat: impl Fn([u32; 2]) -> bool,
    ) -> Result<BallSurface, RethickenError> {
        if triangles.is_empty() {
            return Err(RethickenError::NoTriangles);
        }
        if radii.len() != positions.len() {
            return Err(RethickenError::RadiusCount {
                radii: radii.len(),
                vertices: positions.len(),
            });
        }
        let beyond = |t: &&[u32; 3]| t.iter().any(|&v| v as usize >= positions.len());
        if let Some(&corners) = triangles.iter().find(beyond) {
            return Err(RethickenError::BadIndex { corners });
        }
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(RethickenError::BadPosition { vertex });
        }
        let bad = |r: &f64| !(r.is_finite() && *r >= 0.0);
        if let Some(vertex) = radii.iter().position(bad) {
            return Err(RethickenError::BadRadius {
                vertex,
                radius: radii[vertex],
                count: radii.iter().filter(|r| bad(r)).count(),
            });
        }
        if triangles
            .iter()
            .flatten()
            .all(|&v| radii[v as usize] == 0.0)
        {
            return Err(RethickenError::NoThickness);
        }
        let flat = free_edges(&triangles)
            .filter(|edge| flat(edge.ends))
            .collect();
        Ok(BallSurface {
            positions,
            radii,
            triangles,
            flat,
        })
    }

    /// Any shell mesh, non-manifold or not, with a thickness for each triangle,
    /// half of it to either side. The solid ends flat at free edges.
    ///
    /// # Errors
    ///
    /// As [`BallSurface::new`].
    pub fn of_shell(shell: &TriMesh, thickness: &[f64]) -> Result<BallSurface, RethickenError> {
        if thickness.len() != shell.triangles.len() {
            return Err(RethickenError::RadiusCount {
                radii: thickness.len(),
                vertices: shell.triangles.len(),
            });
        }
        let place = weld_exact(&shell.positions);
        let mut numbers: FxHashMap<(u32, u64), u32> = FxHashMap::default();
        let mut sources = Vec::new();
        let mut radii = Vec::new();
        let mut triangles = Vec::with_capacity(shell.triangles.len());
        let mut welded = Vec::with_capacity(shell.triangles.len());
        for (&corners, thickness) in shell.triangles.iter().zip(thickness) {
            if corners.iter().any(|&v| v as usize >= shell.positions.len()) {
                return Err(RethickenError::BadIndex { corners });
            }
            let corners = corners.map(|v| place.new_index[v as usize]);
            welded.push(corners);
            triangles.push(corners.map(|v| {
                *numbers.entry((v, thickness.to_bits())).or_insert_with(|| {
                    sources.push(v);
                    radii.push(0.5 * thickness);
                    sources.len() as u32 - 1
                })
            }));
        }
        // Of triangles of different thickness at an edge the thinnest ends round,
        // which fills the joint, and the others flat, so that none sticks out.
        let mut thinnest: FxHashMap<[u32; 2], f64> = FxHashMap::default();
        for (edge, uses) in edges(&welded) {
            let own = uses.iter().map(|&t| thickness[t as usize]);
            let least = own.fold(f64::INFINITY, f64::min);
            thinnest.insert(edge, if uses.len() == 1 { 0.0 } else { least });
        }
        let position = |&v: &u32| shell.positions[place.kept[v as usize] as usize];
        let positions = sources.iter().map(position).collect();
        let source = |v: u32| sources[v as usize];
        let flat = |[a, b]: [u32; 2]| {
            let least = thinnest.get(&key(source(a), source(b)));
            least.is_some_and(|&least| 2.0 * radii[a as usize] > least)
        };
        BallSurface::new(positions, radii.clone(), triangles, flat)
    }

    /// An extracted mid-surface with its maximal balls. It ends flat at coping
    /// borders, and round at fading ones and at cracks.
    ///
    /// # Errors
    ///
    /// As [`BallSurface::new`].
    pub fn of(surface: &MidSurface) -> Result<BallSurface, RethickenError> {
        let mut coping = FxHashSet::default();
        for border in surface
            .borders()
            .iter()
            .filter(|b| b.kind == BorderKind::Coping)
        {
            coping.extend(segments(&border.path, border.closed).map(|[a, b]| key(a, b)));
        }
        let mesh = surface.mesh();
        BallSurface::new(
            mesh.positions,
            surface.vertices().iter().map(|v| v.ball.radius).collect(),
            mesh.triangles,
            |[a, b]| coping.contains(&key(a, b)),
        )
    }

    /// The same surface, round at all its borders.
    pub fn rounded(mut self) -> BallSurface {
        self.flat.clear();
        self
    }

    /// Least diameter of a ball of positive radius at a vertex in use.
    pub fn least_thickness(&self) -> f64 {
        let used = self
            .triangles
            .iter()
            .flatten()
            .map(|&v| self.radii[v as usize]);
        2.0 * used.filter(|&r| r > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Median diameter of the balls over the area.
    pub fn median_thickness(&self) -> f64 {
        let mut weighted: Vec<(f64, f64)> = (self.triangles.iter())
            .map(|t| {
                let radius: f64 = t.iter().map(|&v| self.radii[v as usize]).sum();
                (radius * (2.0 / 3.0), self.area_of(t))
            })
            .collect();
        weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * self.area();
        let mut sum = 0.0;
        let reached = weighted.iter().find(|(_, area)| {
            sum += area;
            sum >= half
        });
        reached.or(weighted.last()).map_or(0.0, |w| w.0)
    }

    /// Area of the triangles, square part units.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|t| self.area_of(t)).sum()
    }

    fn area_of(&self, triangle: &[u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        0.5 * (b - a).cross(c - a).length()
    }

    fn bounds(&self) -> Bounds {
        let used = self.triangles.iter().flatten();
        Bounds::of(used.map(|&v| self.positions[v as usize]))
    }

    /// Length of the diagonal of the box around the surface.
    pub fn diagonal(&self) -> f64 {
        self.bounds().diagonal()
    }

    /// The frame for the surface and its balls.
    pub(super) fn frame(&self) -> Frame {
        let used = self.triangles.iter().flatten();
        let radius = used.fold(0.0, |most: f64, &v| most.max(self.radii[v as usize]));
        Frame::around(&self.bounds().grown(radius))
    }

    /// The surface in a frame.
    pub(super) fn in_frame(&self, frame: Frame) -> Cow<'_, BallSurface> {
        if frame.is_identity() {
            return Cow::Borrowed(self);
        }
        let mut surface = self.clone();
        frame.enter(&mut surface.positions);
        Cow::Owned(surface)
    }

    /// Number of edges at which the solid ends flat.
    pub fn flat_edges(&self) -> usize {
        self.flat.len()
    }
}

/// Triangles at each edge, in order.
pub(super) fn edges(triangles: &[[u32; 3]]) -> FxHashMap<[u32; 2], Vec<u32>> {
    let mut edges: FxHashMap<[u32; 2], Vec<u32>> = FxHashMap::default();
    for (t, corners) in (0..).zip(triangles) {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            if a != b {
                edges.entry(key(a, b)).or_default().push(t);
            }
        }
    }
    edges
}

/// Edges of one triangle, in the order of the triangles.
fn free_edges(triangles: &[[u32; 3]]) -> impl Iterator<Item = FlatEdge> + '_ {
    let uses = edges(triangles);
    (0..).zip(triangles).flat_map(move |(triangle, corners)| {
        let sides = [0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3]]);
        let free = sides.map(|[a, b]| uses.get(&key(a, b)).is_some_and(|u| u.len() == 1));
        (0..3).filter(move |&i| free[i]).map(move |i| FlatEdge {
            ends: sides[i],
            triangle,
        })
    })
}
