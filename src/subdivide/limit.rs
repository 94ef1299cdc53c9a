//! The limit surface of a quadrilateral mesh, at any parameters of any face.
//!
//! A face is one bicubic patch where it is regular. Elsewhere it is four
//! quarters, each a patch of the mesh refined once more, or, beside an
//! extraordinary vertex, a [`Ring`]'s patches without end. So a face may have
//! extraordinary vertices at several corners, and its parameters stay its own.
//!
//! An infinitely sharp edge is a boundary to the faces on either side. A finite
//! sharpness counts for nothing here: it must have decayed, step by step.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::corner::Corners;
use super::error::CageError;
use super::patch::{Jet, Patch, Scratch};
use super::refine::{Boundary, Quads, refine};
use super::ring::Ring;
use super::sharp::{Sector, Sectors};

/// Steps of each ring that are kept; the deeper ones are taken when asked for.
/// Samples `1 / 2047` apart need no deeper one.
const KEPT: usize = 10;

/// Steps after which a place is taken for the vertex itself: 2^-500 of a face
/// away from it.
const DEEPEST: usize = 500;

/// Most samples along a side of a face.
pub const MOST_SAMPLES: usize = 1 << KEPT;

/// The limit surface.
#[derive(Clone, Debug)]
pub struct LimitSurface {
    mesh: Quads,
    boundary: Boundary,
    sectors: Sectors,
    corners: Corners,
    cells: Vec<Cell>,
    patches: Vec<Patch>,
    rings: Vec<Origin>,
}

/// A face.
#[derive(Clone, Copy, Debug)]
enum Cell {
    Regular,
    Split([Quarter; 4]),
}

/// A quarter of a face, at one of its corners.
#[derive(Clone, Copy, Debug)]
enum Quarter {
    /// Index of its patch.
    Regular(u32),
    /// Its patches from `first` on, three a step.
    Beside { ring: u32, sector: u32, first: u32 },
}

/// Where a ring's kept steps end.
#[derive(Clone, Debug)]
struct Origin {
    limit: DVec3,
    deepest: Ring,
}

impl LimitSurface {
    /// The limit surface of a mesh.
    ///
    /// # Errors
    ///
    /// [`CageError::TooLarge`].
    pub fn new(mesh: Quads, boundary: Boundary) -> Result<LimitSurface, CageError> {
        let sectors = Sectors::new(mesh.cage(), boundary);
        let corners = Corners::new(&mesh, &sectors, boundary);
        let mut surface = LimitSurface {
            cells: vec![Cell::Regular; mesh.cage().face_count()],
            mesh,
            boundary,
            sectors,
            corners,
            patches: Vec::new(),
            rings: Vec::new(),
        };
        surface.split()?;
        Ok(surface)
    }

    /// Lays out the faces that have an extraordinary vertex.
    fn split(&mut self) -> Result<(), CageError> {
        let cage = self.mesh.cage();
        let sectors = self.sectors.list.iter().copied();
        let sectors: Vec<Sector> = sectors.filter(|sector| !sector.is_regular()).collect();
        if sectors.is_empty() {
            return Ok(());
        }
        let fine = refine(cage, self.boundary)?;
        // Every ring's patches, in parallel; then numbered in order.
        let rings: Vec<(Origin, Vec<[Patch; 3]>)> = sectors
            .par_iter()
            .map(|sector| self.unroll(&fine, sector))
            .collect();
        let mut quarters: Vec<Option<[Quarter; 4]>> = vec![None; self.cells.len()];
        let blank = [Quarter::Regular(u32::MAX); 4];
        for (sector, (origin, patches)) in sectors.iter().zip(rings) {
            let ring = self.rings.len() as u32;
            self.rings.push(origin);
            let mut steps = patches.into_iter();
            for (sector, h) in cage.sector(sector.first).enumerate() {
                let first = self.patches.len() as u32;
                self.patches.extend(steps.by_ref().take(KEPT).flatten());
                let face = quarters[cage.face_of(h)].get_or_insert(blank);
                face[(h % 4) as usize] = Quarter::Beside {
                    ring,
                    sector: sector as u32,
                    first,
                };
            }
        }
        for (face, quarters) in quarters.into_iter().enumerate() {
            let Some(mut quarters) = quarters else {
                continue;
            };
            for (k, quarter) in quarters.iter_mut().enumerate() {
                if let Quarter::Regular(index) = quarter {
                    *index = self.patches.len() as u32;
                    let [u0, v0] = quarter_place(k);
                    let mut patch = regular(&fine, 4 * face + k);
                    (patch.u0, patch.v0, patch.size) = (u0, v0, 0.5);
                    self.patches.push(patch);
                }
            }
            self.cells[face] = Cell::Split(quarters);
        }
        Ok(())
    }

