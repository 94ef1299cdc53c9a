//! Samples of a limit surface on `n + 1` by `n + 1` places of every face,
//! shared where faces meet.
//!
//! Samples are numbered: control vertices, then `n - 1` inner ones of every
//! edge, then `(n - 1)^2` inner ones of every face. Each is computed once, so
//! that neighbours share it to the bit.

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::corner::mitre;
use super::crust::{Crust, Scheme, weight};
use super::limit::{LimitSurface, MOST_SAMPLES};
use super::patch::Scratch;

/// Samples that a shell may have: some 8 GB for a solid of both.
pub const MOST_POINTS: usize = 1 << 25;

/// Where samples lie, and which belong together.
#[derive(Clone, Debug)]
pub struct Grid {
    n: usize,
    vertices: usize,
    /// Half-edge along which the samples of an edge run.
    edges: Vec<u32>,
    edge_of: Vec<u32>,
    /// Vertices of half-edges' faces.
    corners: Vec<[u32; 4]>,
    /// Faces that are no holes.
    drawn: Vec<u32>,
    /// Edges on the rim of the surface, as half-edges of drawn faces.
    rims: Vec<u32>,
    /// Of [`Grid::edges`], those on creases.
    creases: Vec<u32>,
}

/// The samples of the outer and the inner surface.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    /// On the limit surface.
    pub outer: Vec<DVec3>,
    /// Outward unit normals there.
    pub normals: Vec<DVec3>,
    /// On the surface below.
    pub inner: Vec<DVec3>,
}

/// A surface and what lies below, as triangles.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    pub samples: Samples,
    /// Thickness asked for at each sample over that of the whole; none where it
    /// is one.
    pub shares: Vec<f64>,
    /// Of the outer surface.
    pub triangles: Vec<[u32; 3]>,
    pub rims: Vec<[u32; 2]>,
}

impl Laid {
    /// Leaves out samples that no triangle uses, as those of holes.
    fn keep_used(&mut self) {
        let Laid {
            samples,
            shares,
            triangles,
            rims,
        } = self;
        let mut number = vec![u32::MAX; samples.outer.len()];
        for &v in triangles.as_flattened() {
            number[v as usize] = 0;
        }
        let used = number.iter_mut().filter(|slot| **slot == 0);
        used.zip(0..).for_each(|(slot, next)| *slot = next);
        let used = |v: usize| number[v] != u32::MAX;
        for all in [&mut samples.outer, &mut samples.normals, &mut samples.inner] {
            let mut slots = 0..;
            all.retain(|_| slots.next().is_some_and(used));
        }
        let mut slots = 0..;
        shares.retain(|_| slots.next().is_some_and(used));
        let corners = triangles.as_flattened_mut().iter_mut();
        for v in corners.chain(rims.as_flattened_mut()) {
            *v = number[*v as usize];
        }
    }
}

impl Grid {
    /// A grid of `n` steps a side; none when that is too many or none at all.
    pub fn new(surface: &LimitSurface, n: usize) -> Option<Grid> {
        let cage = surface.mesh().cage();
        let mut edges = Vec::with_capacity(cage.edge_count());
        let mut edge_of = vec![0; cage.corner_count()];
        for h in 0..cage.corner_count() as u32 {
            match cage.twin(h) {
                Some(twin) if twin < h => edge_of[h as usize] = edge_of[twin as usize],
                _ => {
                    edge_of[h as usize] = edges.len() as u32;
                    edges.push(h);
                }
            }
        }
        let faces = surface.face_count();
        let creased = |&h: &u32| cage.twin(h).is_some() && cage.across(h).is_none();
        let creases = (0..edges.len() as u32).filter(|&e| creased(&edges[e as usize]));
        let grid = Grid {
            n,
            vertices: cage.positions().len(),
            drawn: (0..faces as u32)
                .filter(|&f| !cage.is_hole(f as usize))
                .collect(),
            rims: (0..cage.corner_count() as u32)
                .filter(|&h| cage.is_rim(h))
                .collect(),
            creases: creases.collect(),
            edges,
            edge_of,
            corners: (0..faces).map(|f| surface.mesh().corners(f)).collect(),
        };
        let fits = (1..=MOST_SAMPLES).contains(&n) && grid.len() <= MOST_POINTS;
        fits.then_some(grid)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        let inner = self.n - 1;
        self.vertices + self.edges.len() * inner + self.corners.len() * inner * inner
    }

    /// Whether there are none, which cannot be.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Steps a side.
    pub fn steps(&self) -> usize {
        self.n
    }

    /// Sample `t` steps along a half-edge.
    pub(super) fn along(&self, h: u32, t: usize) -> u32 {
        let corners = &self.corners[h as usize / 4];
        let k = h as usize % 4;
        if t == 0 {
            return corners[k];
        }
        if t == self.n {
            return corners[(k + 1) % 4];
        }
        let edge = self.edge_of[h as usize] as usize;
        let t = if self.edges[edge] == h { t } else { self.n - t };
        (self.vertices + edge * (self.n - 1) + t - 1) as u32
    }

