//! PLY, ASCII and binary, element by element through ply-rs-bw.
//!
//! The crate parses header and elements; index range, finiteness and the
//! plausibility of counts are checked here, and the place of every element
//! in the file is kept.

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::bytes::room;
use super::loaded::{FacetPlaces, PlyValues, RawMesh};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::FacetNames;
use crate::io::text::{Lines, corner, decode, excerpt, finite};
use crate::settings::quote::quoted;

/// Numbers of a vertex and of an edge that are read: the point, the ends, and
/// what a mid-surface has besides.
const PROPERTIES: [&str; 8] = [
    "x",
    "y",
    "z",
    "thickness",
    "radius",
    "kind",
    "vertex1",
    "vertex2",
];

/// A vertex or an edge.
#[derive(Debug, Default)]
struct Numbers([Option<f64>; PROPERTIES.len()]);

impl Numbers {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        let Some(place) = PROPERTIES.iter().position(|known| *known == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[place] = Some(value);
        PropertyAccessResult::Set
    }

    fn point(&self) -> DVec3 {
        let [x, y, z, ..] = self.0.map(Option::unwrap_or_default);
        DVec3::new(x, y, z)
    }
}

impl PropertyAccess for Numbers {
    fn new() -> Self {
        Numbers::default()
    }
    fn set_char(&mut self, name: &str, value: i8) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_uchar(&mut self, name: &str, value: u8) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_short(&mut self, name: &str, value: i16) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_ushort(&mut self, name: &str, value: u16) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_int(&mut self, name: &str, value: i32) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_uint(&mut self, name: &str, value: u32) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_float(&mut self, name: &str, value: f32) -> PropertyAccessResult {
        self.set(name, value.into())
    }
    fn set_double(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        self.set(name, value)
    }
}

#[derive(Debug, Default)]
struct Face {
    corners: Vec<i64>,
}

impl Face {
    fn set<T: Into<i64>>(&mut self, name: &str, values: Vec<T>) -> PropertyAccessResult {
        if !is_corner_list(name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = values.into_iter().map(Into::into).collect();
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }
    fn set_list_char(&mut self, name: &str, values: Vec<i8>) -> PropertyAccessResult {
        self.set(name, values)
    }
    fn set_list_uchar(&mut self, name: &str, values: Vec<u8>) -> PropertyAccessResult {
        self.set(name, values)
    }
    fn set_list_short(&mut self, name: &str, values: Vec<i16>) -> PropertyAccessResult {
        self.set(name, values)
    }
    fn set_list_ushort(&mut self, name: &str, values: Vec<u16>) -> PropertyAccessResult {
        self.set(name, values)
    }
    fn set_list_int(&mut self, name: &str, values: Vec<i32>) -> PropertyAccessResult {
        self.set(name, values)
    }
    fn set_list_uint(&mut self, name: &str, values: Vec<u32>) -> PropertyAccessResult {
        self.set(name, values)
    }
}

fn is_corner_list(name: &str) -> bool {
    name == "vertex_indices" || name == "vertex_index"
}

/// Whether edges say what they are, in whole numbers, as those of a mid-surface
/// do.
fn has_kinds(edge: &ElementDef) -> bool {
    let has = |name: &&str| {
        let property = edge.properties.get(*name);
        let PropertyType::Scalar(scalar) = property.map(|p| &p.data_type)? else {
            return None;
        };
        (!matches!(scalar, ScalarType::Float | ScalarType::Double)).then_some(())
    };
    ["vertex1", "vertex2", "kind"]
        .iter()
        .all(|name| has(name).is_some())
}

/// An element of no interest: read over.
#[derive(Debug, Default)]
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Skipped
    }
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    if !bytes.starts_with(b"ply") {
        let message = "a PLY file starts with the line `ply`".to_owned();
        return Err((Place::Line(1), Problem::Syntax(message)));
    }
    // Old Macintosh line ends: only in a text file without any line feed.
    if bytes.get(3) == Some(&b'\r') && !bytes.contains(&b'\n') {
        let unix: Vec<u8> = bytes
            .iter()
            .map(|&b| if b == b'\r' { b'\n' } else { b })
            .collect();
        return Body::parse(&unix);
    }
    Body::parse(bytes)
}

/// The file after its header.
struct Body<'a> {
    header: &'a Header,
    bytes: &'a [u8],
    rest: &'a [u8],
    lines: Lines<'a>,
    header_lines: u64,
}

impl<'a> Body<'a> {
    fn parse(bytes: &'a [u8]) -> Result<RawMesh, Located> {
        let mut reader = Reader::new(bytes);
        let header = Parser::<Skipped>::new()
            .read_header(&mut reader)
            .map_err(|error| {
                let line = error.line().unwrap_or(reader.line()).max(1) as u64;
                (Place::Line(line), Problem::Syntax(in_one_line(&error)))
            })?;
        let rest = reader.into_inner();
        let start = bytes.len() - rest.len();
        let mut body = Body {
            header: &header,
            bytes,
            rest,
            lines: Lines::new(rest),
            header_lines: bytes[..start].iter().filter(|&&b| b == b'\n').count() as u64,
        };
        body.read()
    }

