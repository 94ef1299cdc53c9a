//! Nastran bulk data: `GRID`, `CTRIA`, `CQUAD`, `PSHELL`, in small, large and
//! free fields. Included files and local coordinates are refused.

use std::borrow::Cow;

use glam::DVec3;

use super::deck::{Deck, whole};
use super::loaded::RawMesh;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, finite};

/// A card: its name and its fields, continuations joined.
struct Card {
    name: String,
    fields: Vec<String>,
    line: u64,
}

impl Card {
    fn field(&self, k: usize) -> &str {
        self.fields.get(k).map_or("", String::as_str)
    }

    fn whole(&self, k: usize) -> Result<i64, Located> {
        whole(self.field(k), self.line)
    }

    /// A real; blank is 0.
    fn real(&self, k: usize) -> Result<f64, Located> {
        match self.field(k) {
            "" => Ok(0.0),
            word => finite(&spelled(word)).map_err(|problem| (Place::Line(self.line), problem)),
        }
    }

    fn refuse(&self, message: &str) -> Located {
        (Place::Line(self.line), Problem::Syntax(message.to_owned()))
    }
}

/// A real with its exponent spelled out: `7.85-9` is `7.85e-9`.
fn spelled(word: &str) -> Cow<'_, str> {
    let exponent = word.char_indices().skip(1).find(|&(at, c)| {
        let before = word[..at].chars().next_back();
        matches!(c, '+' | '-') && before.is_some_and(|b| b.is_ascii_digit() || b == '.')
    });
    match exponent {
        Some((at, _)) => Cow::Owned(format!("{}e{}", &word[..at], &word[at..])),
        None => Cow::Owned(word.replace(['d', 'D'], "e")),
    }
}

/// Fields of a line after the first, and whether it is in large fields.
fn fields(text: &str) -> (String, Vec<String>) {
    let clean = |word: &str| word.trim().to_owned();
    if text.contains(',') {
        let mut words = text.split(',').map(clean);
        let name = words.next().unwrap_or_default();
        return (name, words.take(8).collect());
    }
    let text: Vec<char> = text.chars().collect();
    let cut = |from: usize, to: usize| {
        let part: String = text[from.min(text.len())..to.min(text.len())]
            .iter()
            .collect();
        clean(&part)
    };
    let name = cut(0, 8);
    let (width, count) = if name.contains('*') { (16, 4) } else { (8, 8) };
    let all = (0..count).map(|k| cut(8 + width * k, 8 + width * (k + 1)));
    (name, all.collect())
}

fn cards(bytes: &[u8]) -> Vec<Card> {
    let mut out: Vec<Card> = Vec::new();
    for (line, raw) in Lines::new(bytes) {
        let text = decode(raw);
        let text = text.split('$').next().unwrap_or("").trim_end();
        if text.trim().is_empty() {
            continue;
        }
        let text = text.replace('\t', "        ");
        let (name, mut row) = fields(&text);
        // Every row has its full number of fields, so that the next goes on at
        // the right one.
        row.resize(if name.contains('*') { 4 } else { 8 }, String::new());
        let name = name.trim_end_matches('*').to_ascii_uppercase();
        match out.last_mut() {
            Some(card) if name.is_empty() || name.starts_with('+') => card.fields.extend(row),
            _ => out.push(Card {
                name,
                fields: row,
                line,
            }),
        }
    }
    out
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut deck = Deck::default();
    let mut sections = Vec::new();
    for card in cards(bytes) {
        match card.name.as_str() {
            "GRID" => {
                if !matches!(card.field(1), "" | "0") {
                    return Err(card.refuse("nodes in local coordinates are not read"));
                }
                let at = DVec3::new(card.real(2)?, card.real(3)?, card.real(4)?);
                deck.node(card.whole(0)?, at, card.line)?;
            }
            "CTRIA3" | "CTRIAR" => element(&mut deck, &card, 3, 10, 9)?,
            "CQUAD4" | "CQUADR" => element(&mut deck, &card, 4, 10, 9)?,
            "CTRIA6" => element(&mut deck, &card, 3, 10, 13)?,
            "CQUAD8" => element(&mut deck, &card, 4, 10, 16)?,
            "PSHELL" => sections.push((format!("PID_{}", card.whole(0)?), card.real(2)?)),
            "INCLUDE" => return Err(card.refuse("included files are not read")),
            name if name.starts_with("CTETRA") || name.starts_with("CHEXA") => {
                deck.skip(name, card.line);
            }
            _ => {}
        }
    }
    for (name, thickness) in sections {
        deck.thickness_of_set(&name, thickness);
    }
    deck.finish()
}

/// A shell: `corners` nodes from field 2 on, their thickness from field
/// `thickness` on, unless the flag says that it is relative.
fn element(
    deck: &mut Deck,
    card: &Card,
    corners: usize,
    thickness: usize,
    flag: usize,
) -> Result<(), Located> {
    let nodes = (2..2 + corners)
        .map(|k| card.whole(k))
        .collect::<Result<Vec<i64>, Located>>()?;
    let own = (thickness..thickness + corners)
        .map(|k| card.real(k))
        .collect::<Result<Vec<f64>, Located>>()?;
    let told = own.iter().all(|&t| t > 0.0) && card.field(flag) != "1";
    let property = match card.field(1) {
        "" => card.field(0),
        property => property,
    };
    let name = Some(format!("PID_{property}"));
    deck.shell(nodes, name, if told { own } else { Vec::new() }, card.line);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::spelled;

    #[test]
    fn exponents_without_a_letter() {
        for (word, plain) in [
            ("7.85-9", "7.85e-9"),
            ("-1.5+3", "-1.5e+3"),
            ("1.0D2", "1.0e2"),
            ("-2.", "-2."),
            ("1.e-7", "1.e-7"),
        ] {
            assert_eq!(spelled(word), plain);
        }
    }
}
