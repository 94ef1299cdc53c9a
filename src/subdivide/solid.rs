//! Outer and inner surface as one closed mesh.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::{Laid, Samples};
use crate::mesh::{FaceId, TriMesh};

/// A hollow solid: outer shell, then inner shell turned over, then the rims.
#[derive(Clone, Debug)]
pub struct Hollow {
    /// Outer vertices, then the inner one of each in the same order.
    pub mesh: TriMesh,
    /// Triangles of one shell; the second shell follows the first.
    pub shell: usize,
}

impl Hollow {
    /// Joins the shells. Where the surface has a rim, straight lines from outer to
    /// inner samples close it.
    pub(super) fn new(laid: &Laid) -> Hollow {
        let Laid {
            samples,
            triangles: outer,
            rims,
            ..
        } = laid;
        let below = samples.outer.len() as u32;
        let mut triangles = outer.clone();
        triangles.par_extend(
            outer
                .par_iter()
                .map(|&[a, b, c]| [c + below, b + below, a + below]),
        );
        for &[a, b] in rims {
            triangles.push([b, a, a + below]);
            triangles.push([b, a + below, b + below]);
        }
        let mut positions = samples.outer.clone();
        positions.extend_from_slice(&samples.inner);
        Hollow {
            mesh: TriMesh {
                positions,
                triangles,
            },
            shell: outer.len(),
        }
    }

    /// Unit normals of both shells at their vertices, out of the solid: those of
    /// the limit surface, turned over for the inner shell. That is its own where
    /// it is parallel, as everywhere by the direct scheme.
    pub fn normals(samples: &Samples) -> Vec<DVec3> {
        let outer = samples.normals.iter().copied();
        let inner = samples.normals.iter().map(|&n| -n);
        outer.chain(inner).collect()
    }

    /// Triangles of the inner shell that look the wrong way, ascending: whose
    /// area, seen along the outer normals of their corners, is negative.
    pub fn folded(&self, samples: &Samples) -> Vec<FaceId> {
        let outer = &self.mesh.triangles[..self.shell];
        folded(outer, samples)
            .into_iter()
            .map(|triangle| FaceId((self.shell + triangle) as u32))
            .collect()
    }
}

/// Triangles of an inner surface that look the wrong way; `triangles` turn as
/// those of the outer surface.
pub fn folded(triangles: &[[u32; 3]], samples: &Samples) -> Vec<usize> {
    let wrong = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|v| samples.inner[v as usize]);
        let [l, m, n] = corners.map(|v| samples.normals[v as usize]);
        (b - a).cross(c - a).dot(l + m + n) < 0.0
    };
    let found = triangles.par_iter().enumerate().filter(|(_, t)| wrong(t));
    found.map(|(triangle, _)| triangle).collect()
}
