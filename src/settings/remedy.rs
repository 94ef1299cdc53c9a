//! What to do about an error.
//!
//! A remedy stands at the error, in clauses that may each name a flag, since
//! several commands can meet it. Whoever shows it keeps the clauses that the
//! user at hand can follow.

/// The clauses of a help text, set apart by semicolons, that name no flag but
/// these; none if none is left.
pub fn fitting<S: AsRef<str>>(help: &str, flags: &[S]) -> Option<String> {
    let known =
        |clause: &&str| named(clause).all(|flag| flags.iter().any(|own| own.as_ref() == flag));
    let clauses: Vec<&str> = help.split("; ").filter(known).collect();
    (!clauses.is_empty()).then(|| clauses.join("; "))
}

/// Flags that a text names, without their dashes; those of a whole command, as in
/// `midsurf tags PART --list` between backquotes, are that command's own.
fn named(text: &str) -> impl Iterator<Item = &str> {
    let pieces = text.split('`').enumerate();
    let own = pieces.filter(|(n, piece)| n % 2 == 0 || !piece.starts_with("midsurf "));
    own.flat_map(|(_, piece)| {
        piece.split("--").skip(1).map(|rest| {
            let end = rest.find(|c: char| !(c.is_ascii_lowercase() || c == '-'));
            &rest[..end.unwrap_or(rest.len())]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::fitting;

    #[test]
    fn help_names_only_flags_of_the_command() {
        let help =
            "close the holes; try --weld with a small length; --allow-open goes on, but not well";
        let flags = |names: &[&str]| {
            names
                .iter()
                .map(|&name| name.to_owned())
                .collect::<Vec<_>>()
        };
        let told = |names| fitting(help, &flags(names));
        assert_eq!(told(&["weld", "allow-open"]).as_deref(), Some(help));
        assert_eq!(told(&[]).as_deref(), Some("close the holes"));
        let some = "close the holes; try --weld with a small length";
        assert_eq!(told(&["weld", "open"]).as_deref(), Some(some));
        assert_eq!(fitting("take a smaller --cell", &flags(&["cells"])), None);
        let other = "make it with `midsurf extract PART --shard 2/3`";
        assert_eq!(fitting(other, &flags(&[])).as_deref(), Some(other));
        assert_eq!(fitting("take `--cell 1`", &flags(&[])), None);
        let shrink = "a negative one (--distance=-2) to shrink";
        let told = fitting(shrink, &flags(&["distance"]));
        assert_eq!(told.as_deref(), Some(shrink));
    }
}
