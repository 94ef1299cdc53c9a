//! What faces say of each other.
//!
//! A face between two walls that look away from each other is the end of what
//! stands between them, whatever its own proportions; so is a chamfer between a
//! wall and a rim, and a rim that goes on round a corner.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use super::faces::{CREASE, Faces};
use super::measures::Measures;
use super::probes::{Across, LEAN, Probe, far};
use super::samples::SMOOTH;
use super::samples::Sample;
use super::surface::Surface;

/// Pull of a smooth neighbour, in edge length times thickness, where the
/// surface does not bend at all.
const ATTRACT: f64 = 0.5;

/// Widths, in thicknesses of the wall, up to which a face between a wall and a
/// coping is taken for a chamfer or a step.
const CHAIN_WIDTH: f64 = 1.2;

/// Length of an edge, in widths of the face, that spans it from side to side.
const SPAN: [f64; 2] = [0.5, 2.5];

/// Cosine between such an edge and the face's chords.
const SPAN_ALONG: f64 = 0.6;

/// Two faces, each the end of the other's wall, whose scores differ by less,
/// are those of a bar as wide as thick: neither closes the other.
const TIE: f64 = 0.3;

/// Share of a face for which another one is at the end of its chords.
const SEES: f64 = 0.25;

/// For which share of a face two others are at the ends of its chords.
#[derive(Clone, Copy, Debug)]
pub(super) struct Between {
    pub faces: [u32; 2],
    /// Both ends, taken as walls, tell the face to be coping.
    pub walls: f64,
    /// One end, taken as wall, does, if the other is coping.
    pub chained: [f64; 2],
    /// It is narrow there.
    pub narrow: f64,
}

/// All that is known of each face's neighbours.
#[derive(Debug, Default)]
pub(super) struct Relations {
    /// Smooth neighbours and their pull.
    pub smooth: Vec<Vec<(u32, f64)>>,
    pub between: Vec<Vec<Between>>,
    /// Faces beside, across an edge that spans the face from side to side.
    pub corner: Vec<Vec<u32>>,
    /// Faces that ask about a face: whose value changes with it.
    pub asked_by: Vec<Vec<u32>>,
}

impl Relations {
    pub fn find(
        surface: &Surface,
        samples: &[Sample],
        probes: &[Probe],
        faces: &Faces,
        measures: &Measures,
    ) -> Relations {
        let seen = Seen {
            surface,
            samples,
            probes,
            faces,
            measures,
        };
        let mut between = seen.between();
        seen.drop_ties(&mut between);
        let mut relations = Relations {
            smooth: seen.smooth(),
            between,
            corner: seen.corners(),
            asked_by: vec![Vec::new(); faces.len()],
        };
        for face in 0..faces.len() {
            let asker = face as u32;
            let smooth = relations.smooth[face].iter().map(|&(other, _)| other);
            let ends = relations.between[face].iter().flat_map(|b| b.faces);
            let corner = relations.corner[face].iter().copied();
            for other in smooth.chain(ends).chain(corner) {
                relations.asked_by[other as usize].push(asker);
            }
        }
        for askers in &mut relations.asked_by {
            askers.sort_unstable();
            askers.dedup();
        }
        relations
    }
}

struct Seen<'a> {
    surface: &'a Surface,
    samples: &'a [Sample],
    probes: &'a [Probe],
    faces: &'a Faces,
    measures: &'a Measures,
}