    /// Kept steps in a sector: for each of its faces, [`KEPT`] times three patches.
    fn unroll(&self, fine: &Quads, sector: &Sector) -> (Origin, Vec<[Patch; 3]>) {
        let cage = self.mesh.cage();
        let (mut ring, limit) = Ring::around(fine, sector);
        let sectors: Vec<u32> = cage.sector(sector.first).collect();
        let mut patches: Vec<Vec<[Patch; 3]>> = vec![Vec::with_capacity(KEPT); sectors.len()];
        for step in 1..=KEPT {
            let stepped = ring.step();
            for (sector, (&h, out)) in sectors.iter().zip(&mut patches).enumerate() {
                out.push(stepped.patches(sector, (h % 4) as usize, spacing(step), limit));
            }
            ring = stepped.inner();
        }
        let origin = Origin {
            limit,
            deepest: ring,
        };
        (origin, patches.into_iter().flatten().collect())
    }

    /// The mesh whose surface this is.
    pub fn mesh(&self) -> &Quads {
        &self.mesh
    }

    /// Whether a vertex is regular on all sides of its creases.
    #[cfg(test)]
    pub(super) fn is_regular(&self, vertex: u32) -> bool {
        let cage = self.mesh.cage();
        let mut sectors = self.sectors.list.iter();
        sectors.all(|sector| cage.origin(sector.first) != vertex || sector.is_regular())
    }

