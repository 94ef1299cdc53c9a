//! How sure each decision is, and why not.

use super::cut;
use super::decide::Decision;
use super::faces::{Faces, Kind};
use super::measures::{Measures, means};
use super::probes::Probe;
use super::samples::{SMOOTH, Sample};
use super::surface::Surface;

/// Doubts below this are not worth a word.
const WORTH_SAYING: f64 = 0.1;

/// Why a face may have been decided wrongly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Little speaks for either.
    Weak,
    /// Coping because of what lies beside it; its own proportions do not say
    /// so.
    ByNeighbours,
    /// The wall behind it is hardly longer than thick.
    Squarish,
    /// Behind it stands a post or a pin rather than a wall.
    Post,
    /// The wall behind it is shorter than thick.
    Stub,
    /// Looks like a rim, but no wall of that thickness lies behind it.
    RimLike,
    /// A convex round, part of which looks like a rim.
    Round,
    /// Rim in one place, wall in another.
    TwoMinds,
    /// Was cut out of a larger face.
    Cut,
    /// One of the two walls that it should close is coping.
    SideIsCoping,
    /// The wall opposite is coping.
    OppositeIsCoping,
}

impl Reason {
    /// In words, about "it", the face.
    pub fn text(self) -> &'static str {
        match self {
            Reason::Weak => "little speaks for either",
            Reason::ByNeighbours => {
                "only what lies beside it speaks for coping, not its own proportions"
            }
            Reason::Squarish => "the wall behind it is hardly longer than thick",
            Reason::Post => "behind it stands a post or a pin rather than a wall",
            Reason::Stub => "the wall behind it is shorter than thick",
            Reason::RimLike => "it looks like a rim, but no wall of that thickness lies behind it",
            Reason::Round => "it is a convex round, and part of it looks like a rim",
            Reason::TwoMinds => "it is rim in one place and wall in another",
            Reason::Cut => "it was cut out of a larger face",
            Reason::SideIsCoping => "one of the two walls that it should close is coping itself",
            Reason::OppositeIsCoping => "the face opposite, across the wall, is coping",
        }
    }
}

/// Doubt about one face.
#[derive(Clone, Debug, Default)]
pub(super) struct Doubt {
    /// The gravest.
    pub amount: f64,
    /// Gravest first.
    pub reasons: Vec<Reason>,
}

/// All that doubts look at.
pub(super) struct Seen<'a> {
    pub surface: &'a Surface,
    pub samples: &'a [Sample],
    pub probes: &'a [Probe],
    pub faces: &'a Faces,
    pub measures: &'a Measures,
    pub decision: &'a Decision,
    /// Faces that were cut from others; the last ones.
    pub added: usize,
}

/// Shares of a face for which something holds; one entry a face.
struct Shares {
    rim: Vec<f64>,
    wall: Vec<f64>,
    ended: Vec<f64>,
    post: Vec<f64>,
    stub: Vec<f64>,
    rim_like: Vec<f64>,
    side: Vec<f64>,
    opposite: Vec<f64>,
    /// Of its sharp border, what is concave.
    concave: Vec<f64>,
}

/// Share of the border that is concave up to which a face may be closed by convex
/// edges on both sides, and from which it is a step for sure: half of the border of
/// a strip that has a concave edge along one side.
const STEP: [f64; 2] = [0.3, 0.4];

