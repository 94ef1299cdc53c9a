//! Nastran bulk data: `GRID`, shell and solid elements with their property numbers;
//! short, long and comma-separated fields.
//!
//! Grid points must be in the basic coordinate system. The group of a facet is
//! `property N`. Thickness is that at the corners of an element, or of its `PSHELL`.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::elements::{ElementNames, Elements, Shape};
use super::loaded::RawMesh;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, excerpt};

/// Shape of a card and most nodes that it can have.
fn shape(card: &str) -> Option<(Shape, usize)> {
    Some(match card {
        "CTRIA3" | "CTRIAR" => (Shape::Triangle, 3),
        "CTRIA6" => (Shape::Triangle, 6),
        "CQUAD4" | "CQUADR" => (Shape::Quad, 4),
        "CQUAD8" => (Shape::Quad, 8),
        "CTETRA" => (Shape::Tetrahedron, 10),
        "CHEXA" => (Shape::Hexahedron, 20),
        "CPENTA" => (Shape::Prism, 15),
        "CPYRAM" => (Shape::Pyramid, 13),
        _ => return None,
    })
}

/// Field of the thickness at the first corner, the name being field 0, the same of
/// all shell elements; none of a membrane's card is so long.
const FIRST_THICKNESS: usize = 11;

/// A card with its fields, name first.
struct Card {
    fields: Vec<String>,
    line: u64,
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let cards = cards(bytes);
    let mut elements = Elements::default();
    for card in cards.iter().filter(|card| card.fields[0] == "GRID") {
        let system = card.field(2);
        if !matches!(system, "" | "0") {
            let message = format!("grid point in coordinate system {:?}", excerpt(system));
            return Err(card.syntax(message));
        }
        let at = DVec3::new(card.real(3)?, card.real(4)?, card.real(5)?);
        elements.node(card.number(1)?, at);
    }
    let mut sections: FxHashMap<&str, f64> = FxHashMap::default();
    for card in cards.iter().filter(|card| card.fields[0] == "PSHELL") {
        sections.insert(card.field(1), card.real(3)?);
    }
    for card in &cards {
        let Some((shape, most)) = shape(&card.fields[0]) else {
            continue;
        };
        let property = card.field(2);
        let names = elements.names(ElementNames {
            groups: vec![format!("property {property}")],
            object: None,
        });
        let given = card.fields.len().min(3 + most);
        let nodes = (3..given).filter(|&k| !card.field(k).is_empty());
        let nodes = nodes
            .map(|k| card.number(k))
            .collect::<Result<Vec<u64>, Located>>()?;
        elements.element(shape, &nodes, names, Place::Line(card.line))?;
        if let Shape::Triangle | Shape::Quad = shape {
            for (k, &node) in nodes.iter().take(shape.corners()).enumerate() {
                let own = match card.field(FIRST_THICKNESS + k) {
                    "" => sections.get(property).copied(),
                    _ => Some(card.real(FIRST_THICKNESS + k)?),
                };
                if let Some(thickness) = own.filter(|t| *t > 0.0) {
                    elements.thickness(node, thickness);
                }
            }
        }
    }
    elements.finish()
}

/// All cards, continuations joined.
fn cards(bytes: &[u8]) -> Vec<Card> {
    let mut cards: Vec<Card> = Vec::new();
    for (line, raw) in Lines::new(bytes) {
        let text = decode(raw);
        let text = text.split('$').next().unwrap_or("").trim_end();
        if text.trim().is_empty() {
            continue;
        }
        let mut fields = split(text);
        let name = fields[0].trim_end_matches('*').to_ascii_uppercase();
        let goes_on = name.is_empty() || name.starts_with('+');
        match cards.last_mut() {
            Some(card) if goes_on => card.fields.extend(fields.drain(1..)),
            _ => {
                fields[0] = name;
                cards.push(Card { fields, line });
            }
        }
    }
    cards
}

/// Fields of a line, the name first, without the one that announces a continuation.
fn split(text: &str) -> Vec<String> {
    if text.contains(',') {
        let mut fields: Vec<String> = text.split(',').map(|f| f.trim().to_owned()).collect();
        fields.truncate(9);
        return fields;
    }
    let letters: Vec<char> = text.chars().collect();
    let take = |from: usize, to: usize| -> String {
        let cut = letters.get(from..to.min(letters.len())).unwrap_or(&[]);
        cut.iter().collect::<String>().trim().to_owned()
    };
    let name = take(0, 8);
    let (width, count) = if name.ends_with('*') { (16, 4) } else { (8, 8) };
    let mut fields = vec![name];
    fields.extend((0..count).map(|k| take(8 + width * k, 8 + width * (k + 1))));
    fields
}

impl Card {
    fn field(&self, at: usize) -> &str {
        self.fields.get(at).map_or("", String::as_str)
    }

    fn syntax(&self, message: String) -> Located {
        (Place::Line(self.line), Problem::Syntax(message))
    }

    fn number(&self, at: usize) -> Result<u64, Located> {
        let word = self.field(at);
        let bad = || self.syntax(format!("{:?} is not a whole number", excerpt(word)));
        word.parse().map_err(|_| bad())
    }

    /// A number as Nastran writes it: an exponent may lack its letter, as `1.5-3`.
    fn real(&self, at: usize) -> Result<f64, Located> {
        let word = self.field(at).to_ascii_lowercase().replace('d', "e");
        if word.is_empty() {
            return Ok(0.0);
        }
        let sign = word.rfind(['+', '-']).filter(|&k| k > 0);
        let letterless = sign.filter(|&k| word.as_bytes()[k - 1] != b'e');
        let word = match letterless {
            Some(k) => format!("{}e{}", &word[..k], &word[k..]),
            None => word,
        };
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(self.syntax(format!("{:?} is not a number", excerpt(&word)))),
        }
    }
}
