//! What the samples of a face say together.

use super::faces::Faces;
use super::probes::Probe;
use super::samples::Sample;
use super::surface::Surface;

/// Means over each face; one entry a face.
#[derive(Clone, Debug)]
pub(super) struct Measures {
    pub area: Vec<f64>,
    /// Area that the face's samples stand for; zero without samples.
    pub weight: Vec<f64>,
    /// Mean score, -1 for a wall to 1 for a coping.
    pub score: Vec<f64>,
    /// Mean log2 of depth over chord.
    pub ratio: Vec<f64>,
    /// Geometric mean of the wall thickness.
    pub thickness: Vec<f64>,
}

impl Measures {
    pub fn of(surface: &Surface, samples: &[Sample], probes: &[Probe], faces: &Faces) -> Measures {
        let count = faces.len();
        let mut area = vec![0.0; count];
        for (triangle, &face) in faces.of.iter().enumerate() {
            area[face as usize] += surface.areas[triangle];
        }
        let mean = |value: fn(&Probe) -> f64| means(samples, faces, probes.iter().map(value));
        let mut weight = vec![0.0; count];
        for sample in samples {
            weight[faces.of(sample.face)] += sample.weight;
        }
        let logs = mean(|probe| probe.thickness.ln());
        let mut known: Vec<f64> = (0..count)
            .filter(|&face| weight[face] > 0.0)
            .map(|face| logs[face])
            .collect();
        known.sort_by(f64::total_cmp);
        let median = known.get(known.len() / 2).copied().unwrap_or(0.0);
        let log = |face: usize| {
            if weight[face] > 0.0 {
                logs[face]
            } else {
                median
            }
        };
        Measures {
            area,
            score: mean(|probe| probe.score),
            ratio: mean(|probe| probe.ratio),
            thickness: (0..count).map(|face| log(face).exp()).collect(),
            weight,
        }
    }
}

/// A wall is thin where it is this many times as wide as thick.
const THIN: f64 = 3.0;

/// Whether a point lies on the side of a thin wall.
pub(super) fn is_thin(probe: &Probe) -> bool {
    probe.ratio < -THIN.log2()
}

/// Median thickness of the thin walls, by area; none without any.
pub(super) fn thin_wall(samples: &[Sample], probes: &[Probe]) -> Option<f64> {
    let pairs = samples.iter().zip(probes);
    let mut thin: Vec<(f64, f64)> = pairs
        .filter(|(_, probe)| is_thin(probe))
        .map(|(sample, probe)| (probe.thickness, sample.weight))
        .collect();
    thin.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * thin.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    let reached = thin.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    reached.map(|(thickness, _)| *thickness)
}

/// Weighted mean over each face; zero without samples.
pub(super) fn means(
    samples: &[Sample],
    faces: &Faces,
    values: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); faces.len()];
    for (sample, value) in samples.iter().zip(values) {
        let sum = &mut sums[faces.of(sample.face)];
        sum.0 += sample.weight * value;
        sum.1 += sample.weight;
    }
    sums.into_iter()
        .map(|(sum, weight)| if weight > 0.0 { sum / weight } else { 0.0 })
        .collect()
}