    /// The boundary rule.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.cells.len()
    }

    /// Limit points of the control vertices, (2.2).
    pub fn limits(&self) -> &[DVec3] {
        &self.corners.limits
    }

    /// Unit normals at the control vertices, (2.3); where there is none, the
    /// average of neighbours, and zero where even those have none. On a crease
    /// the direction of [`LimitSurface::mitres`].
    pub fn normals(&self) -> &[DVec3] {
        &self.corners.normals
    }

    /// Unit normal at corner `k` of a face, that of its own side of a crease.
    pub fn corner_normal(&self, face: usize, k: usize) -> DVec3 {
        self.corners.sides[self.sectors.of[4 * face + k] as usize]
    }

    /// Steps from the control vertices' limit points that leave the surface by
    /// one, on all sides of a crease: elsewhere the normals.
    pub fn mitres(&self) -> &[DVec3] {
        &self.corners.mitres
    }

    /// Vertices whose normal is an average, ascending.
    pub fn averaged(&self) -> &[u32] {
        &self.corners.averaged
    }

    /// Vertices without any normal: no neighbour has one, or they cancel.
    pub fn without_normal(&self) -> &[u32] {
        &self.corners.missing
    }

    /// Faces with two or more extraordinary vertices.
    pub fn crowded_faces(&self) -> usize {
        let several = |cell: &&Cell| match cell {
            Cell::Regular => false,
            Cell::Split(quarters) => {
                let beside = |q: &&Quarter| matches!(q, Quarter::Beside { .. });
                quarters.iter().filter(beside).count() > 1
            }
        };
        self.cells.iter().filter(several).count()
    }

    /// Point and derivatives at parameters in [0, 1] of a face; others are
    /// clamped. For many places of one face, [`LimitSurface::face`] is faster.
    ///
    /// At an extraordinary vertex itself there are no derivatives by u and v:
    /// there they are zero. Beside one they are exact however near it.
    pub fn at(&self, face: usize, u: f64, v: f64) -> Jet {
        self.face(face).at(u, v)
    }

    /// One face, to be evaluated at many places.
    pub fn face(&self, face: usize) -> Face<'_> {
        let patch = match self.cells[face] {
            Cell::Regular => Some(regular(&self.mesh, face)),
            Cell::Split(_) => None,
        };
        Face {
            surface: self,
            face,
            patch,
        }
    }

    /// [`LimitSurface::at`] for a face with an extraordinary vertex.
    fn at_quarter(&self, quarters: &[Quarter; 4], u: f64, v: f64) -> Jet {
        let corner = match (u < 0.5, v < 0.5) {
            (true, true) => 0,
            (false, true) => 1,
            (false, false) => 2,
            (true, false) => 3,
        };
        match quarters[corner] {
            Quarter::Regular(patch) => self.patches[patch as usize].jet(u, v),
            Quarter::Beside {
                ring,
                sector,
                first,
            } => {
                // Exact: u and v are 1/2 or more where they are taken from 1.
                let [a, b] = match corner {
                    0 => [u, v],
                    1 => [v, 1.0 - u],
                    2 => [1.0 - u, 1.0 - v],
                    _ => [1.0 - v, u],
                };
                let which = |size: f64| match (a >= size, b >= size) {
                    (true, false) => 0,
                    (true, true) => 1,
                    _ => 2,
                };
                let reach = a.max(b);
                let mut step = 1;
                while spacing(step) > reach && step < DEEPEST {
                    step += 1;
                }
                if spacing(step) > reach {
                    let point = self.rings[ring as usize].limit;
                    return Jet {
                        point,
                        ..Jet::default()
                    };
                }
                let size = spacing(step);
                if step <= KEPT {
                    let patch = first as usize + 3 * (step - 1) + which(size);
                    return self.patches[patch].jet(u, v);
                }
                let origin = &self.rings[ring as usize];
                let mut ring = origin.deepest.step();
                for _ in KEPT + 1..step {
                    ring = ring.inner().step();
                }
                // In the corner's own axes, where tiny parameters keep their
                // digits; then turned to those of the face.
                let patches = ring.patches(sector as usize, 0, size, origin.limit);
                turned(patches[which(size)].jet(a, b), corner)
            }
        }
    }

    /// Outward unit normal; where the derivatives give none, a blend of those
    /// at the face's corners.
    pub fn unit_normal(&self, face: usize, u: f64, v: f64, cross: DVec3) -> DVec3 {
        let length = cross.length();
        if length > f64::MIN_POSITIVE.sqrt() {
            return cross / length;
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| self.corner_normal(face, k));
        a.lerp(b, u).lerp(d.lerp(c, u), v).normalize_or_zero()
    }

    /// Points and unscaled normals at samples `(i / n, j / n)` of a face, for i
    /// and j in the ranges; corners of the face may be left out.
    ///
    /// `put` gets i, the first j, and a row of point and normal.
    pub(super) fn sweep(
        &self,
        face: usize,
        n: usize,
        ranges: [Range<usize>; 2],
        scratch: &mut Scratch,
        mut put: impl FnMut(usize, usize, &[[f64; 6]]),
    ) {
        let mut part = |patch: &Patch, scratch: &mut Scratch| {
            let own = patch.samples(n);
            let common =
                [0, 1].map(|k| ranges[k].start.max(own[k].start)..ranges[k].end.min(own[k].end));
            patch.sweep(n, common, scratch, &mut put);
        };
        let Cell::Split(quarters) = &self.cells[face] else {
            part(&regular(&self.mesh, face), scratch);
            return;
        };
        for quarter in quarters {
            match *quarter {
                Quarter::Regular(patch) => part(&self.patches[patch as usize], scratch),
                Quarter::Beside { first, .. } => {
                    for step in 1..=KEPT {
                        let first = first as usize + 3 * (step - 1);
                        for patch in &self.patches[first..first + 3] {
                            part(patch, scratch);
                        }
                        // What is left holds the corner's sample alone.
                        if spacing(step) * (n as f64) < 1.0 {
                            break;
                        }
                    }
                }
            }
        }
    }
}

