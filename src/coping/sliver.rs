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

/// Slender strips of wall with coping nearly all round.
fn candidates(mesh: &TriMesh, coping: &[bool]) -> Vec<Sliver> {
    let normal = |face: FaceId| mesh.area_vector(face).normalize_or_zero();
    let uses = mesh.edges();
    let mut sets = Sets::new(mesh.triangles.len());
    let pairs = || uses.by_edge().filter(|uses| uses.len() == 2);
    for pair in pairs() {
        let [a, b] = [pair[0].face, pair[1].face];
        let walls = !coping[a.index()] && !coping[b.index()];
        let (na, nb) = (normal(a), normal(b));
        let flat = na.dot(nb) >= ONE_STRIP || na == DVec3::ZERO || nb == DVec3::ZERO;
        if walls && flat {
            sets.join(a.0, b.0);
        }
    }
    let (strip_of, count) = sets.labels();
    // Border on coping, whole border, area.
    let mut sums = vec![[0.0; 3]; count];
    for pair in pairs() {
        let [from, to] = pair[0].edge.map(|v| mesh.positions[v as usize]);
        let length = from.distance(to);
        let [a, b] = [pair[0].face, pair[1].face];
        for (own, other) in [(a, b), (b, a)] {
            let strip = strip_of[own.index()];
            if strip != strip_of[other.index()] {
                let sum = &mut sums[strip as usize];
                sum[1] += length;
                if coping[other.index()] {
                    sum[0] += length;
                }
            }
        }
    }
    for face in mesh.faces() {
        sums[strip_of[face.index()] as usize][2] += mesh.triangle_area(face);
    }
    let width = |&[_, border, area]: &[f64; 3]| 2.0 * area / border;
    let slender = |sum: &[f64; 3]| {
        let [on_coping, border, area] = *sum;
        area > 0.0 && on_coping >= BORDERED * border && width(sum) <= SLENDER * 0.5 * border
    };
    let mut strips: Vec<Option<Sliver>> = sums
        .iter()
        .map(|sum| {
            slender(sum).then(|| Sliver {
                triangles: Vec::new(),
                width: width(sum),
                at: DVec3::ZERO,
            })
        })
        .collect();
    for face in mesh.faces().filter(|face| !coping[face.index()]) {
        if let Some(sliver) = &mut strips[strip_of[face.index()] as usize] {
            if sliver.triangles.is_empty() {
                sliver.at = mesh.corners(face).iter().sum::<DVec3>() / 3.0;
            }
            sliver.triangles.push(face.0);
        }
    }
    let strips = strips.into_iter().flatten();
    strips
        .filter(|sliver| !sliver.triangles.is_empty())
        .collect()
}
