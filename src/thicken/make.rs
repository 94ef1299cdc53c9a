//! Grids and cuts, tried until the solid cuts itself nowhere and misses nothing.

use std::cmp::Ordering;
use std::time::Instant;

use crate::dual_contour::{self, Contour, Grid, GridError, Numbers};
use crate::field::Missing;
use crate::mesh::{Bounds, TriMesh, cleared, self_intersections};
use crate::settings::progress::{Progress, Stop, Stopped};

use super::measure::{deviation, missing};
use super::patch::Patch;
use super::solid::ThickSolid;
use super::{Settings, ThickenError, Thickened, Way, collar, cut, sharpen};

/// Heights at which the contour is cut, over the thickness, in the order tried.
const LEVELS: [f64; 5] = [0.4, 0.47, 0.33, 0.55, 0.26];

/// Grids in the order tried: cell, over the one asked for, and shifts in cells.
const GRIDS: [(f64, &[f64]); 5] = [
    (1.0, &[0.0, 0.29, 0.61]),
    (0.6, &[0.0]),
    (0.36, &[0.0]),
    (0.2, &[0.0]),
    (0.12, &[0.0]),
];

/// Cells finer than this, over the one asked for, find what is missing; they do
/// not help where none could be joined.
const FINEST_JOIN: f64 = 0.6;

/// Times that a solid is cleared again of what rounding brought in.
const CLEARINGS: usize = 4;

/// A contour of more triangles than this is not tried again with finer cells.
const MOST_REFINED: usize = 1_000_000;

/// What all tries share.
pub(super) struct Maker<'a> {
    pub patch: &'a Patch,
    pub settings: &'a Settings,
    pub numbers: Numbers,
    pub progress: &'a Progress<'a>,
    pub stop: &'a Stop,
}

/// What was tried.
#[derive(Default)]
struct Tried {
    best: Option<Thickened>,
    /// The last contour, with its cell.
    whole: Option<(f64, Contour)>,
    attempts: usize,
    join_seconds: f64,
}

impl Tried {
    fn offer(&mut self, solid: Thickened) {
        let faults = |t: &Thickened| t.self_intersections + t.bad_edges;
        let is_better = |best: &Thickened| match faults(&solid).cmp(&faults(best)) {
            Ordering::Equal => solid.missing.is_better_than(&best.missing),
            order => order.is_lt(),
        };
        if self.best.as_ref().is_none_or(is_better) {
            self.best = Some(solid);
        }
    }

    fn is_done(&self) -> bool {
        self.best
            .as_ref()
            .is_some_and(|best| best.is_sound() && best.missing.is_none())
    }
}

