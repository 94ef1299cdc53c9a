//! Facets of a file collected as triangles.

use glam::DVec3;

use super::loaded::{FacetPlaces, RawMesh, ReadWarning};
use crate::io::error::{Located, Place, Problem};
use crate::io::names::FacetNames;
use crate::mesh::TriMesh;
use crate::mesh::polygon::{MOST_CORNERS, triangulate};

/// Collects the facets of a file as triangles.
#[derive(Default)]
pub(crate) struct FacetSink {
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    facets: u32,
    forced: usize,
    first_forced: Option<Place>,
    /// Tests that full searches have spent.
    tests: u64,
}

impl FacetSink {
    pub(crate) fn with_capacity(facets: usize) -> FacetSink {
        FacetSink {
            triangles: Vec::with_capacity(facets),
            source: Vec::with_capacity(facets),
            ..FacetSink::default()
        }
    }

    /// One more facet; `corners` are three or more indices into `positions`, in range.
    pub(crate) fn push(
        &mut self,
        corners: &[u32],
        positions: &[DVec3],
        place: Place,
    ) -> Result<(), Located> {
        if self.facets == u32::MAX || self.triangles.len() + corners.len() >= u32::MAX as usize {
            return Err((place, Problem::TooMany("triangles")));
        }
        if let &[a, b, c] = corners {
            self.triangles.push([a, b, c]);
        } else if corners.len() > MOST_CORNERS {
            let corners = corners.len();
            return Err((place, Problem::ManyCorners { corners }));
        } else if !triangulate(corners, positions, &mut self.triangles, &mut self.tests) {
            self.forced += 1;
            self.first_forced.get_or_insert(place);
        }
        self.source.resize(self.triangles.len(), self.facets);
        self.facets += 1;
        Ok(())
    }

    pub(crate) fn facet_count(&self) -> u32 {
        self.facets
    }

    pub(crate) fn finish(
        self,
        positions: Vec<DVec3>,
        names: FacetNames,
        places: FacetPlaces,
        mut warnings: Vec<ReadWarning>,
    ) -> RawMesh {
        if let Some(place) = self.first_forced {
            warnings.push(ReadWarning {
                code: "folded_polygon",
                place,
                message: format!(
                    "{} polygons cross themselves or are not nearly flat; their triangles may overlap",
                    self.forced
                ),
            });
        }
        RawMesh {
            mesh: TriMesh {
                positions,
                triangles: self.triangles,
            },
            source: self.source,
            names,
            places,
            warnings,
            values: Default::default(),
            unit: None,
        }
    }
}
