//! The part: a closed, outward-oriented triangle mesh whose coping faces are tagged.
//!
//! [`TriMesh`] is plain data and promises nothing. [`Part`] is what the
//! extraction works on; its constructor [`Part::new`] makes every check once,
//! so that no later stage has to.

mod checks;
mod edges;
mod error;
mod frame;
mod intersect;
mod measure;
mod mend;
pub(crate) mod polygon;
pub(crate) mod samples;
pub mod sets;
mod shells;
mod simplify;
mod unite;
mod weld;

use glam::DVec3;

pub use checks::PartOptions;
pub(crate) use checks::check_numbers;
pub use edges::{EdgeCensus, EdgeUse, EdgeUses};
pub use error::{EdgeReport, PartError, PartWarning};
pub use frame::Frame;
pub use intersect::{clash, self_intersections};
pub use measure::{Bounds, angle, is_thin, smallest_angle};
pub(crate) use mend::close_t_junctions;
pub use mend::{Mended, Repair, mend};
pub(crate) use shells::turn_by_nesting;
pub use shells::{Shell, closed_shells};
pub use simplify::{Simplified, Simplify, simplify, simplify_beside};
pub use unite::{UniteError, cleared, without};
pub use weld::{Weld, weld_exact, weld_within};

/// Triangle of the part, by its place among the part's triangles (0-based).
///
/// For files of triangles alone this is the place in the input file; polygons
/// of a file give several triangles each, in file order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceId(pub u32);

impl FaceId {
    /// The index as `usize`, for slices.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Plain indexed triangles: no promise about closedness or orientation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions in part units.
    pub positions: Vec<DVec3>,
    /// Three indices into `positions` a triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A part ready for extraction.
///
/// Invariants, held by [`Part::new`]: indices in range, coordinates finite,
/// `coping.len() == mesh.triangles.len()`, at least one wall triangle of
/// positive area, every vertex used, outward oriented (positive volume) when
/// closed.
///
/// Triangles of zero area may occur; they keep their place so that indices in
/// tag files stay right.
#[derive(Clone, Debug)]
pub struct Part {
    mesh: TriMesh,
    coping: Vec<bool>,
    closed: bool,
}

impl Part {
    /// The triangles.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// One flag a triangle: true for coping, false for wall.
    pub fn coping(&self) -> &[bool] {
        &self.coping
    }

    /// Corner positions of a triangle.
    pub fn corners(&self, face: FaceId) -> [DVec3; 3] {
        self.mesh.triangles[face.index()].map(|v| self.mesh.positions[v as usize])
    }

    /// Whether every edge is run equally often in both directions: each
    /// manifold edge once each way, a non-manifold edge in balanced pairs.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// Number of triangles, coping and wall together.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Number of coping triangles.
    pub fn coping_count(&self) -> usize {
        self.coping.iter().filter(|&&flag| flag).count()
    }

    /// Box around the vertices in use.
    pub fn bounds(&self) -> Bounds {
        self.mesh.bounds()
    }

    /// Enclosed volume, cubic part units; an estimate when the part is open.
    pub fn volume(&self) -> f64 {
        self.mesh.volume()
    }

    /// Area of all triangles, square part units.
    pub fn area(&self) -> f64 {
        self.mesh.area()
    }
}
