//! The line of a tag file that an error is about, as it may be shown.

use std::ops::Range;
use std::path::Path;

use miette::{LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

use crate::settings::quote::{fitted, shown_path};

/// Bytes of the tag file's text.
pub(super) type Span = Range<usize>;

/// Most bytes of each of the three pieces of a line: before the place, the
/// place, and after it.
const PIECE: usize = 60;

/// One line, with the place in it.
#[derive(Debug)]
pub(super) struct Excerpt {
    file: String,
    /// Counted from 0, as the printer wants it.
    line: usize,
    text: String,
    place: SourceSpan,
}

impl Excerpt {
    /// The line where the span starts; the span lies within the text, on
    /// character bounds.
    pub(super) fn new(file: &Path, text: &str, span: Span) -> Excerpt {
        let start = text[..span.start].rfind('\n').map_or(0, |at| at + 1);
        let end = text[span.start..]
            .find('\n')
            .map_or(text.len(), |at| span.start + at);
        let stop = span.end.min(end);
        let before = fitted(&text[start..span.start], PIECE);
        let place = fitted(&text[span.start..stop], PIECE);
        let after = fitted(text[stop..end].trim_end(), PIECE);
        Excerpt {
            file: shown_path(file),
            line: text[..span.start].matches('\n').count(),
            place: (before.len(), place.len()).into(),
            text: [before, place, after].concat(),
        }
    }

    /// Counted from 1.
    pub(super) fn line(&self) -> u64 {
        self.line as u64 + 1
    }

    pub(super) fn label(&self) -> LabeledSpan {
        LabeledSpan::new_with_span(Some("here".to_owned()), self.place)
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let whole = SourceSpan::from(0..self.text.len());
        let (span, column) = if before + after == 0 {
            (*span, span.offset())
        } else {
            (whole, 0)
        };
        let bytes = span.offset()..span.offset() + span.len();
        let data = (self.text.as_bytes().get(bytes)).ok_or(MietteError::OutOfBounds)?;
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            data,
            span,
            self.line,
            column,
            1,
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_is_shown_around_the_place() {
        let line = format!(
            "a = {}BAD\u{1b}[2J{}",
            "x".repeat(100_000),
            "y".repeat(100_000)
        );
        let text = format!("first\n{line}\nlast");
        let at = text.find("BAD").unwrap();
        let excerpt = Excerpt::new("t.toml".as_ref(), &text, at..at + 4);
        assert_eq!(excerpt.line(), 2);
        assert!(excerpt.text.len() <= 3 * PIECE, "{}", excerpt.text);
        let place = excerpt.place.offset()..excerpt.place.offset() + excerpt.place.len();
        assert_eq!(&excerpt.text[place], "BAD\\u{1b}");
    }
}
