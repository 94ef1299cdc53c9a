//! STL, binary and ASCII.
//!
//! Whether a file is binary is decided by its size, 84 + 50 n bytes, never by
//! the word `solid`, which binary files start with too. Corners are welded
//! where they are equal to the bit, as the format repeats them per facet.

use glam::DVec3;

use super::loaded::{FacetPlaces, RawMesh};
use crate::io::error::{Located, Place, Problem};
use crate::io::names::FacetNames;
use crate::io::names::NamesBuilder;
use crate::io::text::{Lines, decode, excerpt, point};
use crate::mesh::{TriMesh, weld_exact};

/// Bytes before the first facet: header and count.
const HEADER: usize = 84;
/// Bytes a facet: normal, three corners, attribute word.
const FACET: usize = 50;

/// Facets that the count of a binary file claims.
fn claimed(bytes: &[u8]) -> Option<u64> {
    let count: [u8; 4] = bytes.get(80..HEADER)?.try_into().ok()?;
    Some(u64::from(u32::from_le_bytes(count)))
}

/// Whether the size fits the count of a binary file.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|count| bytes.len() as u64 == HEADER as u64 + FACET as u64 * count)
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    if is_binary(bytes) {
        return parse_binary(bytes);
    }
    if looks_like_text(bytes) {
        return parse_ascii(bytes);
    }
    Err(match claimed(bytes) {
        None => (
            Place::Byte(bytes.len() as u64),
            Problem::Truncated(format!(
                "a binary STL has at least {HEADER} bytes, this file has {}",
                bytes.len()
            )),
        ),
        Some(claimed) => {
            let fit = (bytes.len() - HEADER) / FACET;
            let spare = (bytes.len() - HEADER) % FACET;
            (
                Place::Byte((HEADER + fit * FACET) as u64),
                Problem::LyingCount {
                    what: "facets",
                    claimed,
                    reason: format!(
                        "its {} bytes hold {fit} and {spare} bytes more",
                        bytes.len()
                    ),
                },
            )
        }
    })
}

/// First word `solid` and no control bytes near the start.
fn looks_like_text(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = text.trim_ascii_start();
    let head = &text[..text.len().min(1024)];
    let solid = head.len() >= 5 && head[..5].eq_ignore_ascii_case(b"solid");
    solid
        && !head
            .iter()
            .any(|b| b.is_ascii_control() && !b.is_ascii_whitespace())
}

fn parse_binary(bytes: &[u8]) -> Result<RawMesh, Located> {
    let facets = bytes[HEADER..].chunks_exact(FACET);
    let count = facets.len();
    let mut corners = Vec::with_capacity(3 * count);
    for (index, facet) in facets.enumerate() {
        // Twelve bytes of normal come first: redundant, often zero, not read.
        for (corner, words) in facet[12..48].chunks_exact(12).enumerate() {
            let [x, y, z] = [0, 4, 8].map(|at| {
                let word = [words[at], words[at + 1], words[at + 2], words[at + 3]];
                f64::from(f32::from_le_bytes(word))
            });
            let point = DVec3::new(x, y, z);
            if !point.is_finite() {
                let offset = HEADER + index * FACET + 12 + corner * 12;
                let word = format!("({x}, {y}, {z})");
                return Err((Place::Byte(offset as u64), Problem::NotFinite { word }));
            }
            corners.push(point);
        }
    }
    let places = FacetPlaces::Strided {
        start: HEADER as u64,
        stride: FACET as u64,
    };
    Ok(assemble(&corners, FacetNames::unnamed(count), places))
}

/// Reads `solid … facet normal … outer loop … vertex … endloop … endfacet …
/// endsolid`, any number of solids, any case of letters.
fn parse_ascii(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut names = NamesBuilder::default();
    let mut corners = Vec::new();
    let mut lines = Vec::new();
    let mut state = State::Outside;
    let mut last = 0;
    for (number, raw) in Lines::new(bytes) {
        last = number;
        let place = Place::Line(number);
        let text = decode(raw);
        let text = text.trim();
        let mut words = text.split_whitespace();
        let Some(keyword) = words.next() else {
            continue;
        };
        let keyword = keyword.to_ascii_lowercase();
        state = match (state, keyword.as_str()) {
            (State::Outside, "solid") => {
                let name = text[keyword.len()..].trim();
                names.set_object((!name.is_empty()).then(|| name.to_owned()));
                State::Solid
            }
            (State::Solid, "endsolid") => State::Outside,
            (State::Solid, "facet") => {
                lines.push(number);
                names.push_facet();
                State::Facet
            }
            (State::Facet, "outer") => State::Loop(0),
            (State::Loop(given @ 0..3), "vertex") => {
                let point = point(&mut words);
                corners.push(point.map_err(|problem| (place, problem))?);
                State::Loop(given + 1)
            }
            (State::Loop(3), "vertex") => {
                let message = "a facet with more than three vertices".to_owned();
                return Err((place, Problem::Syntax(message)));
            }
            (State::Loop(3), "endloop") => State::EndLoop,
            (State::Loop(given), "endloop" | "endfacet") => {
                return Err((place, Problem::FewCorners { corners: given }));
            }
            (State::EndLoop, "endfacet") => State::Solid,
            (state, _) => {
                let message = format!(
                    "expected {}, found {:?}",
                    state.expected(),
                    excerpt(&keyword)
                );
                return Err((place, Problem::Syntax(message)));
            }
        };
    }
    if state != State::Outside {
        let message = format!("expected {}, found the end", state.expected());
        return Err((Place::Line(last), Problem::Truncated(message)));
    }
    if corners.len() >= u32::MAX as usize {
        return Err((Place::Whole, Problem::TooMany("vertices")));
    }
    Ok(assemble(
        &corners,
        names.finish(),
        FacetPlaces::Lines(lines),
    ))
}

/// Where the ASCII reader is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Outside,
    Solid,
    Facet,
    /// In a loop, with so many vertices.
    Loop(usize),
    EndLoop,
}

impl State {
    fn expected(self) -> &'static str {
        match self {
            State::Outside => "`solid`",
            State::Solid => "`facet` or `endsolid`",
            State::Facet => "`outer loop`",
            State::Loop(0..3) => "`vertex`",
            State::Loop(_) => "`endloop`",
            State::EndLoop => "`endfacet`",
        }
    }
}

/// Three corners a facet to a welded mesh.
fn assemble(corners: &[DVec3], names: FacetNames, places: FacetPlaces) -> RawMesh {
    let weld = weld_exact(corners);
    let triangles: Vec<[u32; 3]> = weld
        .new_index
        .chunks_exact(3)
        .map(|corner| [corner[0], corner[1], corner[2]])
        .collect();
    RawMesh {
        source: (0..triangles.len() as u32).collect(),
        mesh: TriMesh {
            positions: weld.kept.iter().map(|&old| corners[old as usize]).collect(),
            triangles,
        },
        names,
        places,
        warnings: Vec::new(),
        values: Default::default(),
        unit: None,
    }
}
