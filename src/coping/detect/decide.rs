//! Which faces are coping: the surest first, each decision re-weighing those
//! that asked about it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::faces::{CREASE, Faces, Kind};
use super::measures::Measures;
use super::relations::Relations;
use super::surface::Surface;

/// Weight of: both ends of the chord lie on walls that look away from each
/// other.
const CLOSES: f64 = 2.5;

/// Weight of: one end on a wall, the other on a coping.
const CHAIN: f64 = 1.5;

/// Weight of: narrow, between walls, and beside a coping across an edge from
/// side to side.
const CONTINUES: f64 = 1.0;

/// Those three count if they hold for this share of the face.
const SEEN: f64 = 0.25;

/// The score of convex rounds counts that much: much of a round is as near to
/// its centre as a rim is to the middle of the wall.
const ROUND_TRUST: f64 = 0.25;

/// Without evidence a face is a wall.
const BIAS: f64 = 0.1;

/// Rounds of second thoughts.
const SECOND_THOUGHTS: usize = 5;

/// Share of its border along which a convex round runs smoothly into walls.
const RUNS_IN: f64 = 0.25;

/// Share of its border along which a face runs on into copings, about as straight as
/// chords of a round rim do, from which it is one of them.
const ENCLOSED: f64 = 0.5;

/// Turns that are such, degrees: six chords a full turn.
const CHORDS: f64 = 60.0;

/// Thicknesses of the part's thin walls from which a squarish wall is solid.
const SOLID: f64 = 3.0;

/// Log2 of depth over chord up to which a wall is squarish.
const SQUARISH: f64 = 1.3;

/// What was decided, one entry a face.
#[derive(Clone, Debug)]
pub(super) struct Decision {
    pub coping: Vec<bool>,
    /// What speaks for coping (positive) or wall, from the face and its
    /// neighbours together.
    pub value: Vec<f64>,
    /// The neighbours' part in it.
    pub closure: Vec<f64>,
}