impl Seen<'_> {
    fn smooth(&self) -> Vec<Vec<(u32, f64)>> {
        let mut pulls: BTreeMap<(u32, u32), f64> = BTreeMap::new();
        for edge in self.surface.edges.iter().filter(|e| e.angle() < CREASE) {
            let [a, b] = edge.faces.map(|t| self.faces.of[t as usize]);
            if a != b {
                let pull = ATTRACT * (1.0 - edge.angle() / CREASE) * edge.length;
                *pulls.entry((a.min(b), a.max(b))).or_default() += pull;
            }
        }
        let mut smooth = vec![Vec::new(); self.faces.len()];
        for ((a, b), pull) in pulls {
            let thickness = |face: u32| self.measures.thickness[face as usize];
            let pull = pull * thickness(a).min(thickness(b));
            smooth[a as usize].push((b, pull));
            smooth[b as usize].push((a, pull));
        }
        smooth
    }

    /// Samples that see their face from side to side, with their face's share.
    fn narrow(&self) -> impl Iterator<Item = (usize, f64, &Across, f64)> {
        self.samples
            .iter()
            .zip(self.probes)
            .filter_map(|(sample, probe)| {
                let face = self.faces.of(sample.face);
                let share = sample.weight / self.measures.weight[face];
                probe
                    .across
                    .as_ref()
                    .map(|across| (face, share, across, probe.plate))
            })
    }

    fn between(&self) -> Vec<Vec<Between>> {
        let mut rows: BTreeMap<(usize, [u32; 2]), [f64; 4]> = BTreeMap::new();
        for (face, share, across, plate) in self.narrow() {
            let ends = across.ends.map(|end| self.faces.of[end.face as usize]);
            if ends.contains(&(face as u32)) {
                continue;
            }
            let told = self.told(across, plate, ends);
            if told.iter().any(|&t| t > 0.0) {
                let row = rows.entry((face, ends)).or_default();
                for (sum, t) in row.iter_mut().zip(told) {
                    *sum += share * t;
                }
            }
        }
        let mut between = vec![Vec::new(); self.faces.len()];
        for ((face, faces), [walls, first, second, narrow]) in rows {
            between[face].push(Between {
                faces,
                walls,
                chained: [first, second],
                narrow,
            });
        }
        between
    }

    /// Which side of a square bar came first would be chance.
    fn drop_ties(&self, between: &mut [Vec<Between>]) {
        let sees = |face: usize, other: u32| {
            let rows = between[face].iter();
            let seen = rows.filter(|row| row.faces.contains(&other));
            seen.map(|row| row.walls).sum::<f64>() >= SEES
        };
        let score = |face: usize| self.measures.score[face];
        let tied = |face: usize, side: u32| {
            (score(face) - score(side as usize)).abs() < TIE
                && sees(face, side)
                && sees(side as usize, face as u32)
        };
        let tied: Vec<Vec<bool>> = (0..between.len())
            .map(|face| {
                let rows = between[face].iter();
                rows.map(|row| row.faces.iter().any(|&side| tied(face, side)))
                    .collect()
            })
            .collect();
        for (rows, tied) in between.iter_mut().zip(tied) {
            let mut tied = tied.into_iter();
            rows.retain(|_| !tied.next().unwrap_or(false));
        }
    }

    /// How much both ends, the first, the second tell, and whether a wall stands
    /// upright behind both.
    fn told(&self, across: &Across, plate: f64, faces: [u32; 2]) -> [f64; 4] {
        let [a, b] = &across.ends;
        let stands = across.is_upright() && a.stands && b.stands;
        let walls = if stands && across.opposed {
            plate * far(a.along.min(b.along), a.thickness.max(b.thickness))
        } else {
            0.0
        };
        let chained = [0, 1].map(|i| {
            let end = &across.ends[i];
            let thickness = self.measures.thickness[faces[i] as usize];
            if across.width <= CHAIN_WIDTH * thickness && end.lean >= LEAN {
                far(end.along, across.width)
            } else {
                0.0
            }
        });
        [walls, chained[0], chained[1], f64::from(stands)]
    }

    fn corners(&self) -> Vec<Vec<u32>> {
        let count = self.faces.len();
        let mut weights = vec![0.0; count];
        let mut logs = vec![0.0; count];
        let mut spans = vec![DMat3::ZERO; count];
        for (face, share, across, _) in self.narrow() {
            weights[face] += share;
            logs[face] += share * across.width.ln();
            let d = across.direction;
            spans[face] += share * DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        }
        // Length of the edges between two faces, and of it what runs along the
        // chords of the first.
        let mut sums: BTreeMap<(usize, usize), [f64; 2]> = BTreeMap::new();
        for edge in self.surface.edges.iter().filter(|e| e.angle() >= SMOOTH) {
            let [a, b] = edge.faces.map(|t| self.faces.of(t));
            if a == b || edge.length == 0.0 {
                continue;
            }
            for (face, other) in [(a, b), (b, a)] {
                if weights[face] > 0.0 {
                    let along: DVec3 = spans[face] * edge.along / weights[face];
                    let sum = sums.entry((face, other)).or_default();
                    sum[0] += edge.length;
                    sum[1] += edge.along.dot(along) / edge.length;
                }
            }
        }
        let mut corner = vec![Vec::new(); count];
        for ((face, other), [length, along]) in sums {
            let width = (logs[face] / weights[face]).exp();
            let spans = (SPAN[0] * width..=SPAN[1] * width).contains(&length);
            if spans && along >= SPAN_ALONG * length {
                corner[face].push(other as u32);
            }
        }
        corner
    }
}
