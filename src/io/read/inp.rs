//! Abaqus and CalculiX input decks: nodes, shell and solid elements, element sets.
//!
//! What is read: `*NODE`, `*ELEMENT` with `TYPE` and `ELSET`, `*ELSET` with `ELSET` and
//! `GENERATE`, `*NODAL THICKNESS`. One level of parts; instances, includes and transforms are refused, as
//! what they stand for would be missing.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::elements::{ElementNames, Elements, Shape};
use super::loaded::RawMesh;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, excerpt, finite};

/// Keywords that bring in what is not in the file, or move what is.
const REFUSED: [&str; 3] = ["*INCLUDE", "*INSTANCE", "*SYSTEM"];

/// Shape and number of nodes of an element type, by how its name begins; none for
/// elements without faces, as beams and springs.
fn shape(kind: &str) -> Option<(Shape, usize)> {
    let kinds = [
        ("C3D20", Shape::Hexahedron, 20),
        ("C3D15", Shape::Prism, 15),
        ("C3D10", Shape::Tetrahedron, 10),
        ("C3D8", Shape::Hexahedron, 8),
        ("C3D6", Shape::Prism, 6),
        ("C3D5", Shape::Pyramid, 5),
        ("C3D4", Shape::Tetrahedron, 4),
        ("SC8", Shape::Hexahedron, 8),
        ("SC6", Shape::Prism, 6),
        ("STRI65", Shape::Triangle, 6),
        ("STRI3", Shape::Triangle, 3),
    ];
    let found = kinds.into_iter().find(|(name, ..)| kind.starts_with(name));
    if let Some((_, shape, nodes)) = found {
        return Some((shape, nodes));
    }
    // Shells, membranes, plane and surface elements end their letters with the count.
    let surface = ["SFM3D", "M3D", "CPS", "CPE", "S"];
    let rest = surface.iter().find_map(|name| kind.strip_prefix(name))?;
    match rest.bytes().next()? {
        b'3' => Some((Shape::Triangle, 3)),
        b'6' => Some((Shape::Triangle, 6)),
        b'4' => Some((Shape::Quad, 4)),
        b'8' => Some((Shape::Quad, 8)),
        b'9' => Some((Shape::Quad, 9)),
        _ => None,
    }
}

/// An element before its sets are known.
struct Pending {
    number: u64,
    shape: Shape,
    nodes: Vec<u64>,
    set: Option<u32>,
    line: u64,
}

/// What the lines under a keyword are.
#[derive(Clone)]
enum Section {
    Nodes,
    Elements {
        kind: Option<(Shape, usize)>,
        set: Option<u32>,
    },
    Set {
        set: u32,
        generate: bool,
    },
    Thickness,
    Other,
}

#[derive(Default)]
struct File {
    nodes: Elements,
    pending: Vec<Pending>,
    sets: Vec<String>,
    members: FxHashMap<u64, Vec<u32>>,
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut file = File::default();
    let mut section = Section::Other;
    // Words of an element that goes on over several lines.
    let mut open: Vec<String> = Vec::new();
    for (line, raw) in Lines::new(bytes) {
        let text = decode(raw);
        let text = text.trim();
        if text.is_empty() || text.starts_with("**") {
            continue;
        }
        if text.starts_with('*') {
            open.clear();
            section = file.keyword(text, line)?;
            continue;
        }
        let words = text.split(',').map(|word| word.trim().to_owned());
        open.extend(words.filter(|word| !word.is_empty()));
        // A line of commas holds nothing.
        if open.is_empty() {
            continue;
        }
        let needed = match &section {
            Section::Elements {
                kind: Some((_, nodes)),
                ..
            } => nodes + 1,
            _ => 0,
        };
        if open.len() >= needed {
            let words = std::mem::take(&mut open);
            file.data(&section, &words, line)?;
        }
    }
    file.finish()
}