impl Seen<'_> {
    /// One entry a face.
    pub fn doubts(&self) -> Vec<Doubt> {
        let shares = self.shares();
        (0..self.faces.len())
            .map(|face| {
                let mut graded = self.graded(face, &shares);
                graded.retain(|(amount, _)| *amount > WORTH_SAYING);
                if self.measures.weight[face] == 0.0 {
                    graded.clear();
                }
                graded.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
                Doubt {
                    amount: graded.first().map_or(0.0, |(amount, _)| *amount),
                    reasons: graded.into_iter().map(|(_, reason)| reason).collect(),
                }
            })
            .collect()
    }

    fn shares(&self) -> Shares {
        let probes = || self.probes.iter();
        let flag = |holds: bool| if holds { 1.0 } else { 0.0 };
        let mean =
            |value: &dyn Fn(&Probe) -> f64| means(self.samples, self.faces, probes().map(value));
        let coping = |triangle: u32| self.decision.coping[self.faces.of(triangle)];
        let beside = self.beside();
        let side = |(sample, probe): (&Sample, &Probe)| {
            let own = self.faces.of(sample.face);
            let tagged = |triangle: u32| {
                let other = self.faces.of(triangle);
                let pair = (own.min(other), own.max(other));
                coping(triangle) && other != own && beside.binary_search(&pair).is_err()
            };
            flag(probe.score > 0.0 && probe.sides.is_some_and(|s| s.into_iter().any(tagged)))
        };
        let opposite =
            |probe: &Probe| flag(probe.score < 0.0 && probe.opposite.is_some_and(coping));
        Shares {
            rim: mean(&|p| flag(p.score > 0.3)),
            wall: mean(&|p| flag(p.score < -0.3)),
            ended: mean(&|p| flag(p.closed || p.across.is_some())),
            post: mean(&|p| 1.0 - p.plate),
            stub: mean(&|p| flag(p.score > 0.0 && !p.goes_on)),
            rim_like: mean(&|p| flag(p.ratio > 0.3 && p.closed)),
            side: means(
                self.samples,
                self.faces,
                self.samples.iter().zip(self.probes).map(side),
            ),
            opposite: mean(&opposite),
            concave: self.concave(),
        }
    }

    fn concave(&self) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.faces.len()];
        for edge in self.surface.edges.iter().filter(|e| e.angle() >= SMOOTH) {
            let [a, b] = edge.faces.map(|t| self.faces.of(t));
            if a == b {
                continue;
            }
            for face in [a, b] {
                let (concave, whole) = &mut sums[face];
                *whole += edge.length;
                if edge.bend < 0.0 {
                    *concave += edge.length;
                }
            }
        }
        let share = |(concave, whole): (f64, f64)| concave / whole.max(f64::MIN_POSITIVE);
        sums.into_iter().map(share).collect()
    }

    /// Pairs of faces with a common edge, sorted.
    fn beside(&self) -> Vec<(usize, usize)> {
        let pair = |edge: &super::surface::Edge| {
            let [a, b] = edge.faces.map(|t| self.faces.of(t));
            (a.min(b), a.max(b))
        };
        let mut pairs: Vec<_> = self.surface.edges.iter().map(pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn graded(&self, face: usize, shares: &Shares) -> Vec<(f64, Reason)> {
        let score = self.measures.score[face];
        let round = self.faces.kinds[face] == Kind::Round;
        // Evidence of half a point is sure.
        let open = 1.0 - (2.0 * self.decision.value[face].abs()).min(1.0);
        let mut graded = Vec::new();
        if self.decision.coping[face] {
            graded.push((open, Reason::Weak));
            if score < 0.1 {
                let amount = 0.4 + 0.5 * (-score).clamp(0.0, 1.0);
                graded.push((amount, Reason::ByNeighbours));
            }
            let squarish = ((1.2 - self.measures.ratio[face]) / 1.2).clamp(0.0, 1.0);
            graded.push((squarish, Reason::Squarish));
            graded.push((shares.post[face], Reason::Post));
            let stub = (1.5 * shares.stub[face] - 0.5).clamp(0.0, 1.0);
            graded.push((stub, Reason::Stub));
            graded.push((shares.side[face], Reason::SideIsCoping));
        } else {
            // A step, with a concave edge on one side, is a wall for sure.
            let convex = ((STEP[1] - shares.concave[face]) / (STEP[1] - STEP[0])).clamp(0.0, 1.0);
            let ended = shares.ended[face] * convex;
            let weak = open * (0.2 + 1.6 * ended).clamp(0.0, 1.0);
            graded.push((weak, Reason::Weak));
            if round {
                graded.push(((2.0 * shares.rim[face]).min(0.6), Reason::Round));
            } else {
                graded.push((shares.rim_like[face], Reason::RimLike));
            }
            graded.push((shares.opposite[face], Reason::OppositeIsCoping));
        }
        let (up, down) = (shares.rim[face], shares.wall[face]);
        if !round && up.min(down) > 0.05 {
            let against = if self.decision.coping[face] { down } else { up };
            graded.push(((2.0 * against).min(1.0), Reason::TwoMinds));
        }
        if face >= self.faces.len() - self.added {
            graded.push((cut::DOUBT, Reason::Cut));
        }
        graded
    }
}
