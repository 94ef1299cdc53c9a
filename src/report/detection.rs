//! What to say of a detection of coping faces.

use serde_json::{Value, json};

use crate::coping::detect::{DetectedFace, Detection};
use crate::coping::ranges;

/// Verdict and faces, with scores and reasons: `result` of the report.
pub fn account(detection: &Detection) -> Value {
    json!({
        "verdict": detection.verdict(),
        "thin_share": detection.thin_share,
        "samples": detection.samples,
        "faces": detection.faces.iter().map(face_json).collect::<Vec<_>>(),
    })
}

fn face_json(face: &DetectedFace) -> Value {
    json!({
        "face": face.number,
        "coping": face.coping,
        "score": face.score,
        "by_neighbours": face.by_neighbours,
        "doubt": face.doubt,
        "reasons": face.reasons,
        "kind": face.kind,
        "area": face.area,
        "thickness": face.thickness,
        "min": face.bounds.min,
        "max": face.bounds.max,
        "triangles": ranges(&face.triangles),
    })
}
