//! What readers hand up, and what comes of it.

use crate::io::checksum::geometry_checksum;
use crate::io::error::Place;
use crate::io::names::{FacetNames, NameSet};
use crate::io::unit::Unit;
use crate::mesh::{FaceId, PartError, TriMesh, check_numbers};

/// A mesh as its file states it, triangulated but otherwise unchecked for
/// closedness and the like; see [`crate::mesh::Part::new`] for that.
#[derive(Clone, Debug)]
pub struct LoadedMesh {
    /// The triangles, in the order of the file's facets.
    pub mesh: TriMesh,
    /// Facet of the file that each triangle comes from, ascending. Facets
    /// count from 0 in file order: `f` lines of an OBJ, facets of an STL,
    /// faces of a PLY or OFF. Coping indices mean facets.
    pub source: Vec<u32>,
    /// Names of each facet.
    pub names: FacetNames,
    /// What was odd but could be read.
    pub warnings: Vec<ReadWarning>,
    /// What the file says of vertices besides their place.
    pub values: PlyValues,
    /// SHA-256 of the file's bytes, in hexadecimal; empty where there is no file.
    pub sha256: String,
    /// Unit of the coordinates, where the format says it.
    pub unit: Option<Unit>,
    pub(super) places: FacetPlaces,
    /// [`geometry_checksum`] of the mesh as read, once it has been changed.
    pub(super) as_read: Option<String>,
}

impl LoadedMesh {
    /// A mesh from memory: every triangle a facet of its own, without names.
    ///
    /// # Errors
    ///
    /// [`PartError`] for no triangles, corners that do not exist and
    /// coordinates that are no numbers.
    pub fn of(mesh: TriMesh) -> Result<LoadedMesh, PartError> {
        check_numbers(&mesh)?;
        let facets = mesh.triangles.len();
        Ok(LoadedMesh {
            mesh,
            source: (0..facets as u32).collect(),
            names: FacetNames::unnamed(facets),
            warnings: Vec::new(),
            values: PlyValues::default(),
            sha256: String::new(),
            unit: None,
            places: FacetPlaces::None,
            as_read: None,
        })
    }

    /// Checksum of the mesh as it was read; see [`geometry_checksum`].
    pub fn geometry(&self) -> String {
        let now = || geometry_checksum(&self.mesh);
        self.as_read.clone().unwrap_or_else(now)
    }

    /// Number of facets in the file.
    pub fn facet_count(&self) -> usize {
        self.names.len()
    }

    /// Names of the facet that a triangle comes from.
    pub fn names_of(&self, triangle: FaceId) -> &NameSet {
        self.names.of(self.source[triangle.index()])
    }

    /// Where the file states the facet that a triangle comes from.
    pub fn place_of(&self, triangle: FaceId) -> Place {
        match (self.source.get(triangle.index()), &self.places) {
            (Some(&facet), FacetPlaces::Lines(lines)) => Place::Line(lines[facet as usize]),
            (Some(&facet), FacetPlaces::Bytes(bytes)) => Place::Byte(bytes[facet as usize]),
            (Some(&facet), FacetPlaces::Strided { start, stride }) => {
                Place::Byte(start + stride * u64::from(facet))
            }
            (Some(_), FacetPlaces::None) | (None, _) => Place::Whole,
        }
    }
}

/// Numbers that a file gives for its vertices, as many as vertices, or none
/// where the file has no such property, and for its edges. As read, so of any
/// value.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlyValues {
    /// Property `thickness` of a PLY, or nodal thickness of a deck.
    pub thickness: Vec<f64>,
    /// Property `radius`.
    pub radius: Vec<f64>,
    /// Property `kind`; see [`crate::io::write::vertex_code`].
    pub kind: Vec<f64>,
    /// Property `kind` of edges, by their vertices, which exist.
    pub edges: Vec<([u32; 2], f64)>,
}

/// Oddity met while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadWarning {
    /// Stable code for reports.
    pub code: &'static str,
    /// Where it occurred first.
    pub place: Place,
    /// What was met and what was done.
    pub message: String,
}

/// Where facets stand in their file.
#[derive(Clone, Debug)]
pub(crate) enum FacetPlaces {
    Lines(Vec<u64>),
    Bytes(Vec<u64>),
    Strided {
        start: u64,
        stride: u64,
    },
    /// They stand in no file that the user has.
    None,
}

/// What the readers hand up.
pub(crate) struct RawMesh {
    pub(crate) mesh: TriMesh,
    pub(crate) source: Vec<u32>,
    pub(crate) names: FacetNames,
    pub(crate) places: FacetPlaces,
    pub(crate) warnings: Vec<ReadWarning>,
    pub(crate) values: PlyValues,
    pub(crate) unit: Option<Unit>,
}
