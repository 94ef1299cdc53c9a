//! Sheets, seams and borders.

use glam::DVec3;
use serde::Serialize;

use crate::assembly::mesh::RawMesh;
use crate::field::Field;
use crate::mesh::midsurface::MidSurface;

/// An edge with one triangle and no border there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crack {
    /// Middle of the edge.
    pub at: DVec3,
    /// Its length.
    pub length: f64,
}

/// Sheets as nodes, seams as edges.
#[derive(Clone, Debug, Default)]
pub struct SheetGraph {}

/// Builds the result from the raw mesh.
pub fn build(_mesh: &RawMesh, _field: &Field) -> (MidSurface, SheetGraph, Vec<Crack>) {
    Default::default()
}
