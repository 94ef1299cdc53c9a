//! Intersection-free dual contouring of a solid given by a function.
//!
//! After Liu and Wang, "Fast Intersection-free Offset Surface Generation from
//! Freeform Models with Triangular Meshes", sections IV to VI. Stage by stage:
//!
//! ```text
//! implicit, grid -> band -> edges -> cells -> faces -> polygon -> mend -> mesh
//! ```
//!
//! * [`Implicit`]: the solid; what the offset and the thickening bring along.
//! * [`Grid`]: planes, cells between them, and the numbers vertices may have.
//! * `block`: how nodes are numbered and kept.
//! * `band`: nodes near the surface, by the filters; `settle` where they err.
//! * `edges`: crossings of grid edges, with normals; `hybrid` finds them.
//! * `pattern`: how the surface passes through a cell.
//! * `cells`: a vertex for each loop of each cell (`vertex`, `qef`).
//! * `faces`: further vertices where chords stray.
//! * `polygon`: triangles around each crossed edge.
//! * `mend`: what still strays, split where that cuts nothing.
//!
//! # What is promised
//!
//! The mesh is closed, manifold and outward, and no two triangles meet but in
//! common vertices and edges. That rests on where the vertices are (strictly
//! inside their cells, faces and edges) and on exact predicates, not on how
//! good they are; mending tests each new triangle against all near it. Same
//! input, same bytes, on any number of threads.
//!
//! # What is not
//!
//! What lies between two nodes is not seen: pieces, gaps and tunnels thinner
//! than a cell may be missing or joined.

mod band;
mod block;
mod budget;
mod cells;
mod deviation;
mod edges;
mod faces;
mod grid;
mod hybrid;
mod implicit;
mod mend;
mod numbers;
mod pattern;
mod polygon;
mod qef;
mod settle;
#[cfg(test)]
mod tests;
mod vertex;

use std::time::Instant;

use serde::Serialize;

use crate::mesh::TriMesh;
use crate::settings::progress::{Progress, Stop, Stopped};
use band::Band;
use cells::Cells;
use edges::Edges;
use faces::Faces;

pub use band::{FilterCounts, Filters};
pub use budget::{GridError, smallest_cell};
pub use deviation::Deviation;
pub use edges::CrossingCounts;
pub use grid::{CellBox, Grid};
pub use hybrid::{Bracket, Found, hybrid};
pub use implicit::{Crossing, Implicit, Sample};
pub use mend::MendCounts;
pub use numbers::Numbers;
pub use polygon::RingCounts;

/// How to contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Chords that stray from the surface by more than this, part units, are
    /// split once. Infinite: never.
    pub tolerance: f64,
    /// Filters of the band.
    pub filters: Filters,
}

/// A contour and what it took.
#[derive(Clone, Debug)]
pub struct Contour {
    /// Closed, manifold, outward; empty if the surface misses every node.
    pub mesh: TriMesh,
    /// What it took.
    pub work: Work,
}

/// Seconds by stage and counts of work.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Work {
    /// Nodes each filter left.
    pub filters: FilterCounts,
    /// How crossings were found.
    pub crossings: CrossingCounts,
    /// Vertices in cells, on faces and on edges.
    pub vertices: [usize; 3],
    /// How rings were triangulated.
    pub rings: RingCounts,
    /// What was mended afterwards.
    pub mends: MendCounts,
    /// Closest-point queries in all.
    pub queries: u64,
    /// Building the band.
    pub band_seconds: f64,
    /// Crossings, vertices and triangles.
    pub contour_seconds: f64,
    /// Of these, triangles around the crossed edges: what Table VI of the
    /// paper times.
    pub ring_seconds: f64,
}

/// Contours the surface of a solid.
///
/// # Errors
///
/// [`Stopped`], if it was asked to.
pub fn contour(
    solid: &impl Implicit,
    grid: &Grid,
    settings: &Settings,
    progress: &Progress,
    stop: &Stop,
) -> Result<Contour, Stopped> {
    let start = Instant::now();
    let tick = |done, total| progress("band", done, total);
    let band = Band::build(solid, grid, settings.filters, tick, stop)?;
    let filters = band.counts;
    let band_seconds = start.elapsed().as_secs_f64();

    progress("edges", 0, 0);
    let edges = Edges::solve(solid, grid, band);
    stop.heed()?;
    progress("cells", 0, 0);
    let cells = Cells::place(solid, grid, &edges);
    let in_cells = cells.vertex_count();
    stop.heed()?;
    progress("faces", 0, 0);
    let faces = Faces::place(
        solid,
        grid,
        &edges,
        &cells,
        settings.tolerance,
        in_cells as u32,
    );
    let on_faces = faces.vertex_count();
    stop.heed()?;
    progress("mesh", 0, 0);
    let before_rings = Instant::now();
    let (triangles, on_edges, rings) = polygon::triangulate(
        solid,
        grid,
        &edges,
        &cells,
        &faces,
        settings.tolerance,
        (in_cells + on_faces) as u32,
    );
    let ring_seconds = before_rings.elapsed().as_secs_f64();
    let crossings = edges.counts;
    let asked = filters.distances + crossings.queries + cells.queries + faces.queries;
    let counts = [in_cells, on_faces, on_edges.len()];
    drop(edges);
    let total: usize = counts.iter().sum();
    let mut vertices = Vec::with_capacity(total + total / 64);
    vertices.extend(cells.vertices());
    drop(cells);
    vertices.extend(faces.vertices());
    drop(faces);
    vertices.extend(on_edges);

    stop.heed()?;
    progress("mend", 0, 0);
    let mut triangles = triangles;
    let mends = mend::mend(
        solid,
        grid,
        settings.tolerance,
        &mut vertices,
        &mut triangles,
    );
    let positions = vertices.into_iter().map(|v| v.position).collect();
    stop.heed()?;
    tracing::debug!(
        cell = grid.cell(),
        in_cells,
        on_faces,
        on_edges = counts[2],
        queries = asked,
        triangles = triangles.len(),
        "contoured"
    );
    Ok(Contour {
        mesh: TriMesh {
            positions,
            triangles,
        },
        work: Work {
            filters,
            crossings,
            vertices: counts,
            rings,
            mends,
            queries: asked + rings.queries + mends.queries,
            band_seconds,
            contour_seconds: start.elapsed().as_secs_f64() - band_seconds,
            ring_seconds,
        },
    })
}