    /// Sample (i, j) of a face.
    pub(super) fn index(&self, face: usize, i: usize, j: usize) -> u32 {
        let n = self.n;
        let side = |k: u32, t: usize| self.along(4 * face as u32 + k, t);
        if j == 0 {
            side(0, i)
        } else if i == n {
            side(1, j)
        } else if j == n {
            side(2, n - i)
        } else if i == 0 {
            side(3, n - j)
        } else {
            let inner = n - 1;
            let first = self.vertices + self.edges.len() * inner + face * inner * inner;
            (first + (i - 1) * inner + j - 1) as u32
        }
    }

    /// Two triangles for every small quadrilateral, in the order of faces,
    /// then of i, then of j; counter-clockwise from outside. Holes have none.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let n = self.n;
        self.drawn
            .par_iter()
            .flat_map_iter(|&face| {
                let face = face as usize;
                (0..n * n).flat_map(move |cell| {
                    let (i, j) = (cell / n, cell % n);
                    let at = |i, j| self.index(face, i, j);
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    [[a, b, c], [a, c, d]]
                })
            })
            .collect()
    }

    /// Face of one of the [`Grid::triangles`], and its small quadrilateral there.
    pub(super) fn cell_of(&self, triangle: usize) -> (usize, usize) {
        let each = self.n * self.n;
        let (face, cell) = (triangle / 2 / each, triangle / 2 % each);
        (self.drawn[face] as usize, cell)
    }

    /// Steps along the rim of the surface, which is on their left.
    pub fn rims(&self) -> Vec<[u32; 2]> {
        let steps = |&h: &u32| (0..self.n).map(move |t| [self.along(h, t), self.along(h, t + 1)]);
        self.rims.iter().flat_map(steps).collect()
    }

    /// Both surfaces as triangles, without samples that none of them uses.
    pub(super) fn lay(&self, surface: &LimitSurface, crust: &Crust, scheme: Scheme) -> Laid {
        let mut laid = Laid {
            samples: self.sample(surface, crust, scheme),
            shares: self.shares(surface),
            triangles: self.triangles(),
            rims: self.rims(),
        };
        if self.drawn.len() < self.corners.len() {
            laid.keep_used();
        }
        laid
    }

    /// Share of the thickness at every sample, blended as the crust is; none where
    /// it is one.
    fn shares(&self, surface: &LimitSurface) -> Vec<f64> {
        let cage = surface.mesh().cage();
        if !cage.has_shares() {
            return Vec::new();
        }
        let n = self.n;
        let mut shares = vec![1.0; self.len()];
        let weights: Vec<f64> = (0..=n).map(|k| weight(k as f64 / n as f64)[0]).collect();
        for (face, corners) in self.corners.iter().enumerate() {
            let [a, b, c, d] = corners.map(|v| cage.share(v));
            for (i, &wu) in weights.iter().enumerate() {
                let (low, high) = (a + wu * (b - a), d + wu * (c - d));
                for (j, &wv) in weights.iter().enumerate() {
                    shares[self.index(face, i, j) as usize] = low + wv * (high - low);
                }
            }
        }
        shares
    }

    /// Both surfaces at all samples.
    pub fn sample(&self, surface: &LimitSurface, crust: &Crust, scheme: Scheme) -> Samples {
        let mut samples = Samples::default();
        self.sample_into(surface, crust, scheme, &mut samples);
        samples
    }

    /// As [`Grid::sample`], into memory that is there already: to touch new
    /// memory takes longer than the points.
    pub fn sample_into(
        &self,
        surface: &LimitSurface,
        crust: &Crust,
        scheme: Scheme,
        samples: &mut Samples,
    ) {
        for all in [&mut samples.outer, &mut samples.normals, &mut samples.inner] {
            if all.len() != self.len() {
                *all = vec![DVec3::ZERO; self.len()];
            }
        }
        let (v, n) = (self.vertices, self.n);
        samples.outer[..v].copy_from_slice(surface.limits());
        samples.normals[..v].copy_from_slice(surface.normals());
        for ((inner, &p), &vector) in samples.inner[..v]
            .iter_mut()
            .zip(surface.limits())
            .zip(crust.vectors())
        {
            *inner = p - vector;
        }
        if n == 1 {
            return;
        }
        let row = Row {
            surface,
            crust,
            scheme,
            thickness: crust.thickness(),
            n,
            weights: (0..=n).map(|k| weight(k as f64 / n as f64)[0]).collect(),
        };
        let edge_end = v + self.edges.len() * (n - 1);
        let [outer, normals, inner] =
            [&mut samples.outer, &mut samples.normals, &mut samples.inner]
                .map(|all| all[v..].split_at_mut(edge_end - v));
        outer
            .0
            .par_chunks_mut(n - 1)
            .zip(normals.0.par_chunks_mut(n - 1))
            .zip(inner.0.par_chunks_mut(n - 1))
            .zip(&self.edges)
            .with_min_len(8)
            .for_each_init(
                Scratch::default,
                |scratch, (((outer, normals), inner), &h)| {
                    let ranges = match h % 4 {
                        0 => [1..n, 0..1],
                        1 => [n..n + 1, 1..n],
                        2 => [1..n, n..n + 1],
                        _ => [0..1, 1..n],
                    };
                    row.fill(
                        h as usize / 4,
                        ranges,
                        scratch,
                        |i, j| match h % 4 {
                            0 => i - 1,
                            1 => j - 1,
                            2 => n - i - 1,
                            _ => n - j - 1,
                        },
                        [outer, normals, inner],
                    );
                },
            );
        let block = (n - 1) * (n - 1);
        outer
            .1
            .par_chunks_mut(block)
            .zip(normals.1.par_chunks_mut(block))
            .zip(inner.1.par_chunks_mut(block))
            .enumerate()
            .for_each_init(
                Scratch::default,
                |scratch, (face, ((outer, normals), inner))| {
                    let at = |i, j| (i - 1) * (n - 1) + j - 1;
                    row.fill(face, [1..n, 1..n], scratch, at, [outer, normals, inner]);
                },
            );
        self.mitre(surface, &row, samples);
    }

    /// Samples on creases see the other side too.
    fn mitre(&self, surface: &LimitSurface, row: &Row, samples: &mut Samples) {
        let n = self.n;
        let cage = surface.mesh().cage();
        for &edge in &self.creases {
            let h = self.edges[edge as usize];
            let sides =
                [Some(h), cage.twin(h)].map(|h| h.map(|h| (h, surface.face(h as usize / 4))));
            for t in 1..n {
                let along = t as f64 / n as f64;
                let normals: SmallVec<[DVec3; 2]> = sides
                    .iter()
                    .flatten()
                    .map(|(side, face)| {
                        let along = if *side == h { along } else { 1.0 - along };
                        let (u, v) = on_side(side % 4, along);
                        let cross = face.at(u, v).cross();
                        surface.unit_normal(*side as usize / 4, u, v, cross)
                    })
                    .collect();
                let step = mitre(&normals);
                let at = self.vertices + edge as usize * (n - 1) + t - 1;
                samples.normals[at] = step.normalize_or_zero();
                if row.scheme == Scheme::Direct {
                    let ends = [cage.origin(h), cage.end(h)].map(|v| cage.share(v));
                    let share = ends[0] + row.weights[t] * (ends[1] - ends[0]);
                    samples.inner[at] = samples.outer[at] - row.thickness * share * step;
                }
            }
        }
    }
}