/// Decides on every face; `thin_wall` is the thickness of the part's thin walls,
/// if it has any.
pub(super) fn decide(
    surface: &Surface,
    faces: &Faces,
    measures: &Measures,
    relations: &Relations,
    thin_wall: Option<f64>,
) -> Decision {
    let score = |face: usize| match faces.kinds[face] {
        Kind::Round => ROUND_TRUST * measures.score[face],
        Kind::Flat | Kind::Fillet => measures.score[face],
    };
    let mut judge = Judge {
        measures,
        relations,
        scores: (0..faces.len()).map(score).collect(),
        labels: vec![Label::Open; faces.len()],
    };
    judge.surest_first();
    judge.think_again();
    judge.drop_running_rounds(surface, faces);
    judge.drop_solids(thin_wall);
    judge.fill(surface, faces);
    let area = |face: usize| measures.area[face].max(f64::MIN_POSITIVE);
    let all = 0..faces.len();
    Decision {
        coping: judge.labels.iter().map(|l| *l == Label::Coping).collect(),
        value: all
            .clone()
            .map(|face| judge.weigh(face) / area(face))
            .collect(),
        closure: all.map(|face| judge.closure(face)).collect(),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Label {
    Open,
    Coping,
    Wall,
}

/// What a face runs on into.
#[derive(Clone, Copy)]
struct Run {
    /// Length of its border, and of that along such faces.
    border: f64,
    along: f64,
    /// Area of the largest of them.
    largest: f64,
}

impl Default for Run {
    fn default() -> Run {
        Run {
            border: 0.0,
            along: 0.0,
            largest: f64::NEG_INFINITY,
        }
    }
}

struct Judge<'a> {
    measures: &'a Measures,
    relations: &'a Relations,
    scores: Vec<f64>,
    labels: Vec<Label>,
}

impl Judge<'_> {
    fn label(&self, face: u32) -> Label {
        self.labels[face as usize]
    }

    /// What the faces at the ends of its chords say, once it holds for enough
    /// of the face.
    fn closure(&self, face: usize) -> f64 {
        let corner = &self.relations.corner[face];
        let turns = corner
            .iter()
            .any(|&other| self.label(other) == Label::Coping);
        let turns = if turns { 1.0 } else { 0.0 };
        let (mut told, mut seen) = (0.0, 0.0);
        for between in &self.relations.between[face] {
            let (value, share) = match between.faces.map(|other| self.label(other)) {
                [Label::Wall, Label::Wall] => (
                    CLOSES * between.walls + CONTINUES * turns * between.narrow,
                    between.walls.max(turns * between.narrow),
                ),
                [Label::Wall, Label::Coping] => (CHAIN * between.chained[0], between.chained[0]),
                [Label::Coping, Label::Wall] => (CHAIN * between.chained[1], between.chained[1]),
                _ => continue,
            };
            told += value;
            seen += share;
        }
        if seen >= SEEN { told } else { 0.0 }
    }

    /// Evidence times area: positive for coping.
    fn weigh(&self, face: usize) -> f64 {
        // Who has evidence of his own does not follow smooth neighbours.
        let open = 1.0 - (2.0 * self.scores[face].abs()).min(1.0);
        let pull: f64 = self.relations.smooth[face]
            .iter()
            .map(|&(other, pull)| match self.label(other) {
                Label::Open => 0.0,
                Label::Coping => pull,
                Label::Wall => -pull,
            })
            .sum();
        let own = self.scores[face] + self.closure(face) - BIAS;
        self.measures.area[face] * own + open * pull
    }

    fn surest_first(&mut self) {
        let entry = |judge: &Self, face: usize| Entry {
            sureness: judge.weigh(face).abs(),
            face,
        };
        let mut heap: BinaryHeap<Entry> = (0..self.labels.len())
            .map(|face| entry(self, face))
            .collect();
        while let Some(Entry { sureness, face }) = heap.pop() {
            if self.labels[face] != Label::Open {
                continue;
            }
            let value = self.weigh(face);
            if value.abs() < sureness * (1.0 - 1e-12) {
                heap.push(entry(self, face));
                continue;
            }
            self.labels[face] = sided(value);
            for &other in &self.relations.asked_by[face] {
                if self.label(other) == Label::Open {
                    heap.push(entry(self, other as usize));
                }
            }
        }
    }

    fn think_again(&mut self) {
        for _ in 0..SECOND_THOUGHTS {
            let mut changed = false;
            for face in 0..self.labels.len() {
                let label = sided(self.weigh(face));
                changed |= label != self.labels[face];
                self.labels[face] = label;
            }
            if !changed {
                break;
            }
        }
    }

    /// A convex round that runs smoothly into a wall is no coping: a sheet
    /// fades in a full round, and needs no flat end there.
    fn drop_running_rounds(&mut self, surface: &Surface, faces: &Faces) {
        let runs = self.runs_into(surface, faces, CREASE, Label::Wall);
        for (face, run) in runs.iter().enumerate() {
            if faces.kinds[face] == Kind::Round && run.along > RUNS_IN * run.border {
                self.labels[face] = Label::Wall;
            }
        }
    }

    /// A facet among copings is one of them: of a rim whose triangles are few and lie
    /// freely, each is a face of its own, and chords across it see but its
    /// neighbours.
    fn fill(&mut self, surface: &Surface, faces: &Faces) {
        let runs = self.runs_into(surface, faces, CHORDS, Label::Coping);
        for (face, run) in runs.iter().enumerate() {
            if self.labels[face] == Label::Wall
                && faces.kinds[face] == Kind::Flat
                && run.largest >= self.measures.area[face]
                && run.along >= ENCLOSED * run.border
            {
                self.labels[face] = Label::Coping;
            }
        }
    }

    /// How each face runs on into faces of a label, across edges that turn by less than
    /// `turn` degrees.
    fn runs_into(&self, surface: &Surface, faces: &Faces, turn: f64, label: Label) -> Vec<Run> {
        let mut runs = vec![Run::default(); faces.len()];
        for edge in &surface.edges {
            let [a, b] = edge.faces.map(|t| faces.of(t));
            if a == b {
                continue;
            }
            for (face, other) in [(a, b), (b, a)] {
                let run = &mut runs[face];
                run.border += edge.length;
                if edge.angle() < turn && self.labels[other] == label {
                    run.along += edge.length;
                    run.largest = run.largest.max(self.measures.area[other]);
                }
            }
        }
        runs
    }

    /// What is much thicker than the part's thin walls, and hardly wider than
    /// thick, is the solid that they stand on.
    fn drop_solids(&mut self, thin_wall: Option<f64>) {
        let Some(thin) = thin_wall else { return };
        for face in 0..self.labels.len() {
            let thick = self.measures.thickness[face] > SOLID * thin;
            if self.labels[face] == Label::Coping && thick && self.measures.ratio[face] < SQUARISH {
                self.labels[face] = Label::Wall;
            }
        }
    }
}

fn sided(value: f64) -> Label {
    if value > 0.0 {
        Label::Coping
    } else {
        Label::Wall
    }
}

/// A face and how sure it is; the surest comes first, of equals the lowest.
struct Entry {
    sureness: f64,
    face: usize,
}

impl Ord for Entry {
    fn cmp(&self, other: &Entry) -> Ordering {
        let by_sureness = self.sureness.total_cmp(&other.sureness);
        by_sureness.then(other.face.cmp(&self.face))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Entry) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}
