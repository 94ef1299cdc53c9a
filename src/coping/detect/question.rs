//! Faces in doubt, as questions that a person can answer.

use super::doubt::Reason;
use super::verdict::Verdict;
use super::{DetectedFace, Detection};

/// Faces of more doubt are asked about.
pub const ASK: f64 = 0.35;

/// Faces alike, and what is to be decided about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Places in [`Detection::faces`], ascending; the first stands for all.
    pub faces: Vec<usize>,
    /// What was decided for now.
    pub coping: bool,
    /// Greatest doubt of the faces.
    pub doubt: f64,
    /// What the doubt comes from, gravest first; at most two.
    pub reasons: Vec<Reason>,
}

/// What makes faces alike: the decision, the reasons, and sizes within a
/// quarter of an octave.
type Likeness = (bool, Vec<Reason>, i64, i64);

fn likeness(face: &DetectedFace) -> Likeness {
    let size =
        |value: f64, steps: f64| (steps * value.max(f64::MIN_POSITIVE).log2()).round() as i64;
    let reasons = face.reasons.iter().take(2).copied().collect();
    (
        face.coping,
        reasons,
        size(face.area, 3.0),
        size(face.thickness, 4.0),
    )
}

impl DetectedFace {
    /// Whether a face taken for wall might close one.
    pub fn looks_like_a_rim(&self) -> bool {
        let signs = [Reason::RimLike, Reason::TwoMinds, Reason::Cut];
        self.doubt > ASK && self.reasons.iter().any(|reason| signs.contains(reason))
    }
}

impl Detection {
    /// The faces in doubt, alike ones together, gravest first: doubt times the
    /// root of the area.
    pub fn questions(&self) -> Vec<Question> {
        if matches!(self.verdict(), Verdict::NoThinWall | Verdict::Open) {
            // What the part is comes first.
            return Vec::new();
        }
        let mut groups: Vec<(Likeness, Vec<usize>)> = Vec::new();
        for (index, face) in self.faces.iter().enumerate() {
            if face.doubt <= ASK {
                continue;
            }
            let like = likeness(face);
            match groups.iter_mut().find(|(other, _)| *other == like) {
                Some((_, faces)) => faces.push(index),
                None => groups.push((like, vec![index])),
            }
        }
        let mut questions: Vec<(f64, Question)> = groups
            .into_iter()
            .map(|((coping, reasons, _, _), faces)| {
                let doubts = faces.iter().map(|&face| self.faces[face].doubt);
                let doubt = doubts.fold(0.0, f64::max);
                let area: f64 = faces.iter().map(|&face| self.faces[face].area).sum();
                let question = Question {
                    faces,
                    coping,
                    doubt,
                    reasons,
                };
                (doubt * area.sqrt(), question)
            })
            .collect();
        questions.sort_by(|(a, p), (b, q)| b.total_cmp(a).then(p.faces.cmp(&q.faces)));
        questions
            .into_iter()
            .map(|(_, question)| question)
            .collect()
    }
}
