//! The part: a closed, outward-oriented triangle mesh whose coping faces are tagged.

use glam::DVec3;

/// Triangle of the part, by its place in the input file (0-based).
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
/// Invariants, held by `Part::new`: indices in range, coordinates finite,
/// `coping.len() == mesh.triangles.len()`, at least one wall triangle of
/// positive area, outward oriented (positive volume) when closed.
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

    /// Whether every edge is shared by two triangles that run it in opposite directions.
    pub fn is_closed(&self) -> bool {
        self.closed
    }
}
