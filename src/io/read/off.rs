//! OFF, ASCII: header word, counts, vertices, faces, `#` comments.

use super::loaded::{FacetPlaces, RawMesh};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::FacetNames;
use crate::io::text::{Lines, corner, decode, excerpt, point};

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut rows = Lines::new(bytes).filter_map(|(number, raw)| {
        let text = decode(raw);
        let words: Vec<String> = text
            .split('#')
            .next()
            .unwrap_or("")
            .split_whitespace()
            .map(str::to_owned)
            .collect();
        (!words.is_empty()).then_some((Place::Line(number), words))
    });
    let ended = |what: &str| {
        let message = format!("{what} missing");
        (Place::Byte(bytes.len() as u64), Problem::Truncated(message))
    };

    let (place, mut first) = rows.next().ok_or_else(|| ended("header"))?;
    // The header word may be left out, and the counts may follow it directly.
    let header = first[0].to_ascii_uppercase();
    let counts = if header.ends_with("OFF") {
        if header.contains('4') || header.contains('N') && header != "NOFF" {
            let message = format!("{:?} is not three-dimensional", excerpt(&first[0]));
            return Err((place, Problem::Syntax(message)));
        }
        first.remove(0);
        if first.iter().any(|word| word.eq_ignore_ascii_case("binary")) {
            let message = "binary OFF is not read; write it as text".to_owned();
            return Err((place, Problem::Syntax(message)));
        }
        if first.is_empty() {
            rows.next().ok_or_else(|| ended("line of counts"))?
        } else {
            (place, first)
        }
    } else if first[0].parse::<u64>().is_ok() {
        (place, first)
    } else {
        let message = "an OFF file starts with the word OFF".to_owned();
        return Err((place, Problem::Syntax(message)));
    };
    let (place, counts) = counts;
    let count = |at: usize| -> Result<usize, Located> {
        let word = counts.get(at).map_or("", String::as_str);
        word.parse().map_err(|_| {
            let message = format!("{:?} is not a count", excerpt(word));
            (place, Problem::Syntax(message))
        })
    };
    let (vertices, faces) = (count(0)?, count(1)?);
    // A vertex takes six bytes at least, a face eight.
    let needed = (vertices as u128) * 6 + (faces as u128) * 8;
    if needed > bytes.len() as u128 + 16 {
        let problem = Problem::LyingCount {
            what: "vertices and faces",
            claimed: (vertices as u64).saturating_add(faces as u64),
            reason: format!("it has only {} bytes", bytes.len()),
        };
        return Err((place, problem));
    }

    let mut positions = Vec::with_capacity(vertices);
    for _ in 0..vertices {
        let (place, words) = rows.next().ok_or_else(|| ended("vertices are"))?;
        let point = point(words.iter().map(String::as_str));
        positions.push(point.map_err(|problem| (place, problem))?);
    }
    let mut sink = FacetSink::with_capacity(faces);
    let mut lines = Vec::with_capacity(faces);
    let mut corners = Vec::new();
    for _ in 0..faces {
        let (place, words) = rows.next().ok_or_else(|| ended("faces are"))?;
        let number = |word: &String| -> Result<i64, Located> {
            let bad = || Problem::NotAnIndex {
                word: excerpt(word),
            };
            word.parse().map_err(|_| (place, bad()))
        };
        let arity = number(&words[0])?;
        let arity = usize::try_from(arity).unwrap_or(0);
        if arity < 3 {
            return Err((place, Problem::FewCorners { corners: arity }));
        }
        if words.len() - 1 < arity {
            let message = format!("{arity} corners announced, {} given", words.len() - 1);
            return Err((place, Problem::Truncated(message)));
        }
        corners.clear();
        // Colours may follow the corners.
        for word in &words[1..=arity] {
            let index = number(word)?;
            let corner = corner(index, positions.len());
            corners.push(corner.map_err(|problem| (place, problem))?);
        }
        sink.push(&corners, &positions, place)?;
        if let Place::Line(line) = place {
            lines.push(line);
        }
    }
    let facets = sink.facet_count() as usize;
    Ok(sink.finish(
        positions,
        FacetNames::unnamed(facets),
        FacetPlaces::Lines(lines),
        Vec::new(),
    ))
}
