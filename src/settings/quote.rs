//! What came from outside, for messages.
//!
//! Names, words and paths of files are not ours: they may be of any length,
//! and may hold what would move a terminal's cursor or set its title. Here they
//! are escaped, and cut in the middle; nothing else shows them to people.
//! Reports as JSON keep them whole. Numbers are shown without noise.

use std::path::Path;

/// Most bytes of a word or a name in a message.
const WORD: usize = 200;

/// Most bytes of a path in a message.
const PATH: usize = 400;

/// Most bytes of a whole message.
pub const MESSAGE: usize = 2000;

/// What stands for what was cut out.
const GAP: &str = " … ";

/// A word or a name, to stand in a sentence.
pub fn shown(text: &str) -> String {
    fitted(text, WORD)
}

/// The same within so many bytes.
pub fn fitted(text: &str, most: usize) -> String {
    cut(&escaped(&cut(text, most)), most)
}

/// The same in quotes.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", shown(text).replace('"', "\\\""))
}

/// A path; what is no Unicode in it is replaced.
pub fn shown_path(path: &Path) -> String {
    fitted(&path.to_string_lossy(), PATH)
}

/// A whole message, of lines.
pub fn bounded(message: &str) -> String {
    let head = cut(message, 2 * MESSAGE);
    let lines: Vec<String> = head.split('\n').map(escaped).collect();
    cut(&lines.join("\n"), MESSAGE)
}

/// A number to seven significant digits, without noise.
pub fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    // Shortest decimal of the value rounded to seven digits.
    match format!("{value:.6e}").parse::<f64>() {
        Ok(rounded) if (1e-4..1e12).contains(&rounded.abs()) => format!("{rounded}"),
        Ok(rounded) => format!("{rounded:e}"),
        Err(_) => format!("{value}"),
    }
}

/// Control characters, marks of direction and all else that does not print as
/// escapes; quotes and backslashes stay.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for piece in text.split_inclusive(['"', '\'', '\\']) {
        let end = piece.len() - usize::from(piece.ends_with(['"', '\'', '\\']));
        out.extend(piece[..end].escape_debug());
        out.push_str(&piece[end..]);
    }
    out
}

/// Head and tail of what is longer than so many bytes.
fn cut(text: &str, most: usize) -> String {
    if text.len() <= most {
        return text.to_owned();
    }
    let half = most.saturating_sub(GAP.len()) / 2;
    let mut head = half;
    while !text.is_char_boundary(head) {
        head -= 1;
    }
    let mut tail = text.len() - half;
    while !text.is_char_boundary(tail) {
        tail += 1;
    }
    format!("{}{GAP}{}", &text[..head], &text[tail..])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn plain_text_stays() {
        for text in [
            "rim_12",
            "C:\\parts\\a.obj",
            "Flansch Ø 12",
            "it's \"a\"",
            "e\u{301}",
        ] {
            assert_eq!(shown(text), text);
        }
        assert_eq!(quoted("a\"b"), "\"a\\\"b\"");
    }

    #[test]
    fn what_moves_a_terminal_is_escaped() {
        assert_eq!(shown("\u{1b}]0;title\u{7}"), "\\u{1b}]0;title\\u{7}");
        assert_eq!(shown("a\nb\r"), "a\\nb\\r");
        assert_eq!(shown("\u{202e}gnp.exe"), "\\u{202e}gnp.exe");
        assert_eq!(bounded("a\nb\u{9b}2J"), "a\nb\\u{9b}2J");
    }

    #[test]
    fn what_is_long_is_cut_in_the_middle() {
        let long = format!("head{}tail", "x".repeat(3_000_000));
        let told = shown(&long);
        assert!(told.len() <= WORD && told.starts_with("head") && told.ends_with("tail"));
        assert!(told.contains(GAP));
        assert!(bounded(&long).len() <= MESSAGE);
        let path = shown_path(Path::new(&long));
        assert!(path.len() <= PATH && path.ends_with("tail"));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn nothing_is_too_long_and_nothing_controls(text in "\\PC*|.*|(\u{1b}|\n|é|x){0,3000}") {
            prop_assert!(shown(&text).len() <= WORD);
            prop_assert!(bounded(&text).len() <= MESSAGE);
            prop_assert!(!shown(&text).chars().any(char::is_control));
            prop_assert!(!bounded(&text).chars().any(|c| c.is_control() && c != '\n'));
        }
    }
}
