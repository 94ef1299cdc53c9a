//! The surface cut into faces that a person would name: each nearly flat, or
//! a convex round, or a fillet.

use super::probes::Probe;
use super::samples::{SMOOTH, Sample};
use super::surface::Surface;
use crate::mesh::sets::Sets;

/// Edges that bend by less lie in one plane, degrees.
const PLANE: f64 = 1.0;

/// Edges that bend by more bound every face, degrees; below, neighbours pull
/// at each other.
pub(super) const CREASE: f64 = 45.0;

/// Thickness over radius of curvature from which a surface is a round, or a
/// fillet.
const ROUND: f64 = 1.2;

/// Facets below this many squared thicknesses are too small to tell their own
/// curvature; they ask their neighbours.
const SMALL: f64 = 0.1;
const SMALL_ROUNDS: usize = 2;

/// Rounds in which triangles without a sample take the thickness of their
/// neighbours.
const SPREAD_ROUNDS: usize = 60;

/// How a face is curved, measured by the wall's thickness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Flat or gently bent.
    Flat,
    /// Convex, of a radius below the thickness.
    Round,
    /// Concave, of a radius below the thickness: a fillet or a narrow hole.
    Fillet,
}

/// Which face each triangle belongs to.
#[derive(Clone, Debug)]
pub(super) struct Faces {
    /// Face of each triangle.
    pub of: Vec<u32>,
    /// Kind of each face.
    pub kinds: Vec<Kind>,
}

impl Faces {
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    pub fn of(&self, triangle: u32) -> usize {
        self.of[triangle as usize] as usize
    }

    /// Cuts the surface; `hints` are boundaries that the file knows of: equal
    /// numbers, one face.
    pub fn find(surface: &Surface, thickness: &[f64]) -> Faces {
        let kinds = kinds(surface, thickness);
        let mut sets = Sets::new(surface.len());
        for edge in &surface.edges {
            let [a, b] = edge.faces.map(|face| kinds[face as usize]);
            let most = if a == Kind::Flat { SMOOTH } else { CREASE };
            if a == b && edge.angle() < most {
                sets.join(edge.faces[0], edge.faces[1]);
            }
        }
        let (of, count) = sets.labels();
        let mut kind_of = vec![Kind::Flat; count];
        for (&face, &kind) in of.iter().zip(&kinds) {
            kind_of[face as usize] = kind;
        }
        Faces { of, kinds: kind_of }
    }
}

/// Kind of every triangle, told by the curvature of its plane: half the turning
/// of its edges over its area.
fn kinds(surface: &Surface, thickness: &[f64]) -> Vec<Kind> {
    let mut sets = Sets::new(surface.len());
    for edge in surface.edges.iter().filter(|e| e.angle() < PLANE) {
        sets.join(edge.faces[0], edge.faces[1]);
    }
    let (plane_of, count) = sets.labels();
    let plane_of: Vec<usize> = plane_of.into_iter().map(|plane| plane as usize).collect();
    let mut areas: Vec<f64> = vec![0.0; count];
    let mut logs: Vec<(f64, f64)> = vec![(0.0, 0.0); count];
    for (triangle, &plane) in plane_of.iter().enumerate() {
        let area = surface.areas[triangle];
        areas[plane] += area;
        // So that planes of slivers have a thickness too.
        let weight = area + f64::MIN_POSITIVE;
        logs[plane].0 += weight * thickness[triangle].ln();
        logs[plane].1 += weight;
    }
    let local: Vec<f64> = logs
        .iter()
        .map(|(sum, weight)| (sum / weight).exp())
        .collect();

    let mut turning: Vec<f64> = vec![0.0; count];
    let mut beside = Vec::new();
    for edge in &surface.edges {
        let [a, b] = edge.faces.map(|face| plane_of[face as usize]);
        if a != b && edge.angle() < CREASE {
            let half = 0.5 * edge.bend.to_radians() * edge.length;
            turning[a] += half;
            turning[b] += half;
            beside.push((a, b));
        }
    }
    let mut area_seen = areas.clone();
    for _ in 0..SMALL_ROUNDS {
        let (own_turning, own_area) = (turning.clone(), area_seen.clone());
        for &(a, b) in &beside {
            for (plane, other) in [(a, b), (b, a)] {
                if areas[plane] < SMALL * local[plane] * local[plane] {
                    turning[plane] += own_turning[other];
                    area_seen[plane] += own_area[other];
                }
            }
        }
    }
    let kind = |plane: usize| {
        let curved = turning[plane] / area_seen[plane].max(f64::MIN_POSITIVE) * local[plane];
        if curved > ROUND {
            Kind::Round
        } else if curved < -ROUND {
            Kind::Fillet
        } else {
            Kind::Flat
        }
    };
    plane_of.into_iter().map(kind).collect()
}

/// Wall thickness on every triangle: the geometric mean of its samples;
/// triangles without any take it from their neighbours across smooth edges,
/// and the rest have the part's median.
pub(super) fn thickness(surface: &Surface, samples: &[Sample], probes: &[Probe]) -> Vec<f64> {
    let count = surface.len();
    let mut sums = vec![(0.0, 0.0); count];
    for (sample, probe) in samples.iter().zip(probes) {
        let sum = &mut sums[sample.face as usize];
        sum.0 += sample.weight * probe.thickness.ln();
        sum.1 += sample.weight;
    }
    let mean = |&(sum, weight): &(f64, f64)| (weight > 0.0).then(|| sum / weight);
    let mut logs: Vec<Option<f64>> = sums.iter().map(mean).collect();
    for _ in 0..SPREAD_ROUNDS {
        let mut taken = vec![(0.0, 0.0); count];
        for edge in surface.edges.iter().filter(|e| e.angle() < CREASE) {
            let weight = edge.length + 1e-12 * surface.diagonal;
            for (face, other) in edge.ways() {
                if let (None, Some(log)) = (logs[face], logs[other]) {
                    taken[face].0 += weight * log;
                    taken[face].1 += weight;
                }
            }
        }
        let mut grew = false;
        for (log, taken) in logs.iter_mut().zip(&taken) {
            if log.is_none() {
                *log = mean(taken);
                grew |= log.is_some();
            }
        }
        if !grew {
            break;
        }
    }
    let mut known: Vec<f64> = logs.iter().filter_map(|log| *log).collect();
    known.sort_by(f64::total_cmp);
    let median = known.get(known.len() / 2).copied().unwrap_or(0.0);
    logs.iter().map(|log| log.unwrap_or(median).exp()).collect()
}
