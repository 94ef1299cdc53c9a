//! Abaqus and CalculiX decks: nodes, shell elements, their sets and thickness.
//!
//! Read are `*NODE`, `*ELEMENT` of shells, `*NODAL THICKNESS` and the thickness
//! of `*SHELL SECTION`. Parts, instances and included files are not followed.

use glam::DVec3;

use super::deck::{Deck, whole};
use super::loaded::RawMesh;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, excerpt, finite};

/// What data lines mean.
enum Mode {
    Skip,
    Node,
    /// Corners, nodes in all, set.
    Shell(usize, usize, Option<String>),
    Other(String),
    NodalThickness,
    /// The set whose thickness the next line tells.
    Section(String),
}

/// Corners and nodes of a shell element, if it is one.
fn shell(kind: &str) -> Option<(usize, usize)> {
    match kind {
        "S3" | "S3R" | "STRI3" | "S3RS" | "M3D3" | "CPS3" | "R3D3" => Some((3, 3)),
        "S6" | "STRI65" | "M3D6" => Some((3, 6)),
        "S4" | "S4R" | "S4R5" | "S4RS" | "M3D4" | "R3D4" => Some((4, 4)),
        "S8" | "S8R" | "S8R5" | "M3D8" => Some((4, 8)),
        _ => None,
    }
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut deck = Deck::default();
    let mut mode = Mode::Skip;
    // Numbers of an element that goes on over several lines.
    let mut pending: Vec<i64> = Vec::new();
    for (line, raw) in Lines::new(bytes) {
        let text = decode(raw);
        let text = text.trim();
        if text.is_empty() || text.starts_with("**") {
            continue;
        }
        if let Some(keyword) = text.strip_prefix('*') {
            pending.clear();
            mode = keyword_line(keyword, line)?;
            continue;
        }
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        match &mode {
            Mode::Skip => {}
            Mode::Other(kind) => deck.skip(kind, line),
            Mode::Node => {
                let mut at = DVec3::ZERO;
                for k in 0..3 {
                    let word = words.get(k + 1).copied().unwrap_or("");
                    if !word.is_empty() {
                        at[k] = finite(word).map_err(|problem| (Place::Line(line), problem))?;
                    }
                }
                deck.node(whole(words[0], line)?, at, line)?;
            }
            Mode::Shell(corners, nodes, name) => {
                for word in words.iter().filter(|w| !w.is_empty()) {
                    pending.push(whole(word, line)?);
                }
                if pending.len() > *nodes {
                    let own = pending[1..=*corners].to_vec();
                    deck.shell(own, name.clone(), Vec::new(), line);
                    pending.clear();
                }
            }
            Mode::NodalThickness => {
                // A set in place of a number is passed over: nodes without a
                // thickness are seen later.
                if let (Ok(node), Some(word)) = (words[0].parse(), words.get(1)) {
                    let t = finite(word).map_err(|problem| (Place::Line(line), problem))?;
                    deck.thickness(node, t);
                }
            }
            Mode::Section(set) => {
                let t = finite(words[0]).map_err(|problem| (Place::Line(line), problem))?;
                deck.thickness_of_set(set, t);
                mode = Mode::Skip;
            }
        }
    }
    deck.finish()
}

fn keyword_line(keyword: &str, line: u64) -> Result<Mode, Located> {
    let mut words = keyword.split(',').map(str::trim);
    let name = words.next().unwrap_or("").to_ascii_uppercase();
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    let parameters: Vec<(String, String)> = words
        .map(|word| {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            (
                key.trim().to_ascii_uppercase(),
                value.trim().to_ascii_uppercase(),
            )
        })
        .collect();
    let value = |key: &str| {
        let found = parameters.iter().find(|p| p.0 == key);
        found.map(|p| p.1.clone())
    };
    Ok(match name.as_str() {
        "NODE" => Mode::Node,
        "ELEMENT" => {
            let kind = value("TYPE").unwrap_or_default();
            match shell(&kind) {
                Some((corners, nodes)) => Mode::Shell(corners, nodes, value("ELSET")),
                None => Mode::Other(excerpt(&kind)),
            }
        }
        "NODAL THICKNESS" => Mode::NodalThickness,
        "SHELL SECTION" if value("NODAL THICKNESS").is_none() => {
            value("ELSET").map_or(Mode::Skip, Mode::Section)
        }
        "INCLUDE" => {
            let message = "included files are not read; put all in one file".to_owned();
            return Err((Place::Line(line), Problem::Syntax(message)));
        }
        _ => Mode::Skip,
    })
}
