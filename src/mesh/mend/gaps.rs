//! Gaps closed by merging vertices.

use glam::DVec3;

use super::{Faults, Repair};
use crate::mesh::error::{PartError, PartWarning};
use crate::mesh::weld::{Weld, weld_exact, weld_within};
use crate::mesh::{PartOptions, TriMesh};

/// A tolerance above this share of the diagonal would weld the part itself.
const LARGEST_WELD: f64 = 0.05;

/// Vertices within this share of the largest coordinate may be one place written
/// twice: two units in the last place of single precision, as which STL is stored
/// and much text is computed.
pub(super) const NOISE: f64 = 2.5e-7;

/// Shares of the diagonal that are tried to name a length that would close a mesh;
/// the last is a tenth of the wall of a part a hundred times as long as thick.
const WELDS_TRIED: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];

/// Merges vertices: equal ones; then those within the tolerance asked for, or if
/// none was, those apart by noise, if that closes the mesh. On request the
/// shortest length that closes it, or the noise if that leaves fewer edges open.
pub(super) fn weld(mesh: &mut TriMesh, options: PartOptions) -> Result<Option<Repair>, PartError> {
    let diagonal = mesh.bounds().diagonal();
    if let Some(tolerance) = options.weld
        && !(tolerance > 1e-15 * diagonal && tolerance <= LARGEST_WELD * diagonal)
    {
        return Err(PartError::WeldTolerance {
            tolerance,
            diagonal,
        });
    }
    let exact = weld_exact(&mesh.positions);
    if exact.merged() > 0 {
        *mesh = exact.apply(mesh);
    }
    let near = match options.weld {
        Some(tolerance) => Some(weld_within(&mesh.positions, tolerance)),
        None => {
            closing(mesh, noise(mesh)).or_else(|| options.repair.then(|| wider(mesh)).flatten())
        }
    };
    let places = near
        .as_ref()
        .map_or_else(Vec::new, |weld| moved(mesh, weld));
    let merged = near.as_ref().map_or(0, Weld::merged);
    if let Some(weld) = near {
        *mesh = weld.apply(mesh);
    }
    let what = PartWarning::Welded {
        exact: exact.merged(),
        near: merged,
    };
    Ok((exact.merged() + merged > 0).then(|| Repair::at(what, places)))
}

/// A weld for a mesh that noise alone does not close.
fn wider(mesh: &TriMesh) -> Option<Weld> {
    let close = || closing_weld(mesh).and_then(|tolerance| closing(mesh, tolerance));
    close().or_else(|| {
        let weld = weld_within(&mesh.positions, noise(mesh));
        let welded = weld.apply(mesh);
        let fewer = Faults::of(&welded).all() < Faults::of(mesh).all();
        (fewer && folds(&welded) == folds(mesh)).then_some(weld)
    })
}

/// Length below which two places may be one, for a mesh in single precision.
pub(super) fn noise(mesh: &TriMesh) -> f64 {
    let bounds = mesh.bounds();
    NOISE * bounds.min.abs().max(bounds.max.abs()).max_element()
}

/// Places of the vertices that go.
fn moved(mesh: &TriMesh, weld: &Weld) -> Vec<DVec3> {
    let stays = |old: usize| weld.kept[weld.new_index[old] as usize] as usize == old;
    let gone = (0..mesh.positions.len()).filter(|&old| !stays(old));
    gone.map(|old| mesh.positions[old]).collect()
}

/// The weld with a tolerance, if the mesh has gaps now and none then, and no
/// triangle folds on the way.
fn closing(mesh: &TriMesh, tolerance: f64) -> Option<Weld> {
    if tolerance <= 0.0 || Faults::of(mesh).open == 0 {
        return None;
    }
    let weld = weld_within(&mesh.positions, tolerance);
    let welded = weld.apply(mesh);
    let closed = Faults::of(&welded).open == 0 && folds(&welded) == folds(mesh);
    closed.then_some(weld)
}

/// Triangles with a repeated corner.
fn folds(mesh: &TriMesh) -> usize {
    let folded = |&&[a, b, c]: &&[u32; 3]| a == b || b == c || c == a;
    mesh.triangles.iter().filter(folded).count()
}

/// A tolerance that would close the mesh, for the error that refuses it.
pub(in crate::mesh) fn closing_weld(mesh: &TriMesh) -> Option<f64> {
    let diagonal = mesh.bounds().diagonal();
    let tried = WELDS_TRIED.iter().map(|share| share * diagonal);
    tried.into_iter().find(|&t| closing(mesh, t).is_some())
}
