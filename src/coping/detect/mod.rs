//! Coping faces found by the program.
//!
//! A coping face is narrow, closes a wall at two convex edges, and the wall
//! goes on behind it. The stages, each in its own file:
//!
//! ```text
//! surface -> samples -> probes -> faces -> cut -> measures, relations -> decide -> doubt
//! ```
//!
//! Points of the surface are looked from into the part (`probes`); the
//! surface is cut into faces a person would name (`faces`, `cut`); what
//! faces say of each other (`relations`) settles those whose own proportions
//! say little (`decide`). Every threshold is relative to a length measured
//! at the same place, so units, turning, mesh density and the order of
//! triangles play no part.

mod cut;
mod decide;
mod doubt;
mod faces;
mod measures;
mod probes;
mod question;
mod relations;
mod samples;
mod surface;
mod verdict;

use glam::DVec3;

use crate::mesh::{Bounds, TriMesh};
use decide::Decision;
use doubt::Doubt;
use faces::Faces;
use measures::Measures;
use surface::Surface;

pub use doubt::Reason;
pub use faces::Kind;
pub use question::{ASK, Question};
pub use verdict::Verdict;

/// How closely to look.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// About how many points of the surface are looked at; by default one a
    /// squared wall thickness, but no fewer than 4,000 and no more than 8,000.
    pub samples: Option<usize>,
}

/// Points looked at by default, at least and at most.
const SAMPLES: [f64; 2] = [4000.0, 8000.0];

/// A face that was found, coping or wall.
#[derive(Clone, Debug, PartialEq)]
pub struct DetectedFace {
    /// Place in [`Detection::faces`], which names it for people.
    pub number: usize,
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
    /// What was decided.
    pub coping: bool,
    /// Mean of what its points see: -1 for the side of a wall, 1 for a face
    /// that closes one.
    pub score: f64,
    /// What its neighbours add to that.
    pub by_neighbours: f64,
    /// 0 for sure to 1.
    pub doubt: f64,
    /// What the doubt comes from, gravest first.
    pub reasons: Vec<Reason>,
    /// How it is curved.
    pub kind: Kind,
    /// Square part units.
    pub area: f64,
    /// Mean wall thickness at the face, part units.
    pub thickness: f64,
    /// Box around it.
    pub bounds: Bounds,
    /// A point of it near its middle.
    pub middle: DVec3,
}

/// What was found on a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// One flag a triangle: true for coping.
    pub flags: Vec<bool>,
    /// The faces, in order of their lowest triangle.
    pub faces: Vec<DetectedFace>,
    /// Share of the surface that belongs to thin walls: coping, or a wall between
    /// two copings, or one at least three times as wide as thick.
    pub thin_share: f64,
    /// Points looked at.
    pub samples: usize,
    /// Edges that do not join exactly two triangles.
    pub odd_edges: usize,
    /// Whether the mesh has gaps.
    pub open: bool,
}

/// Finds the coping faces of a part, given as its closed mesh alone.
///
/// Deterministic: the same mesh gives the same result, bit for bit, on any
/// number of threads.
///
/// ```
/// use midsurf::coping::{detect, detect::Options};
///
/// let loaded = midsurf::io::read_mesh("fixtures/tee.obj")?;
/// let found = detect(&loaded.mesh, &Options::default());
/// assert!(found.faces.iter().any(|face| face.coping));
/// assert!(found.questions().is_empty());
/// # Ok::<(), midsurf::io::ReadError>(())
/// ```
pub fn detect(mesh: &TriMesh, options: &Options) -> Detection {
    if !mesh.bounds().size().is_finite() || !mesh.positions.iter().all(|p| p.is_finite()) {
        return Detection::none(mesh);
    }
    let surface = Surface::new(mesh);
    if surface.is_loose() {
        return Detection {
            odd_edges: surface.odd_edges,
            open: true,
            ..Detection::none(mesh)
        };
    }
    let [least, most] = SAMPLES;
    // No number where there is no area; without a volume, too large a one.
    let by_size = || surface.squares().max(least).min(most) as usize;
    let samples = samples::spread(&surface, options.samples.unwrap_or_else(by_size));
    let probes = probes::look(&surface, &samples);
    let thickness = faces::thickness(&surface, &samples, &probes);
    let mut faces = Faces::find(&surface, &thickness);
    let added = cut::cut(&surface, &samples, &probes, &mut faces);
    let measures = Measures::of(&surface, &samples, &probes, &faces);
    let relations = relations::Relations::find(&surface, &samples, &probes, &faces, &measures);
    let thin_wall = measures::thin_wall(&samples, &probes);
    let decision = decide::decide(&surface, &faces, &measures, &relations, thin_wall);
    let seen = doubt::Seen {
        surface: &surface,
        samples: &samples,
        probes: &probes,
        faces: &faces,
        measures: &measures,
        decision: &decision,
        added,
    };
    let doubts = seen.doubts();

    tracing::debug!(
        samples = samples.len(),
        faces = faces.len(),
        thin_wall,
        "coping faces decided"
    );
    let list = list(&surface, &faces, &measures, &decision, doubts);
    let coping = |triangle: u32| decision.coping[faces.of(triangle)];
    let (mut thin, mut whole) = (0.0, 0.0);
    for (sample, probe) in samples.iter().zip(&probes) {
        whole += sample.weight;
        let between_rims = probe
            .sides
            .is_some_and(|sides| sides.into_iter().all(coping));
        if coping(sample.face) || between_rims || measures::is_thin(probe) {
            thin += sample.weight;
        }
    }
    let flag = |&face: &u32| decision.coping[face as usize];
    Detection {
        flags: faces.of.iter().map(flag).collect(),
        faces: list,
        thin_share: if whole > 0.0 { thin / whole } else { 0.0 },
        samples: samples.len(),
        odd_edges: surface.odd_edges,
        open: surface.open,
    }
}

impl Detection {
    /// Nothing found, where there is nothing to look at.
    fn none(mesh: &TriMesh) -> Detection {
        Detection {
            flags: vec![false; mesh.triangles.len()],
            faces: Vec::new(),
            thin_share: 0.0,
            samples: 0,
            odd_edges: 0,
            open: false,
        }
    }
}

/// The faces as the user gets them, numbered in order of their lowest triangle.
fn list(
    surface: &Surface,
    faces: &Faces,
    measures: &Measures,
    decision: &Decision,
    doubts: Vec<Doubt>,
) -> Vec<DetectedFace> {
    let mut list: Vec<DetectedFace> = doubts
        .into_iter()
        .enumerate()
        .map(|(face, doubt)| DetectedFace {
            number: 0,
            triangles: Vec::new(),
            coping: decision.coping[face],
            score: measures.score[face],
            by_neighbours: decision.closure[face],
            doubt: doubt.amount,
            reasons: doubt.reasons,
            kind: faces.kinds[face],
            area: measures.area[face],
            thickness: measures.thickness[face],
            bounds: Bounds::EMPTY,
            middle: DVec3::ZERO,
        })
        .collect();
    for (triangle, &face) in faces.of.iter().enumerate() {
        let face = &mut list[face as usize];
        face.triangles.push(triangle as u32);
        for corner in surface.corners[triangle] {
            face.bounds = face.bounds.with(corner);
        }
    }
    list.sort_by_key(|face| face.triangles.first().copied());
    for (number, face) in list.iter_mut().enumerate() {
        face.number = number;
        face.middle = surface.middle_of(&face.triangles, face.bounds.center());
    }
    list
}
