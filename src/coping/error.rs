//! Why a tag file could not be used: where, what, and what to do.

use std::fmt;
use std::path::{Path, PathBuf};

use miette::{Diagnostic, LabeledSpan, SourceCode};
use thiserror::Error;

use super::excerpt::Excerpt;
pub(super) use super::excerpt::Span;
use crate::io::Problem;
use crate::settings::quote::{bounded, quoted, shown, shown_path};

/// A problem and the text it is about.
pub(super) type Located = (Span, TagProblem);

/// What is wrong with a tag file, or between it and the mesh.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum TagProblem {
    /// The file as such.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Unread(Problem),
    /// The grammar is broken.
    #[error("{}", bounded(.0))]
    #[diagnostic(help("correct the file at this place"))]
    Syntax(String),
    /// A statement of the text form that is none.
    #[error(
        "{} is no tag: expected a triangle index, a range a-b, or `group: NAME`",
        quoted(word)
    )]
    #[diagnostic(help("write `12`, `40-57` or `group: rim_*`; `#` starts a comment"))]
    NotATag {
        /// What stands there.
        word: String,
    },
    /// Text that looks like the TOML form.
    #[error("this looks like the TOML form of tags, but the file's name does not end in .toml")]
    #[diagnostic(help("rename the file to end in .toml"))]
    TomlInText,
    /// No index and no range.
    #[error("{} is no triangle index or range", quoted(word))]
    #[diagnostic(help("write `12`, `40-57`, or `40-57:2` for every second"))]
    NotARange {
        /// What stands there.
        word: String,
    },
    /// A range whose end comes first.
    #[error("the range {first}-{last} runs backwards")]
    #[diagnostic(help("put the lower index first"))]
    BackwardRange {
        /// Start as written.
        first: u64,
        /// End as written.
        last: u64,
    },
    /// Index 0 where counting starts at 1.
    #[error("index 0 cannot occur when indices count from {base}")]
    #[diagnostic(help("correct the index, or set index_base = 0"))]
    BelowBase {
        /// First index.
        base: u64,
    },
    /// An index past the mesh's facets.
    #[error("triangle {index} does not exist: the mesh has {facets} (0 to {})", facets.saturating_sub(1))]
    #[diagnostic(help(
        "indices count the `f` lines of an OBJ or the facets of an STL from 0; check that the tags belong to this mesh"
    ))]
    OutOfRange {
        /// 0-based index.
        index: u64,
        /// Facets of the mesh.
        facets: usize,
    },
    /// A value that makes no sense.
    #[error("{}", bounded(.0))]
    #[diagnostic(help("correct the value"))]
    BadValue(String),
    /// A rule without a condition.
    #[error(
        "the rule {} has no condition, so it would select everything",
        quoted(rule)
    )]
    #[diagnostic(help("add `triangles`, `group`, `object`, `material`, `plane`, `box` or `near`"))]
    NoCondition {
        /// The rule.
        rule: String,
    },
    /// A rule that selects nothing.
    #[error("the rule {} selects no triangle", quoted(rule))]
    #[diagnostic(help("{}", empty_remedy(*scaled)))]
    SelectsNothing {
        /// The rule.
        rule: String,
        /// See [`super::Coping::scaled`].
        scaled: Option<f64>,
    },
    /// A pattern that no name fits.
    #[error("no {kind} name of the mesh fits {}{known}", quoted(pattern))]
    #[diagnostic(help("`midsurf info PART` lists the names of a mesh"))]
    NoSuchName {
        /// Kind of name.
        kind: &'static str,
        /// The pattern.
        pattern: String,
        /// Names there are, for the message.
        known: String,
    },
    /// A flood fill that ran away.
    #[error(
        "the flood fill of the rule {} passed its largest area {max_area}: it reached {area:.6} with {triangles} triangles",
        quoted(rule)
    )]
    #[diagnostic(help(
        "lower grow_angle so that it stops at the edge of the face, or raise max_area"
    ))]
    FloodTooLarge {
        /// The rule.
        rule: String,
        /// Area allowed.
        max_area: f64,
        /// Area reached.
        area: f64,
        /// Triangles reached.
        triangles: usize,
    },
    /// The tags belong to another mesh.
    #[error(
        "these tags are for another mesh: {what} should be {}, but {} has {found}",
        shown(expected),
        shown(mesh)
    )]
    #[diagnostic(help(
        "use the mesh that the tags were made for, or check the tags against this one and update [mesh]"
    ))]
    OtherMesh {
        /// What differs.
        what: &'static str,
        /// Value in the tag file.
        expected: String,
        /// Value of the mesh.
        found: String,
        /// The mesh's file.
        mesh: String,
    },
}

/// Why a tag file could not be used.
#[derive(Debug)]
pub struct TagError(Box<Inner>);

#[derive(Debug)]
struct Inner {
    file: PathBuf,
    problem: TagProblem,
    excerpt: Option<Excerpt>,
}

fn empty_remedy(scaled: Option<f64>) -> String {
    let check = "check its conditions with `midsurf tags PART TAGS`, or set on_empty = \"warn\" under [options]";
    match scaled {
        Some(factor) => format!(
            "the part seems to be in other units than the tags: --scale {factor} on the part; {check}"
        ),
        None => check.to_owned(),
    }
}

impl TagError {
    pub(super) fn whole(file: &Path, problem: TagProblem) -> TagError {
        TagError(Box::new(Inner {
            file: file.to_owned(),
            problem,
            excerpt: None,
        }))
    }

    pub(super) fn at(file: &Path, text: &str, (span, problem): Located) -> TagError {
        TagError(Box::new(Inner {
            file: file.to_owned(),
            problem,
            excerpt: Some(Excerpt::new(file, text, clamp(text, span))),
        }))
    }

    /// The tag file.
    pub fn file(&self) -> &Path {
        &self.0.file
    }

    /// Line of the tag file, counted from 1.
    pub fn line(&self) -> Option<u64> {
        self.0.excerpt.as_ref().map(Excerpt::line)
    }

    /// What is wrong.
    pub fn problem(&self) -> &TagProblem {
        &self.0.problem
    }
}

/// Keeps a span inside the text and on character bounds.
fn clamp(text: &str, span: Span) -> Span {
    let floor = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = floor(span.start);
    start..floor(span.end).max(start)
}

impl fmt::Display for TagError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = shown_path(&self.0.file);
        match self.line() {
            Some(line) => write!(f, "{file}, line {line}: {}", self.0.problem),
            None => write!(f, "{file}: {}", self.0.problem),
        }
    }
}

impl std::error::Error for TagError {}

impl Diagnostic for TagError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.0.problem.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        let excerpt = self.0.excerpt.as_ref()?;
        Some(excerpt)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.0.excerpt.as_ref()?;
        Some(Box::new(std::iter::once(excerpt.label())))
    }
}
