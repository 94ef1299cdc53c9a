//! Where coping tags come from, and what to say of those that were detected.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::coping::detect::{Detection, Verdict};
use crate::coping::{Sliver, ranges};
use serde::{Serialize, Serializer};

use crate::settings::quote::{figure, shown_path};
use crate::settings::warning::Warning;

/// Questions that a command lists before the list is cut short.
const QUESTIONS_SHOWN: usize = 5;

/// Ranges of triangles that a message names before the list is cut short.
const RANGES_SHOWN: usize = 8;

/// Where coping tags come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CopingSource {
    /// The program finds them.
    Auto,
    /// Every triangle is wall.
    None,
    /// A tag file.
    File(PathBuf),
    /// One flag a triangle: true for coping.
    Flags(Vec<bool>),
}

impl CopingSource {
    /// The tag file, if there is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            CopingSource::File(file) => Some(file),
            _ => None,
        }
    }
}

impl From<OsString> for CopingSource {
    fn from(text: OsString) -> CopingSource {
        match text.to_str() {
            Some("auto") => CopingSource::Auto,
            Some("none") => CopingSource::None,
            _ => CopingSource::File(text.into()),
        }
    }
}

impl Serialize for CopingSource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            CopingSource::Auto => serializer.serialize_str("auto"),
            CopingSource::None => serializer.serialize_str("none"),
            CopingSource::Flags(_) => serializer.serialize_str("flags"),
            CopingSource::File(file) => serializer.serialize_str(&file.to_string_lossy()),
        }
    }
}

/// What a detection leaves to say: about the part as a whole, and doubts.
pub fn detection_warnings(detection: &Detection, part: &Path) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let part = shown_path(part);
    if let Some(words) = detection.verdict().text() {
        let code = match detection.verdict() {
            Verdict::ClosedShell => "closed_shell",
            Verdict::LittleThinWall => "little_thin_wall",
            Verdict::NoThinWall => "no_thin_wall",
            Verdict::Open => "open_detection",
            Verdict::Tagged => "tagged",
        };
        let message = format!("{part}: {words}");
        warnings.push(Warning::new(code, message));
    }
    let questions = detection.questions();
    for question in questions.iter().take(QUESTIONS_SHOWN) {
        warnings.push(Warning::new(
            "coping_doubt",
            format!("{part}: {}", question.text(detection)),
        ));
    }
    if questions.len() > QUESTIONS_SHOWN {
        warnings.push(Warning::new(
            "coping_doubts",
            format!(
                "{part}: {} more questions; `midsurf tags detect` lists them",
                questions.len() - QUESTIONS_SHOWN
            ),
        ));
    }
    warnings
}

/// What was done about a strip that nobody tagged.
pub fn sliver_words(sliver: &Sliver, source: &[u32]) -> String {
    let [x, y, z] = sliver.at.to_array().map(figure);
    format!(
        "triangles {} at ({x}, {y}, {z}) are a strip {} wide between coping faces that no tag names: taken for coping too",
        shown_ranges(&facets(source, &sliver.triangles)),
        figure(sliver.width)
    )
}

/// Facets of the file that triangles come from, ascending: what tags and people
/// count in.
pub fn facets(source: &[u32], triangles: &[u32]) -> Vec<u32> {
    let mut facets: Vec<u32> = triangles.iter().map(|&t| source[t as usize]).collect();
    facets.dedup();
    facets
}

/// The first ranges of a list of triangles.
pub fn shown_ranges(triangles: &[u32]) -> String {
    let ranges = ranges(triangles);
    let more = if ranges.len() > RANGES_SHOWN {
        ", …"
    } else {
        ""
    };
    let first: Vec<_> = ranges.into_iter().take(RANGES_SHOWN).collect();
    format!("{}{more}", first.join(", "))
}