/// Parameters of a place on a side of a face.
pub(super) fn on_side(side: u32, along: f64) -> (f64, f64) {
    match side {
        0 => (along, 0.0),
        1 => (1.0, along),
        2 => (1.0 - along, 1.0),
        _ => (0.0, 1.0 - along),
    }
}

/// What filling a row of samples takes.
struct Row<'a> {
    surface: &'a LimitSurface,
    crust: &'a Crust,
    scheme: Scheme,
    thickness: f64,
    n: usize,
    /// Crust weight of every step.
    weights: Vec<f64>,
}

impl Row<'_> {
    fn fill(
        &self,
        face: usize,
        ranges: [std::ops::Range<usize>; 2],
        scratch: &mut Scratch,
        slot: impl Fn(usize, usize) -> usize,
        [outer, normals, inner]: [&mut [DVec3]; 3],
    ) {
        let [a, b, c, d] = self.crust.corners(self.surface, face);
        let cage = self.surface.mesh().cage();
        let [ta, tb, tc, td] = self.surface.mesh().corners(face).map(|v| cage.share(v));
        let step = 1.0 / self.n as f64;
        self.surface
            .sweep(face, self.n, ranges, scratch, |i, j0, row| {
                let w = self.weights[i];
                let low = a + w * (b - a);
                let rise = d + w * (c - d) - low;
                let near = ta + w * (tb - ta);
                let gain = td + w * (tc - td) - near;
                for (k, &[x, y, z, nx, ny, nz]) in row.iter().enumerate() {
                    let j = j0 + k;
                    let at = slot(i, j);
                    let (p, cross) = (DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
                    let (u, v) = (i as f64 * step, j as f64 * step);
                    let normal = self.surface.unit_normal(face, u, v, cross);
                    outer[at] = p;
                    normals[at] = normal;
                    inner[at] = p - match self.scheme {
                        Scheme::Crust => low + self.weights[j] * rise,
                        Scheme::Direct => {
                            let share = near + self.weights[j] * gain;
                            self.thickness * share * normal
                        }
                    };
                }
            });
    }
}
