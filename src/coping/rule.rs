//! What a tag file says, before it is held against a mesh.

use glam::DVec3;

use super::error::{Located, Span, TagProblem};

/// A whole tag file.
#[derive(Debug, Default)]
pub(super) struct TagFile {
    pub(super) mesh: MeshCheck,
    pub(super) on_empty: OnEmpty,
    pub(super) rest: Rest,
    pub(super) rules: Vec<Rule>,
}

/// What the mesh must be; each part is checked when present.
#[derive(Debug, Default)]
pub(super) struct MeshCheck {
    pub(super) facets: Option<(u64, Span)>,
    pub(super) sha256: Option<(String, Span)>,
    pub(super) geometry: Option<(String, Span)>,
}

/// What to do about a rule that selects nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum OnEmpty {
    #[default]
    Error,
    Warn,
    Ignore,
}

/// What a triangle is that no rule speaks of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Rest {
    #[default]
    Wall,
    /// What the detector says.
    Auto,
}

/// Conditions that must all hold, and what then follows.
#[derive(Debug)]
pub(super) struct Rule {
    pub(super) name: String,
    /// True makes coping, false takes back to wall.
    pub(super) coping: bool,
    /// Not empty.
    pub(super) conditions: Vec<Condition>,
    pub(super) span: Span,
}

/// A set of triangles.
#[derive(Debug)]
pub(super) enum Condition {
    /// Facets of the file by index.
    Facets(Vec<FacetRange>),
    /// Facets with a name that fits one of the patterns.
    Names {
        kind: NameKind,
        patterns: Vec<(String, Span)>,
    },
    /// Triangles in a plane: all corners within `tolerance`, normal within
    /// `max_angle` degrees of the plane's, either way round.
    Plane {
        point: DVec3,
        /// Unit length.
        normal: DVec3,
        /// Part units; `None` stands for a millionth of the mesh's diagonal.
        tolerance: Option<f64>,
        max_angle: f64,
    },
    /// Triangles in an axis-parallel box.
    Box {
        min: DVec3,
        max: DVec3,
        mode: BoxMode,
    },
    /// The triangle nearest to a point, and its neighbours on across edges
    /// that bend by no more than `grow_angle` degrees.
    Near {
        point: DVec3,
        grow_angle: f64,
        max_area: Option<f64>,
        span: Span,
    },
}

/// `first..=last` in steps, 0-based.
#[derive(Debug)]
pub(super) struct FacetRange {
    pub(super) first: u64,
    pub(super) last: u64,
    pub(super) step: u64,
    pub(super) span: Span,
}

/// Which names a pattern is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NameKind {
    Any,
    Group,
    Object,
    Material,
}

/// When a triangle counts as in a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum BoxMode {
    /// All corners.
    #[default]
    All,
    /// At least one corner.
    Any,
    /// The centroid.
    Centroid,
}

/// Reads `12`, `40-57` or `40-57:2` (every second), counted from `base`.
pub(super) fn facet_range(word: &str, base: u64, span: Span) -> Result<FacetRange, Located> {
    let bad = || TagProblem::NotARange {
        word: word.to_owned(),
    };
    let number = |text: &str| -> Result<u64, Located> {
        let text = text.trim();
        if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
            return Err((span.clone(), bad()));
        }
        text.parse().map_err(|_| (span.clone(), bad()))
    };
    let (range, step) = match word.split_once(':') {
        Some((range, step)) => (range, number(step)?),
        None => (word, 1),
    };
    let (first, last) = match range.split_once('-') {
        Some((first, last)) => (number(first)?, number(last)?),
        None => {
            let only = number(range)?;
            (only, only)
        }
    };
    if step == 0 {
        return Err((span, bad()));
    }
    if first > last {
        return Err((span, TagProblem::BackwardRange { first, last }));
    }
    let Some(shifted) = first.checked_sub(base) else {
        return Err((span, TagProblem::BelowBase { base }));
    };
    Ok(FacetRange {
        first: shifted,
        last: last - base,
        step,
        span,
    })
}