impl Maker<'_> {
    /// The first solid that cuts itself nowhere and misses nothing, or the one
    /// that misses least.
    ///
    /// A joined solid keeps the patch as it is. Where all those of one cell cut
    /// themselves, the best of them is cleared of that; where none could be
    /// joined at any cell, the contour is taken whole. Neither cuts itself.
    pub fn make(&self) -> Result<Thickened, ThickenError> {
        let mut tried = Tried::default();
        for (finer, shifts) in GRIDS {
            let cell = finer * self.settings.cell;
            for shift in shifts {
                tracing::debug!(cell, shift, "contour tried");
                match self.grid(cell, shift * cell) {
                    Ok(grid) => self.contour(&grid, &mut tried)?,
                    Err(error) if tried.whole.is_none() => return Err(error.into()),
                    Err(_) => return self.finish(tried),
                }
                if tried.is_done() {
                    return self.finish(tried);
                }
            }
            if let Some(cutting) = tried.best.as_ref().filter(|best| !best.is_sound())
                && let Some(cleared) = self.clear(cutting)
            {
                tried.offer(cleared);
            }
            let large = |(_, c): &(f64, Contour)| c.mesh.triangles.len() > MOST_REFINED;
            let sound = tried.best.as_ref().is_some_and(Thickened::is_sound);
            let hopeless = finer <= FINEST_JOIN && !sound;
            if tried.is_done() || hopeless || tried.whole.as_ref().is_some_and(large) {
                break;
            }
        }
        self.finish(tried)
    }

    fn finish(&self, tried: Tried) -> Result<Thickened, ThickenError> {
        let Tried {
            best,
            whole,
            attempts,
            join_seconds,
        } = tried;
        let solid = match (best, whole) {
            (Some(best), _) if best.is_sound() => best,
            (_, Some((cell, contour))) if !contour.mesh.triangles.is_empty() => {
                let Contour { mesh, work } = contour;
                let measured = self.measure(&mesh, 0, cell);
                Thickened {
                    mesh,
                    way: Way::Contoured,
                    patch_triangles: 0,
                    ..self.thickened(measured, cell, work)
                }
            }
            _ => {
                let cell = self.settings.cell;
                return Err(ThickenError::Unresolved { cell });
            }
        };
        Ok(Thickened {
            attempts,
            join_seconds,
            ..solid
        })
    }

    /// Contours on a grid, and cuts and joins until one does.
    fn contour(&self, grid: &Grid, tried: &mut Tried) -> Result<(), Stopped> {
        let cell = grid.cell();
        let solid = ThickSolid::new(self.patch, self.settings.thickness, cell);
        let how = dual_contour::Settings {
            tolerance: self.settings.tolerance,
            filters: self.settings.filters,
        };
        let contour = dual_contour::contour(&solid, grid, &how, self.progress, self.stop)?;
        (self.progress)("join", 0, 0);
        let distances = cut::distances(self.patch, &contour.mesh);
        for share in LEVELS {
            self.stop.heed()?;
            let begin = Instant::now();
            tried.attempts += 1;
            let joined = self.join(&contour.mesh, &distances, share * self.settings.thickness);
            tried.join_seconds += begin.elapsed().as_secs_f64();
            if let Some((mesh, pairs, bad_edges)) = joined {
                let mut solid = self.joined(mesh, pairs, cell, contour.work);
                solid.bad_edges = bad_edges;
                tried.offer(solid);
            }
            // Of a closed patch another cut would change nothing.
            if tried.is_done() || self.patch.rim.loops.is_empty() {
                break;
            }
        }
        tried.whole = Some((cell, contour));
        Ok(())
    }

    /// A grid for both shells, and for the nodes within reach of either side.
    fn grid(&self, cell: f64, shift: f64) -> Result<Grid, GridError> {
        let Settings {
            thickness,
            memory_limit,
            ..
        } = *self.settings;
        let area = 2.0 * self.patch.mesh.area();
        let volume = area * (thickness + cell);
        let bounds = self.patch.mesh.bounds().grown(thickness);
        let bounds = Bounds {
            min: bounds.min - shift,
            max: bounds.max,
        };
        Grid::within_filled(&bounds, area, volume, cell, self.numbers, memory_limit)
    }

    /// The patch, what is left of the contour, and the collar between; with pairs
    /// of triangles that cut each other, and edges without two triangles or
    /// triangles without area. None if the cut does not follow the boundary.
    fn join(
        &self,
        contour: &TriMesh,
        distances: &[f64],
        level: f64,
    ) -> Option<(TriMesh, usize, usize)> {
        let patch = self.patch;
        let mut cut = cut::cut(contour, distances, level);
        let places = collar::settle(patch, &mut cut, level, self.numbers);
        let first = patch.mesh.positions.len() as u32;
        let collar = collar::join(patch, &cut, &places, first)?;
        let mut mesh = patch.mesh.clone();
        mesh.positions.extend(&cut.mesh.positions);
        let far = cut.mesh.triangles.iter().map(|t| t.map(|v| v + first));
        mesh.triangles.extend(far);
        mesh.triangles.extend(collar);
        let pairs = self_intersections(&mesh).len();
        let bad = bad_edges(&mesh);
        Some((mesh, pairs, bad))
    }

    fn joined(
        &self,
        mut mesh: TriMesh,
        pairs: usize,
        cell: f64,
        work: dual_contour::Work,
    ) -> Thickened {
        let begin = Instant::now();
        let sharpened = if pairs == 0 {
            let thickness = self.settings.thickness;
            sharpen::sharpen(self.patch, &mut mesh, thickness, cell, self.numbers)
        } else {
            0
        };
        let sharpen_seconds = begin.elapsed().as_secs_f64();
        let own = self.patch.mesh.triangles.len();
        let measured = self.measure(&mesh, own, cell);
        Thickened {
            mesh,
            way: Way::Joined,
            patch_triangles: own,
            self_intersections: pairs,
            sharpened,
            sharpen_seconds,
            ..self.thickened(measured, cell, work)
        }
    }

    /// A joined solid without what of its surface lies inside it. None if that
    /// cannot be told, or rounding lets triangles cut each other again.
    fn clear(&self, cutting: &Thickened) -> Option<Thickened> {
        if cutting.bad_edges > 0 {
            return None;
        }
        let mut mesh = cutting.mesh.clone();
        let mut sources: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        // Vertices of the seams are rounded, which may let needles cut others.
        for _ in 0..CLEARINGS {
            let (less, pieces_of) = cleared(&mesh).ok()?;
            sources = pieces_of.iter().map(|&t| sources[t as usize]).collect();
            mesh = less;
            for p in &mut mesh.positions {
                *p = self.numbers.round_point(*p);
            }
            if self_intersections(&mesh).is_empty() {
                break;
            }
        }
        let own = self.patch.mesh.triangles.len();
        // The patch first, as in other solids.
        let is_own = |t: usize| (sources[t] as usize) < own;
        let (mut order, others): (Vec<usize>, Vec<usize>) =
            (0..mesh.triangles.len()).partition(|&t| is_own(t));
        let patch_triangles = order.len();
        order.extend(others);
        mesh.triangles = order.into_iter().map(|t| mesh.triangles[t]).collect();
        let measured = self.measure(&mesh, patch_triangles, cutting.cell);
        Some(Thickened {
            way: Way::Cleared,
            patch_triangles,
            self_intersections: self_intersections(&mesh).len(),
            bad_edges: bad_edges(&mesh),
            mesh,
            ..self.thickened(measured, cutting.cell, cutting.work)
        })
    }

    fn measure(&self, mesh: &TriMesh, own: usize, cell: f64) -> Measured {
        let thickness = self.settings.thickness;
        Measured {
            deviation: deviation(self.patch, &mesh.triangles[own..], mesh, thickness),
            missing: missing(self.patch, mesh, thickness, cell),
        }
    }

    /// What is known of a solid besides its mesh.
    fn thickened(&self, measured: Measured, cell: f64, work: dual_contour::Work) -> Thickened {
        Thickened {
            mesh: TriMesh::default(),
            way: Way::Joined,
            patch_triangles: 0,
            boundaries: self.patch.rim.loops.len(),
            repairs: Vec::new(),
            self_intersections: 0,
            bad_edges: 0,
            cell,
            deviation: measured.deviation,
            missing: measured.missing,
            attempts: 0,
            sharpened: 0,
            field_seconds: 0.0,
            join_seconds: 0.0,
            sharpen_seconds: 0.0,
            work,
        }
    }
}

struct Measured {
    deviation: dual_contour::Deviation,
    missing: Missing,
}

/// Edges without two triangles that run them both ways, and triangles without
/// area, which the search for pairs passes over.
fn bad_edges(mesh: &TriMesh) -> usize {
    let census = mesh.edges().census();
    let flat = mesh.faces().filter(|&f| mesh.triangle_area(f) == 0.0);
    census.open + census.misoriented + census.balanced + census.unbalanced + flat.count()
}