impl File {
    fn keyword(&mut self, text: &str, line: u64) -> Result<Section, Located> {
        let mut parts = text.split(',').map(str::trim);
        let word = parts.next().unwrap_or("").to_ascii_uppercase();
        let options: Vec<(String, &str)> = parts
            .map(|part| {
                let (key, value) = part.split_once('=').unwrap_or((part, ""));
                (
                    key.trim().to_ascii_uppercase(),
                    value.trim().trim_matches('"'),
                )
            })
            .collect();
        let option = |name: &str| options.iter().find(|(key, _)| key == name).map(|o| o.1);
        if REFUSED.contains(&word.as_str()) {
            let message = format!("{word} is not followed here");
            return Err((Place::Line(line), Problem::Syntax(message)));
        }
        Ok(match word.as_str() {
            "*NODE" => Section::Nodes,
            "*ELEMENT" => Section::Elements {
                kind: shape(&option("TYPE").unwrap_or("").to_ascii_uppercase()),
                set: option("ELSET").map(|name| self.set(name)),
            },
            "*ELSET" => Section::Set {
                set: self.set(option("ELSET").unwrap_or("")),
                generate: option("GENERATE").is_some(),
            },
            "*NODAL THICKNESS" => Section::Thickness,
            _ => Section::Other,
        })
    }

    fn set(&mut self, name: &str) -> u32 {
        let known = self
            .sets
            .iter()
            .position(|set| set.eq_ignore_ascii_case(name));
        known.unwrap_or_else(|| {
            self.sets.push(name.to_owned());
            self.sets.len() - 1
        }) as u32
    }

    fn data(&mut self, section: &Section, words: &[String], line: u64) -> Result<(), Located> {
        let place = Place::Line(line);
        let number = |word: &String| -> Result<u64, Located> {
            let message = format!("{:?} is not a whole number", excerpt(word));
            word.parse().map_err(|_| (place, Problem::Syntax(message)))
        };
        match section {
            Section::Nodes => {
                let mut at = DVec3::ZERO;
                for axis in 0..3 {
                    // What is left away is zero.
                    if let Some(word) = words.get(axis + 1) {
                        at[axis] = finite(word).map_err(|problem| (place, problem))?;
                    }
                }
                self.nodes.node(number(&words[0])?, at);
            }
            Section::Elements {
                kind: Some((shape, count)),
                set,
            } => {
                let numbers: Vec<u64> = words.iter().map(number).collect::<Result<_, _>>()?;
                self.pending.push(Pending {
                    number: numbers[0],
                    shape: *shape,
                    nodes: numbers[1..=*count].to_vec(),
                    set: *set,
                    line,
                });
            }
            Section::Set {
                set,
                generate: true,
            } => {
                let [first, last] = [0, 1].map(|k| words.get(k).map_or(Ok(0), number));
                let step = words.get(2).map_or(Ok(1), number)?.max(1);
                let (first, last) = (first?, last?);
                // Only numbers of elements matter, whatever the range claims.
                for element in &self.pending {
                    let n = element.number;
                    if (first..=last).contains(&n) && (n - first) % step == 0 {
                        self.members.entry(n).or_default().push(*set);
                    }
                }
            }
            Section::Set { set, .. } => {
                for word in words {
                    // Sets may name other sets; those are not followed.
                    if let Ok(element) = word.parse() {
                        self.members.entry(element).or_default().push(*set);
                    }
                }
            }
            Section::Thickness => {
                // Sets of nodes may stand there too; those are not followed.
                if let [node, thickness] = words
                    && let Ok(node) = node.parse()
                {
                    let thickness = finite(thickness).map_err(|problem| (place, problem))?;
                    self.nodes.thickness(node, thickness);
                }
            }
            Section::Elements { kind: None, .. } | Section::Other => {}
        }
        Ok(())
    }

    fn finish(mut self) -> Result<RawMesh, Located> {
        for element in &self.pending {
            let mut sets: Vec<u32> = element.set.into_iter().collect();
            sets.extend(self.members.get(&element.number).into_iter().flatten());
            sets.sort_unstable();
            sets.dedup();
            let groups = sets.iter().map(|&set| self.sets[set as usize].clone());
            let names = self.nodes.names(ElementNames {
                groups: groups.collect(),
                object: None,
            });
            self.nodes.element(
                element.shape,
                &element.nodes,
                names,
                Place::Line(element.line),
            )?;
        }
        self.nodes.finish()
    }
}