    fn is_ascii(&self) -> bool {
        self.header.encoding == Encoding::Ascii
    }

    fn read(&mut self) -> Result<RawMesh, Located> {
        let header = self.header;
        check_header(header)?;
        let mut positions = Vec::new();
        let mut values = PlyValues::default();
        let mut faces: Vec<(Place, Vec<i64>)> = Vec::new();
        let mut edges: Vec<(Place, [i64; 2])> = Vec::new();
        for (name, element) in &header.elements {
            self.check_count(element)?;
            match name.as_str() {
                "vertex" => {
                    room(&mut positions, element.count)?;
                    for _ in 0..element.count {
                        let (place, vertex) = self.element::<Numbers>(element)?;
                        // check_header has seen x, y and z.
                        let point = vertex.point();
                        if !point.is_finite() {
                            let word = format!("({}, {}, {})", point.x, point.y, point.z);
                            return Err((place, Problem::NotFinite { word }));
                        }
                        positions.push(point);
                        let [_, _, _, thickness, radius, kind, ..] = vertex.0;
                        values.thickness.extend(thickness);
                        values.radius.extend(radius);
                        values.kind.extend(kind);
                    }
                }
                "face" => {
                    room(&mut faces, element.count)?;
                    for _ in 0..element.count {
                        let (place, face) = self.element::<Face>(element)?;
                        // At once, lest a file of nothing but short lists
                        // takes many times its size.
                        let corners = face.corners.len();
                        if corners < 3 {
                            return Err((place, Problem::FewCorners { corners }));
                        }
                        faces.push((place, face.corners));
                    }
                }
                "edge" if has_kinds(element) => {
                    room(&mut values.edges, element.count)?;
                    for _ in 0..element.count {
                        let (place, edge) = self.element::<Numbers>(element)?;
                        let [.., kind, from, to] = edge.0.map(Option::unwrap_or_default);
                        edges.push((place, [from as i64, to as i64]));
                        values.edges.push(([0; 2], kind));
                    }
                }
                _ => {
                    for _ in 0..element.count {
                        self.element::<Skipped>(element)?;
                    }
                }
            }
        }
        // Edges may come before the vertices.
        for ((ends, _), (place, given)) in values.edges.iter_mut().zip(edges) {
            for (end, index) in ends.iter_mut().zip(given) {
                *end = corner(index, positions.len()).map_err(|problem| (place, problem))?;
            }
        }
        let mut sink = FacetSink::with_capacity(faces.len());
        let mut offsets = Vec::with_capacity(faces.len());
        let mut corners = Vec::new();
        for (place, face) in &faces {
            corners.clear();
            for &index in face {
                let corner = corner(index, positions.len());
                corners.push(corner.map_err(|problem| (*place, problem))?);
            }
            sink.push(&corners, &positions, *place)?;
            offsets.push(match *place {
                Place::Line(number) | Place::Byte(number) => number,
                Place::Whole => 0,
            });
        }
        let places = if self.is_ascii() {
            FacetPlaces::Lines(offsets)
        } else {
            FacetPlaces::Bytes(offsets)
        };
        let mut raw = sink.finish(
            positions,
            FacetNames::unnamed(faces.len()),
            places,
            Vec::new(),
        );
        raw.values = values;
        Ok(raw)
    }

    /// Refuses counts that the bytes left cannot hold, before anything is
    /// reserved for them.
    fn check_count(&self, element: &ElementDef) -> Result<(), Located> {
        let least = if self.is_ascii() {
            // A digit and a blank or line end for each property.
            2 * element.properties.len().max(1) - 1
        } else {
            let least = element
                .properties
                .iter()
                .map(|(_, p)| least_size(&p.data_type));
            least.sum()
        };
        let left = if self.is_ascii() {
            self.lines.remaining()
        } else {
            self.rest.len()
        };
        if least == 0 && element.count > 0 {
            let message = format!("the element {:?} has no properties", excerpt(&element.name));
            return Err((Place::Whole, Problem::Syntax(message)));
        }
        if least > 0 && element.count > left.div_ceil(least) {
            let what = match element.name.as_str() {
                "vertex" => "vertices",
                "face" => "faces",
                _ => "elements",
            };
            return Err((
                Place::Byte((self.bytes.len() - left) as u64),
                Problem::LyingCount {
                    what,
                    claimed: element.count as u64,
                    reason: format!("only {left} bytes are left for them"),
                },
            ));
        }
        Ok(())
    }

