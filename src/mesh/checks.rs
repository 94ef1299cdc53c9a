//! From a plain mesh and coping flags to a part: all checks, in order.

use glam::DVec3;

use super::edges::{EdgeCensus, EdgeKind, EdgeUses};
use super::error::{PartError, PartWarning};
use super::mend::{self, Mended, closing_weld, report};
use super::{Bounds, FaceId, Part, TriMesh};

/// Diagonals outside this range overflow or vanish in products of four lengths.
const USABLE_DIAGONAL: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// Beyond this distance from the origin, in diagonals, f64 keeps fewer than
/// ten digits of the part's size: fewer than the results promise.
const FAR_RATIO: f64 = 1e6;

/// Steps between the input's numbers, in diagonals, from which on they show:
/// a thousandth of a wall that is a thousandth of the part thick.
const COARSE_STEP: f64 = 1e-6;

/// A triangle lower than this share of its longest edge has no area.
const FLATNESS: f64 = 1e-13;

/// A closed mesh with less volume than this, over area times diagonal,
/// encloses nothing: it would be 1e-12 of its size thick.
const LEAST_VOLUME: f64 = 1e-12;

/// How [`Part::new`] treats doubtful input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartOptions {
    /// Let meshes through that have gaps or edges whose triangles do not pair
    /// up. Inside and outside are then guesses near those edges.
    pub allow_open: bool,
    /// Merge vertices within this distance, in part units. `None` merges only
    /// equal vertices, only when the mesh is not closed without; and those apart
    /// by the noise of single precision, only if that closes the mesh and folds
    /// no triangle.
    pub weld: Option<f64>,
    /// Put right also what takes a guess; see [`mend()`](super::mend()).
    pub repair: bool,
}

impl Part {
    /// Mends a mesh ([`mend()`](super::mend())) and makes all checks, in order: indices and
    /// coordinates, size, closedness, volume, walls left.
    ///
    /// Triangles keep their order; pieces of one that was split stand behind it with
    /// its flag. Vertices that no triangle uses go.
    ///
    /// # Errors
    ///
    /// A [`PartError`] names the triangle, vertex or edge at fault.
    pub fn new(
        mesh: TriMesh,
        coping: Vec<bool>,
        options: PartOptions,
    ) -> Result<(Part, Vec<PartWarning>), PartError> {
        check_numbers(&mesh)?;
        if coping.len() != mesh.triangles.len() {
            return Err(PartError::CopingLength {
                flags: coping.len(),
                triangles: mesh.triangles.len(),
            });
        }
        let mut warnings = check_size(&mesh)?;
        let (mended, uses) = mend::with_edges(mesh, options)?;
        let Mended {
            mesh,
            origin,
            repairs,
        } = mended;
        let coping: Vec<bool> = origin.iter().map(|&o| coping[o as usize]).collect();
        warnings.extend(repairs.into_iter().map(|repair| repair.what));
        let census = uses.census();
        warnings.extend(check_edges(&mesh, &uses, &census, options)?);
        let closed = census.is_closed();
        if closed {
            check_volume(&mesh)?;
        }
        warnings.extend(check_walls(&mesh, &coping)?);
        let part = Part {
            mesh,
            coping,
            closed,
        };
        Ok((part, warnings))
    }
}

fn check_numbers(mesh: &TriMesh) -> Result<(), PartError> {
    if mesh.triangles.is_empty() {
        return Err(PartError::Empty);
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(PartError::NotFinite {
            vertex: vertex as u32,
            position: mesh.positions[vertex],
        });
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&index) = corners
            .iter()
            .find(|&&v| v as usize >= mesh.positions.len())
        {
            return Err(PartError::IndexOutOfRange {
                triangle: FaceId(triangle as u32),
                index,
                vertices: mesh.positions.len(),
            });
        }
    }
    Ok(())
}

