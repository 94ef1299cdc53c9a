//! Name patterns: `*` for any run of characters, `?` for one.

use std::str::Chars;

/// What stands before the first `*` or `?`: a name that fits begins with it.
pub(super) fn literal_start(pattern: &str) -> &str {
    &pattern[..pattern.find(['*', '?']).unwrap_or(pattern.len())]
}

/// Whether the whole name fits the pattern; letters count by case.
pub(super) fn fits(pattern: &str, name: &str) -> bool {
    let (mut pattern, mut name) = (pattern.chars(), name.chars());
    // What follows the last star, and what it has not taken of the name.
    let mut star: Option<(Chars, Chars)> = None;
    loop {
        let mut rest = name.clone();
        let Some(letter) = rest.next() else {
            return pattern.all(|c| c == '*');
        };
        let mut after = pattern.clone();
        match after.next() {
            Some('*') => {
                star = Some((after.clone(), name.clone()));
                pattern = after;
            }
            Some(c) if c == '?' || c == letter => (pattern, name) = (after, rest),
            _ => match &mut star {
                Some((after, left)) => {
                    left.next();
                    (pattern, name) = (after.clone(), left.clone());
                }
                None => return false,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn stars_and_question_marks() {
        for (pattern, name, expected) in [
            ("rim", "rim", true),
            ("rim", "Rim", false),
            ("rim_*", "rim_12", true),
            ("rim_*", "rim", false),
            ("*", "", true),
            ("edge?", "edge7", true),
            ("edge?", "edge17", false),
            ("*a*b", "xaxbxb", true),
            ("*a*b", "xaxbxc", false),
            ("?", "ü", true),
            ("", "", true),
            ("", "a", false),
        ] {
            assert_eq!(fits(pattern, name), expected, "{pattern} {name}");
        }
    }
}
