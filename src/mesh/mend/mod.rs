//! What is put right on a mesh before it becomes a part.
//!
//! Always, because it moves nothing or no more than single precision does:
//! equal vertices are merged where the mesh is open, and those apart by noise if
//! that closes it; vertices that lie on open edges split them, and so do the tips
//! of triangles without area; neighbours are turned to agree, and shells to what
//! their nesting makes of them. On request
//! ([`PartOptions::repair`]), because it guesses or leaves triangles out: gaps a
//! little wider are welded, triangles given twice and folded pairs go, small flat
//! holes are filled, fans that hang together in a vertex alone get vertices of
//! their own.
//!
//! Every step says what it did and where ([`Repair`]); one that leaves as much
//! wrong as before is not taken.

mod caps;
mod doubled;
mod gaps;
mod holes;
mod orient;
mod pinch;
mod stitch;

use glam::DVec3;

use super::edges::{EdgeKind, EdgeUses, kind};
use super::error::{PartError, PartWarning};
use super::shells::turn_by_nesting;
use super::weld::drop_unused;
use super::{PartOptions, TriMesh};

pub(super) use gaps::closing_weld;
pub(super) use orient::report;
pub(crate) use stitch::close_exactly as close_t_junctions;

/// Times that all steps are gone through at most.
const ROUNDS: usize = 4;

/// Places that a repair states; all are counted.
const MOST_PLACES: usize = 1000;

/// A mesh put right.
#[derive(Clone, Debug)]
pub struct Mended {
    /// The triangles; pieces of one stand one behind the other.
    pub mesh: TriMesh,
    /// The triangle before that each is, or is a piece of, ascending. One that
    /// fills a hole has a neighbour's.
    pub origin: Vec<u32>,
    /// What was done.
    pub repairs: Vec<Repair>,
}

/// Something that was put right.
#[derive(Clone, Debug, PartialEq)]
pub struct Repair {
    /// What.
    pub what: PartWarning,
    /// Where, for as many places as are worth listing; none for what concerns all
    /// of the mesh.
    pub places: Vec<DVec3>,
}

impl Repair {
    pub(super) fn at(what: PartWarning, places: impl IntoIterator<Item = DVec3>) -> Repair {
        Repair {
            what,
            places: places.into_iter().take(MOST_PLACES).collect(),
        }
    }
}

/// A mesh on its way.
struct Work {
    mesh: TriMesh,
    origin: Vec<u32>,
    /// Shells, where they are too many to find out which lies in which.
    unchecked: Option<usize>,
}

/// Edges of each kind that no closed mesh has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Faults {
    open: usize,
    unbalanced: usize,
}

impl Faults {
    fn of(mesh: &TriMesh) -> Faults {
        Faults::among(&mesh.edges())
    }

    fn among(uses: &EdgeUses) -> Faults {
        let census = uses.census();
        Faults {
            open: census.open,
            unbalanced: census.unbalanced,
        }
    }

    fn all(self) -> usize {
        self.open + self.unbalanced
    }
}

/// Puts a mesh right as far as that can be done; what is wrong all the same is for
/// [`Part::new`](super::Part::new) to refuse. Indices must be in range and
/// coordinates finite. What is mended already stays as it is.
///
/// # Errors
///
/// [`PartError`] for a weld that would weld the part away, and for a surface of
/// one side.
pub fn mend(mesh: TriMesh, options: PartOptions) -> Result<Mended, PartError> {
    with_edges(mesh, options).map(|(mended, _)| mended)
}