/// One face of a limit surface, see [`LimitSurface::face`].
#[derive(Clone, Debug)]
pub struct Face<'a> {
    surface: &'a LimitSurface,
    face: usize,
    /// Of a regular face.
    patch: Option<Patch>,
}

impl Face<'_> {
    /// As [`LimitSurface::at`].
    pub fn at(&self, u: f64, v: f64) -> Jet {
        let [u, v] = [u, v].map(|t| t.clamp(0.0, 1.0));
        match (&self.patch, &self.surface.cells[self.face]) {
            (Some(patch), _) => patch.jet(u, v),
            (None, Cell::Split(quarters)) => self.surface.at_quarter(quarters, u, v),
            (None, Cell::Regular) => regular(&self.surface.mesh, self.face).jet(u, v),
        }
    }
}

/// Spacing of a ring after some steps, in parameters of the face.
fn spacing(step: usize) -> f64 {
    0.5_f64.powi(1 + step as i32)
}

/// Lower corner of the quarter at a corner of a face.
fn quarter_place(corner: usize) -> [f64; 2] {
    [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]][corner]
}

/// From derivatives along the two sides that leave a corner to those by u and v.
fn turned(jet: Jet, corner: usize) -> Jet {
    let Jet {
        point,
        du: a,
        dv: b,
        duu: aa,
        duv: ab,
        dvv: bb,
    } = jet;
    let (du, dv, duu, duv, dvv) = match corner {
        0 => (a, b, aa, ab, bb),
        1 => (-b, a, bb, -ab, aa),
        2 => (-a, -b, aa, ab, bb),
        _ => (b, -a, bb, -ab, aa),
    };
    Jet {
        point,
        du,
        dv,
        duu,
        duv,
        dvv,
    }
}

/// The patch of a face without extraordinary vertices.
///
/// Over a cut, a phantom row mirrors the inner one: then the cut
/// is the cubic B-spline of its vertices, and a corner that
/// both phantom rows meet is where its vertex is.
fn regular(mesh: &Quads, face: usize) -> Patch {
    let cage = mesh.cage();
    let mut net = [[DVec3::ZERO; 4]; 4];
    let corner = [(1, 1), (2, 1), (2, 2), (1, 2)];
    let side = [
        [(1, 0), (2, 0)],
        [(3, 1), (3, 2)],
        [(2, 3), (1, 3)],
        [(0, 2), (0, 1)],
    ];
    let diagonal = [(0, 0), (3, 0), (3, 3), (0, 3)];
    let mut open = [false; 4];
    for k in 0..4 {
        let h = 4 * face as u32 + k as u32;
        let mut put = |(i, j): (usize, usize), vertex: u32| net[i][j] = cage.position(vertex);
        put(corner[k], cage.origin(h));
        let Some(twin) = cage.across(h) else {
            open[k] = true;
            continue;
        };
        let out = cage.next(twin);
        put(side[k][0], cage.end(out));
        put(side[k][1], cage.end(cage.next(out)));
        if let Some(over) = cage.across(out)
            && cage.across(4 * face as u32 + (k as u32 + 3) % 4).is_some()
        {
            put(diagonal[k], cage.origin(cage.prev(over)));
        }
    }
    for (k, edge, on, inside) in [(3, 0, 1, 2), (1, 3, 2, 1)] {
        if open[k] {
            net[edge] = std::array::from_fn(|j| 2.0 * net[on][j] - net[inside][j]);
        }
    }
    for (k, edge, on, inside) in [(0, 0, 1, 2), (2, 3, 2, 1)] {
        if open[k] {
            for row in &mut net {
                row[edge] = 2.0 * row[on] - row[inside];
            }
        }
    }
    Patch {
        net,
        origin: DVec3::ZERO,
        u0: 0.0,
        v0: 0.0,
        size: 1.0,
    }
}