    /// The next element and its place.
    fn element<E: PropertyAccess>(&mut self, element: &ElementDef) -> Result<(Place, E), Located> {
        let parser = Parser::<E>::new();
        if self.is_ascii() {
            loop {
                let Some((number, raw)) = self.lines.next() else {
                    return Err((Place::Byte(self.bytes.len() as u64), truncated(element)));
                };
                let place = Place::Line(self.header_lines + number);
                let text = decode(raw);
                if text.trim().is_empty() {
                    continue;
                }
                let row = check_row(&text, element).map_err(|problem| (place, problem))?;
                return parser
                    .read_ascii_element(&row, element)
                    .map(|value| (place, value))
                    .map_err(|error| (place, Problem::Syntax(in_one_line(&error))));
            }
        }
        let offset = Place::Byte((self.bytes.len() - self.rest.len()) as u64);
        let result = match self.header.encoding {
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.rest, element),
            _ => parser.read_little_endian_element(&mut self.rest, element),
        };
        result.map(|value| (offset, value)).map_err(|error| {
            if error.kind() == std::io::ErrorKind::UnexpectedEof {
                (offset, truncated(element))
            } else {
                (offset, Problem::Syntax(in_one_line(&error)))
            }
        })
    }
}

/// Checks a row of text and puts its numbers as the parser wants them, which
/// takes neither `.5` nor `1.`.
///
/// Refuses rows longer than the header says, which the parser would cut: they
/// are rows of another element, so the counts are wrong.
fn check_row(text: &str, element: &ElementDef) -> Result<String, Problem> {
    let mut row = String::with_capacity(text.len());
    let mut given = 0;
    for word in text.split_whitespace() {
        finite(word)?;
        given += 1;
        if !row.is_empty() {
            row.push(' ');
        }
        match word.split_once('.') {
            Some((whole, fraction)) => {
                row.push_str(whole);
                if !whole.ends_with(|c: char| c.is_ascii_digit()) {
                    row.push('0');
                }
                row.push('.');
                if !fraction.starts_with(|c: char| c.is_ascii_digit()) {
                    row.push('0');
                }
                row.push_str(fraction);
            }
            None => row.push_str(word),
        }
    }
    let scalar = |data_type: &PropertyType| matches!(data_type, PropertyType::Scalar(_));
    let fixed = element.properties.iter().all(|(_, p)| scalar(&p.data_type));
    let announced = element.properties.len();
    if fixed && given > announced {
        return Err(Problem::Syntax(format!(
            "{given} values where the header announces {announced} for an element {:?}",
            excerpt(&element.name)
        )));
    }
    Ok(row)
}

fn truncated(element: &ElementDef) -> Problem {
    Problem::Truncated(format!(
        "{} elements {:?} were announced",
        element.count,
        excerpt(&element.name)
    ))
}

fn check_header(header: &Header) -> Result<(), Located> {
    let fail = |message: String| Err((Place::Whole, Problem::Syntax(message)));
    for (name, element) in &header.elements {
        for (property, definition) in &element.properties {
            if let PropertyType::List(ScalarType::Float | ScalarType::Double, _) =
                definition.data_type
            {
                return fail(format!(
                    "the list {} of the element {} has a count declared as floating point",
                    quoted(property),
                    quoted(name)
                ));
            }
        }
    }
    let Some(vertex) = header.elements.get("vertex") else {
        return fail("the header names no element `vertex`".to_owned());
    };
    for axis in ["x", "y", "z"] {
        match vertex.properties.get(axis).map(|p| &p.data_type) {
            Some(PropertyType::Scalar(_)) => {}
            _ => return fail(format!("vertices have no scalar property `{axis}`")),
        }
    }
    let Some(face) = header.elements.get("face") else {
        return Err((
            Place::Whole,
            Problem::NoFaces {
                vertices: vertex.count,
            },
        ));
    };
    let mut lists = face
        .properties
        .iter()
        .filter(|(name, _)| is_corner_list(name));
    match lists.next().map(|(_, p)| &p.data_type) {
        Some(PropertyType::List(_, ScalarType::Float | ScalarType::Double)) => {
            fail("the vertex indices of faces are declared as floating point".to_owned())
        }
        Some(PropertyType::List(..)) => Ok(()),
        _ => fail(
            "faces have no list property `vertex_indices` or `vertex_index`; triangle strips are not read"
                .to_owned(),
        ),
    }
}

/// Bytes that a property takes at least.
fn least_size(data_type: &PropertyType) -> usize {
    let scalar = match data_type {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => scalar,
    };
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The parser's message without its line breaks and debug dumps.
fn in_one_line(error: &ply_rs_bw::parser::ParseError) -> String {
    let text = error.to_string();
    let text = text
        .split_once(": ")
        .filter(|(start, _)| start.starts_with("Line "))
        .map_or(text.as_str(), |(_, rest)| rest);
    let mut message = String::new();
    for piece in text.split_whitespace() {
        if !message.is_empty() {
            message.push(' ');
        }
        message.push_str(piece);
    }
    if message.chars().count() > 160 {
        message = message.chars().take(160).collect();
        message.push('…');
    }
    message
}