/// [`mend`], and the edges of the mesh that comes of it.
pub(super) fn with_edges(
    mesh: TriMesh,
    options: PartOptions,
) -> Result<(Mended, EdgeUses), PartError> {
    let mut work = Work {
        origin: (0..mesh.triangles.len() as u32).collect(),
        mesh: drop_unused(mesh),
        unchecked: None,
    };
    let mut uses = work.mesh.edges();
    let mut repairs = Vec::new();
    // What one step mends may be what another one stumbled over.
    let mut left = options;
    for _ in 0..ROUNDS {
        let before = repairs.len();
        uses = round(&mut work, uses, left, &mut repairs)?;
        // Welding again would join what was parted since.
        left.weld = None;
        if repairs.len() == before {
            break;
        }
    }
    if let Some(shells) = work.unchecked {
        repairs.push(Repair::at(PartWarning::ShellsUnchecked { shells }, []));
    }
    let Work { mesh, origin, .. } = work;
    let mended = Mended {
        mesh,
        origin,
        repairs,
    };
    Ok((mended, uses))
}

/// All steps once, in an order in which each finds what those before it left.
fn round(
    work: &mut Work,
    uses: EdgeUses,
    options: PartOptions,
    repairs: &mut Vec<Repair>,
) -> Result<EdgeUses, PartError> {
    let start = repairs.len();
    let faults = Faults::among(&uses);
    // Two shells that touch share positions, not vertices: leave them apart
    // where the mesh is closed as it stands.
    if options.weld.is_some() || faults.open > 0 {
        repairs.extend(gaps::weld(&mut work.mesh, options)?);
    }
    if options.repair {
        repairs.extend(doubled::drop_repeated(work));
        repairs.extend(doubled::drop_folded(work));
    }
    if faults.open > 0 {
        repairs.extend(stitch::close_t_junctions(work, options.repair));
    }
    let mut uses = if repairs.len() > start {
        work.mesh.edges()
    } else {
        uses
    };
    if let Some(repair) = orient::make_consistent(&mut work.mesh, &uses)? {
        repairs.push(repair);
        uses = work.mesh.edges();
    }
    if let Some(repair) = caps::flip(work) {
        repairs.push(repair);
        uses = work.mesh.edges();
    }
    if options.repair {
        let before = repairs.len();
        repairs.extend(holes::fill(work, &uses));
        if repairs.len() > before {
            uses = work.mesh.edges();
        }
        // Equal vertices of an open mesh are welded.
        if Faults::among(&uses).open == 0 {
            repairs.extend(pinch::part(&mut work.mesh));
        }
    }
    repairs.extend(orient::make_outward(&mut work.mesh));
    match turn_by_nesting(&mut work.mesh, &uses) {
        Ok(turned) => repairs.extend(turned),
        Err(shells) => work.unchecked = Some(shells),
    }
    if repairs.len() > start {
        work.mesh = drop_unused(std::mem::take(&mut work.mesh));
        uses = work.mesh.edges();
    }
    Ok(uses)
}

impl Work {
    /// The triangles that are kept.
    fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let mut at = 0;
        self.mesh.triangles.retain(|_| {
            at += 1;
            keep(at - 1)
        });
        at = 0;
        self.origin.retain(|_| {
            at += 1;
            keep(at - 1)
        });
    }

    /// Adds triangles with their origins, each behind those of its origin.
    fn insert(&mut self, added: Vec<(u32, [u32; 3])>) {
        let triangles = self.mesh.triangles.iter().copied();
        let mut all: Vec<(u32, [u32; 3])> = self.origin.iter().copied().zip(triangles).collect();
        all.extend(added);
        // Stable: what was there comes first.
        all.sort_by_key(|(origin, _)| *origin);
        (self.origin, self.mesh.triangles) = all.into_iter().unzip();
    }
}

/// Middle of a triangle.
fn middle(mesh: &TriMesh, triangle: [u32; 3]) -> DVec3 {
    triangle
        .iter()
        .map(|&v| mesh.positions[v as usize])
        .sum::<DVec3>()
        / 3.0
}

/// Open edges as their triangles run them, with the triangle.
fn open_runs(uses: &EdgeUses) -> Vec<([u32; 2], usize)> {
    uses.by_edge()
        .filter(|uses| kind(uses) == EdgeKind::Open)
        .map(|uses| {
            let [a, b] = uses[0].edge;
            let run = if uses[0].forward { [a, b] } else { [b, a] };
            (run, uses[0].face.index())
        })
        .collect()
}
