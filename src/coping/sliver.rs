//! Slivers: narrow strips that nobody tagged, between faces that are coping.
//!
//! A step of a few microns in a rim, or a seam of the modeller, cannot be seen;
//! left as wall it holds a footpoint for every point within half a thickness,
//! and takes a half disc from the sheet.

use glam::DVec3;

use crate::field::Field;
use crate::mesh::sets::Sets;
use crate::mesh::{FaceId, TriMesh, weld_exact};

/// Share of a sliver's border that lies on coping, at least.
const BORDERED: f64 = 0.8;

/// Width over depth, at most: a strip so narrow against what lies behind it is
/// no side of a wall.
const NARROW: f64 = 0.2;

/// Width over length, at most, of what is looked at closer.
const SLENDER: f64 = 0.25;

/// Width over that of the coping beside it, at most: what is as wide as a rim
/// was left out on purpose, or missed as a whole.
const THIN: f64 = 0.1;

/// Cosine of the bend up to which triangles are one strip, 45 degrees.
const ONE_STRIP: f64 = 0.7;

/// A strip that was adopted.
#[derive(Clone, Debug, PartialEq)]
pub struct Sliver {
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
    /// Mean width, part units.
    pub width: f64,
    /// A point of it.
    pub at: DVec3,
}

/// Strips of wall triangles between coping that are far narrower than what lies
/// behind them is deep, in order of their lowest triangle. Triangles in `kept`
/// stay wall.
pub(super) fn slivers(mesh: &TriMesh, coping: &[bool], kept: &[bool]) -> Vec<Sliver> {
    if !mesh.positions.iter().all(|p| p.is_finite()) {
        return Vec::new();
    }
    let welded = weld_exact(&mesh.positions).apply(mesh);
    let mut candidates = candidates(&welded, coping);
    candidates.retain(|sliver| sliver.triangles.iter().all(|&t| !kept[t as usize]));
    if candidates.is_empty() {
        return candidates;
    }
    let field = Field::of_mesh(&welded);
    let reach = 2.0 * welded.bounds().diagonal();
    candidates.retain(|sliver| {
        let largest = sliver.triangles.iter().map(|&t| FaceId(t));
        let area = |&face: &FaceId| welded.triangle_area(face);
        let Some(face) = largest.max_by(|a, b| area(a).total_cmp(&area(b))) else {
            return false;
        };
        let inward = -welded.area_vector(face).normalize_or_zero();
        let middle = welded.corners(face).iter().sum::<DVec3>() / 3.0;
        let from = middle + 1e-3 * sliver.width * inward;
        let hit = field.first_hit(from, from + reach * inward);
        hit.is_some_and(|hit| sliver.width <= NARROW * hit.t * reach)
    });
    candidates
}

/// What is known of triangles of one tag that hang together without a crease.
#[derive(Clone, Copy, Debug)]
struct Strip {
    on_coping: f64,
    border: f64,
    area: f64,
    /// Width of the narrowest coping beside it.
    beside: f64,
}

impl Strip {
    /// Of a long strip; a third of its size for a compact face.
    fn width(&self) -> f64 {
        2.0 * self.area / self.border
    }

    fn is_sliver(&self) -> bool {
        self.area > 0.0
            && self.on_coping >= BORDERED * self.border
            && self.width() <= SLENDER * 0.5 * self.border
            && self.width() <= THIN * self.beside
    }
}

/// Slender strips of wall with coping nearly all round, that far wider.
fn candidates(mesh: &TriMesh, coping: &[bool]) -> Vec<Sliver> {
    let normal = |face: FaceId| mesh.area_vector(face).normalize_or_zero();
    let uses = mesh.edges();
    let mut sets = Sets::new(mesh.triangles.len());
    let pairs: Vec<[FaceId; 2]> = uses
        .by_edge()
        .filter_map(|uses| match uses {
            [a, b] => Some([a.face, b.face]),
            _ => None,
        })
        .collect();
    for &[a, b] in &pairs {
        let (na, nb) = (normal(a), normal(b));
        let flat = na.dot(nb) >= ONE_STRIP || na == DVec3::ZERO || nb == DVec3::ZERO;
        if coping[a.index()] == coping[b.index()] && flat {
            sets.join(a.0, b.0);
        }
    }
    let (strip_of, count) = sets.labels();
    let strip = |face: FaceId| strip_of[face.index()] as usize;
    let none = Strip {
        on_coping: 0.0,
        border: 0.0,
        area: 0.0,
        beside: f64::INFINITY,
    };
    let mut strips = vec![none; count];
    for face in mesh.faces() {
        strips[strip(face)].area += mesh.triangle_area(face);
    }
    let borders = uses.by_edge().filter_map(|uses| match uses {
        [a, b] if strip(a.face) != strip(b.face) => {
            let [from, to] = a.edge.map(|v| mesh.positions[v as usize]);
            Some((from.distance(to), [a.face, b.face]))
        }
        _ => None,
    });
    let borders: Vec<(f64, [FaceId; 2])> = borders.collect();
    let both_ways = |&[a, b]: &[FaceId; 2]| [(a, b), (b, a)];
    for (length, faces) in &borders {
        for (own, other) in both_ways(faces) {
            let own = &mut strips[strip(own)];
            own.border += length;
            if coping[other.index()] {
                own.on_coping += length;
            }
        }
    }
    let widths: Vec<f64> = strips.iter().map(Strip::width).collect();
    for (_, faces) in &borders {
        for (own, other) in both_ways(faces) {
            if coping[other.index()] {
                let own = &mut strips[strip(own)];
                own.beside = own.beside.min(widths[strip(other)]);
            }
        }
    }
    let mut slivers: Vec<Option<Sliver>> = strips
        .iter()
        .map(|strip| {
            strip.is_sliver().then(|| Sliver {
                triangles: Vec::new(),
                width: strip.width(),
                at: DVec3::ZERO,
            })
        })
        .collect();
    for face in mesh.faces().filter(|face| !coping[face.index()]) {
        if let Some(sliver) = &mut slivers[strip(face)] {
            if sliver.triangles.is_empty() {
                sliver.at = mesh.corners(face).iter().sum::<DVec3>() / 3.0;
            }
            sliver.triangles.push(face.0);
        }
    }
    let slivers = slivers.into_iter().flatten();
    slivers
        .filter(|sliver| !sliver.triangles.is_empty())
        .collect()
}