fn check_size(mesh: &TriMesh) -> Result<Vec<PartWarning>, PartError> {
    let bounds = mesh.bounds();
    let diagonal = bounds.diagonal();
    if !USABLE_DIAGONAL.contains(&diagonal) {
        return Err(PartError::Size { diagonal });
    }
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    let ratio = farthest / diagonal;
    let step = step(mesh, &bounds);
    Ok(if ratio > FAR_RATIO || step > COARSE_STEP * diagonal {
        vec![PartWarning::FarFromOrigin { ratio, step }]
    } else {
        Vec::new()
    })
}

/// Distance between neighbouring numbers of the input at its greatest
/// coordinate: those of f32 where all coordinates of an axis are such and make
/// use of the last digit, as in an STL file; else those of f64.
fn step(mesh: &TriMesh, bounds: &Bounds) -> f64 {
    let along = |axis: usize| {
        let far = bounds.min[axis].abs().max(bounds.max[axis].abs());
        let single = f64::from((far as f32).next_up()) - f64::from(far as f32);
        let mut coordinates = mesh.positions.iter().map(|p| p[axis]);
        let is_single = coordinates.clone().all(|x| f64::from(x as f32) == x);
        let uses_last = coordinates.any(|x| (x / single).abs() % 2.0 == 1.0);
        if is_single && uses_last {
            single
        } else {
            far.next_up() - far
        }
    };
    along(0).max(along(1)).max(along(2))
}

fn check_edges(
    mesh: &TriMesh,
    uses: &EdgeUses,
    census: &EdgeCensus,
    options: PartOptions,
) -> Result<Vec<PartWarning>, PartError> {
    let mut warnings = Vec::new();
    if let Some(first) = uses.first(EdgeKind::Open) {
        let (count, first) = (census.open, report(mesh, first));
        if !options.allow_open {
            let weld = closing_weld(mesh);
            return Err(PartError::Open { count, first, weld });
        }
        warnings.push(PartWarning::Open { count, first });
    }
    if let Some(edge) = uses.first(EdgeKind::Unbalanced) {
        let (count, first) = (census.unbalanced, report(mesh, edge));
        if !options.allow_open {
            return Err(PartError::NonManifold {
                count,
                first,
                uses: edge.len(),
            });
        }
        warnings.push(PartWarning::NonManifold {
            count,
            first,
            balanced: false,
        });
    }
    if let Some(edge) = uses.first(EdgeKind::Balanced) {
        warnings.push(PartWarning::NonManifold {
            count: census.balanced,
            first: report(mesh, edge),
            balanced: true,
        });
    }
    Ok(warnings)
}

fn check_volume(mesh: &TriMesh) -> Result<(), PartError> {
    let (volume, area) = (mesh.volume(), mesh.area());
    if volume.abs() <= LEAST_VOLUME * area * mesh.bounds().diagonal() {
        return Err(PartError::NoVolume { volume, area });
    }
    Ok(())
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let longest = (b - a)
        .length_squared()
        .max((c - b).length_squared())
        .max((a - c).length_squared());
    (b - a).cross(c - a).length() > FLATNESS * longest
}

fn check_walls(mesh: &TriMesh, coping: &[bool]) -> Result<Vec<PartWarning>, PartError> {
    let mut warnings = Vec::new();
    let flat: Vec<FaceId> = mesh
        .faces()
        .filter(|&face| !has_area(mesh.corners(face)))
        .collect();
    if let Some(&first) = flat.first() {
        warnings.push(PartWarning::ZeroArea {
            triangles: flat.len(),
            first,
        });
    }
    let walls = coping.iter().filter(|&&flag| !flag).count();
    if walls == 0 {
        return Err(PartError::AllCoping {
            triangles: coping.len(),
        });
    }
    let flat_walls = flat.iter().filter(|face| !coping[face.index()]).count();
    if walls == flat_walls {
        return Err(PartError::NoWall { walls });
    }
    if walls == coping.len() {
        warnings.push(PartWarning::NoCoping);
    }
    Ok(warnings)
}
