//! Lines of text files as they come: any line end, any 8-bit encoding.

use std::borrow::Cow;

use glam::DVec3;

use super::error::Problem;

/// Splits bytes into lines at LF, CR LF and CR alone; numbers them from 1.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
    done: bool,
}

impl<'a> Lines<'a> {
    /// Lines of a file; a UTF-8 byte order mark at the start is skipped.
    pub(crate) fn new(bytes: &'a [u8]) -> Lines<'a> {
        let rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Lines {
            rest,
            number: 0,
            done: rest.is_empty(),
        }
    }

    /// Bytes not handed out yet.
    pub(crate) fn remaining(&self) -> usize {
        if self.done { 0 } else { self.rest.len() }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let line = match end {
            None => {
                self.done = true;
                self.rest
            }
            Some(end) => {
                let line = &self.rest[..end];
                let pair = self.rest[end..].starts_with(b"\r\n");
                self.rest = &self.rest[end + if pair { 2 } else { 1 }..];
                self.done = self.rest.is_empty();
                line
            }
        };
        Some((self.number, line))
    }
}

/// UTF-8 where it is valid, Latin-1 otherwise; so every byte is a character.
pub(crate) fn decode(text: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(text) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(text.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// Recognises what is often found under a mesh's name but is no mesh.
pub(crate) fn foreign(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = text
        .iter()
        .position(|b| !b.is_ascii_whitespace())
        .unwrap_or(0);
    let text = &text[start..];
    let head: Vec<u8> = text.iter().take(64).map(u8::to_ascii_lowercase).collect();
    if head.starts_with(b"<!doctype html")
        || head.starts_with(b"<html")
        || head.starts_with(b"<head")
    {
        Some("a web page (HTML)")
    } else if head.starts_with(b"<?xml") || head.starts_with(b"<!") {
        Some("an XML file")
    } else if bytes.starts_with(b"PK\x03\x04") {
        Some("a ZIP archive")
    } else if bytes.starts_with(b"\x1f\x8b") {
        Some("a gzip archive")
    } else if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        Some("UTF-16 text (save it as UTF-8)")
    } else if head.starts_with(b"version https://git-lfs") {
        Some("a Git LFS pointer (run `git lfs pull`)")
    } else if head.starts_with(b"iso-10303-21") {
        Some("a STEP file (name it .step)")
    } else {
        None
    }
}

/// Checks that a word is a finite number.
pub(crate) fn finite(word: &str) -> Result<f64, Problem> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Problem::NotFinite {
            word: excerpt(word),
        }),
        Err(_) => Err(Problem::NotANumber {
            word: excerpt(word),
        }),
    }
}

/// The three coordinates of a vertex.
pub(crate) fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<DVec3, Problem> {
    let mut point = DVec3::ZERO;
    for axis in 0..3 {
        let Some(word) = words.next() else {
            let message = "a vertex needs three coordinates".to_owned();
            return Err(Problem::Syntax(message));
        };
        point[axis] = finite(word)?;
    }
    Ok(point)
}

/// Checks that a vertex index is one of the file's.
pub(crate) fn corner(index: i64, vertices: usize) -> Result<u32, Problem> {
    u32::try_from(index)
        .ok()
        .filter(|&corner| (corner as usize) < vertices)
        .ok_or(Problem::IndexOutOfRange {
            index,
            vertices,
            relative: false,
        })
}

/// A word cut to what fits a message.
pub(crate) fn excerpt(word: &str) -> String {
    const LONGEST: usize = 40;
    if word.chars().count() <= LONGEST {
        word.to_owned()
    } else {
        let mut cut: String = word.chars().take(LONGEST).collect();
        cut.push('…');
        cut
    }
}

/// Lower-case hexadecimal digits of bytes.
pub(crate) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_end_counts_once() {
        let lines: Vec<_> = Lines::new(b"\xef\xbb\xbfa\r\nb\rc\n\nd").collect();
        let expected: [(u64, &[u8]); 5] = [(1, b"a"), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")];
        assert_eq!(lines, expected);
        assert_eq!(Lines::new(b"a\n").count(), 1);
        assert_eq!(Lines::new(b"").count(), 0);
    }

    #[test]
    fn bytes_that_are_no_utf8_become_latin_1() {
        assert_eq!(decode(b"R\xfcckwand"), "Rückwand");
        assert_eq!(decode("Rückwand".as_bytes()), "Rückwand");
    }
}
