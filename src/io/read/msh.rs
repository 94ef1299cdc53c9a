//! Gmsh MSH, versions 2.2 and 4.1: nodes and elements, with the names of
//! physical groups and the numbers of entities.
//!
//! Every facet is in the group `face N` of its surface entity and in those of its
//! physical groups; where volumes are known, its object is `solid N`.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::elements::{ElementNames, Elements, Shape};
use super::loaded::RawMesh;
use super::msh_binary;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, excerpt, finite};

/// Shape and number of nodes for Gmsh's element types that have faces.
pub(super) fn shape(kind: u64) -> Option<Shape> {
    Some(match kind {
        2 | 9 | 20 | 21 => Shape::Triangle,
        3 | 10 | 16 => Shape::Quad,
        4 | 11 => Shape::Tetrahedron,
        5 | 12 | 17 => Shape::Hexahedron,
        6 | 13 | 18 => Shape::Prism,
        7 | 14 | 19 => Shape::Pyramid,
        _ => return None,
    })
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    if let Some((version, at)) = binary(bytes)? {
        let mut file = File::default();
        msh_binary::sections(bytes, at, version, &mut file)?;
        return file.elements.finish();
    }
    let mut rows = Rows::new(bytes);
    let mut file = File::default();
    let mut version = None;
    while let Some(row) = rows.next_row() {
        match (row.words[0].as_str(), version) {
            ("$MeshFormat", _) => version = Some(format(&rows.row()?)?),
            ("$PhysicalNames", _) => file.physical_names(&mut rows)?,
            ("$Entities", Some(Version::Four)) => file.entities(&mut rows)?,
            ("$Nodes", Some(Version::Two)) => file.nodes_2(&mut rows)?,
            ("$Nodes", Some(Version::Four)) => file.nodes_4(&mut rows)?,
            ("$Elements", Some(Version::Two)) => file.elements_2(&mut rows)?,
            ("$Elements", Some(Version::Four)) => file.elements_4(&mut rows)?,
            ("$NodeData", Some(_)) => file.node_data(&mut rows)?,
            (word, None) => {
                let message = format!("{:?} comes before $MeshFormat", excerpt(word));
                return Err(row.syntax(message));
            }
            _ => {}
        }
    }
    if version.is_none() {
        let message = "an MSH file starts with $MeshFormat".to_owned();
        return Err((Place::Whole, Problem::Syntax(message)));
    }
    file.elements.finish()
}

#[derive(Clone, Copy)]
pub(super) enum Version {
    Two,
    Four,
}

/// Version of a binary file, and where its numbers begin.
fn binary(bytes: &[u8]) -> Result<Option<(Version, usize)>, Located> {
    let Some(rest) = bytes.strip_prefix(b"$MeshFormat") else {
        return Ok(None);
    };
    let mut lines = Lines::new(rest);
    lines.next();
    let Some((_, raw)) = lines.next() else {
        return Ok(None);
    };
    let at = bytes.len() - lines.remaining();
    let text = decode(raw).into_owned();
    let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
    if words.get(1).is_none_or(|word| word != "1") {
        return Ok(None);
    }
    let row = Row {
        text,
        words,
        line: 2,
    };
    Ok(Some((format(&row)?, at)))
}

pub(super) fn syntax(place: Place, message: String) -> Located {
    (place, Problem::Syntax(message))
}

fn format(row: &Row) -> Result<Version, Located> {
    match row.words[0].as_str() {
        "2" | "2.0" | "2.1" | "2.2" => Ok(Version::Two),
        "4.1" => Ok(Version::Four),
        other => {
            let message = format!("version {:?} is neither 2.2 nor 4.1", excerpt(other));
            Err(row.syntax(message))
        }
    }
}

/// What is known of a file so far.
#[derive(Default)]
pub(super) struct File {
    pub(super) elements: Elements,
    /// By dimension and number.
    pub(super) physical: FxHashMap<(u64, u64), String>,
    /// Physical groups of entities, by dimension and number.
    pub(super) groups_of: FxHashMap<(u64, u64), Vec<u64>>,
    /// The volume that a surface bounds; the first of two.
    pub(super) solid_of: FxHashMap<u64, u64>,
}

impl File {
    fn physical_names(&mut self, rows: &mut Rows) -> Result<(), Located> {
        for _ in 0..rows.row()?.number(0)? {
            let row = rows.row()?;
            let name = row.text.split('"').nth(1).unwrap_or("").to_owned();
            self.physical.insert((row.number(0)?, row.number(1)?), name);
        }
        Ok(())
    }

    fn entities(&mut self, rows: &mut Rows) -> Result<(), Located> {
        let row = rows.row()?;
        for dimension in 0..4 {
            // A point has one corner, all else a box.
            let first = if dimension == 0 { 4 } else { 7 };
            for _ in 0..row.number(dimension as usize)? {
                let row = rows.row()?;
                let tag = row.number(0)?;
                let count = row.number(first)? as usize;
                let groups = (0..count).map(|k| row.signed(first + 1 + k).map(i64::unsigned_abs));
                let groups = groups.collect::<Result<Vec<u64>, Located>>()?;
                self.groups_of.insert((dimension, tag), groups);
                if dimension == 3 {
                    let at = first + 1 + count;
                    for k in 0..row.number(at)? as usize {
                        let surface = row.signed(at + 1 + k)?.unsigned_abs();
                        self.solid_of.entry(surface).or_insert(tag);
                    }
                }
            }
        }
        Ok(())
    }

    /// The nodal data called `thickness`; other data mean nothing here.
    fn node_data(&mut self, rows: &mut Rows) -> Result<(), Located> {
        let mut name = String::new();
        for _ in 0..rows.row()?.number(0)? {
            name = rows.row()?.text.trim().trim_matches('"').to_owned();
        }
        for _ in 0..rows.row()?.number(0)? {
            rows.row()?;
        }
        // Time step, components, and how many there are.
        let mut integers = [0; 3];
        for k in 0..rows.row()?.number(0)? {
            let row = rows.row()?;
            if let Some(slot) = integers.get_mut(k as usize) {
                *slot = row.number(0)?;
            }
        }
        let [_, components, count] = integers;
        for _ in 0..count {
            let row = rows.row()?;
            if name.eq_ignore_ascii_case("thickness") && components == 1 {
                let thickness = finite(row.word(1)).map_err(|p| (Place::Line(row.line), p))?;
                self.elements.thickness(row.number(0)?, thickness);
            }
        }
        Ok(())
    }

    fn nodes_2(&mut self, rows: &mut Rows) -> Result<(), Located> {
        for _ in 0..rows.row()?.number(0)? {
            let row = rows.row()?;
            self.elements.node(row.number(0)?, row.point(1)?);
        }
        Ok(())
    }

    fn nodes_4(&mut self, rows: &mut Rows) -> Result<(), Located> {
        for _ in 0..rows.row()?.number(0)? {
            let count = rows.row()?.number(3)?;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push(rows.row()?.number(0)?);
            }
            for tag in tags {
                let row = rows.row()?;
                self.elements.node(tag, row.point(0)?);
            }
        }
        Ok(())
    }

    fn elements_2(&mut self, rows: &mut Rows) -> Result<(), Located> {
        for _ in 0..rows.row()?.number(0)? {
            let row = rows.row()?;
            let Some(shape) = shape(row.number(1)?) else {
                continue;
            };
            // Physical group, then entity; both may be missing.
            let tags = row.number(2)? as usize;
            let tag = |k: usize| if k < tags { row.number(3 + k) } else { Ok(0) };
            let groups = [tag(0)?].into_iter().filter(|&g| g > 0).collect::<Vec<_>>();
            let names = self.names(shape, tag(1)?, &groups);
            self.element(shape, &row, tags.saturating_add(3), names)?;
        }
        Ok(())
    }

    fn elements_4(&mut self, rows: &mut Rows) -> Result<(), Located> {
        for _ in 0..rows.row()?.number(0)? {
            let block = rows.row()?;
            let (dimension, tag) = (block.number(0)?, block.number(1)?);
            let shape = shape(block.number(2)?);
            let groups = self.groups_of.get(&(dimension, tag)).cloned();
            let names = shape.map(|shape| self.names(shape, tag, &groups.unwrap_or_default()));
            for _ in 0..block.number(3)? {
                let row = rows.row()?;
                if let (Some(shape), Some(names)) = (shape, names) {
                    self.element(shape, &row, 1, names)?;
                }
            }
        }
        Ok(())
    }

    /// An element by its type, if that has faces.
    pub(super) fn add(
        &mut self,
        kind: u64,
        tag: u64,
        groups: &[u64],
        nodes: &[u64],
        place: Place,
    ) -> Result<(), Located> {
        let Some(shape) = shape(kind) else {
            return Ok(());
        };
        let names = self.names(shape, tag, groups);
        self.elements.element(shape, nodes, names, place)
    }

    /// Names of the elements of an entity.
    fn names(&mut self, shape: Shape, tag: u64, groups: &[u64]) -> u32 {
        let surface = matches!(shape, Shape::Triangle | Shape::Quad);
        let dimension = if surface { 2 } else { 3 };
        let mut names = ElementNames::default();
        if surface && tag > 0 {
            names.groups.push(format!("face {tag}"));
        }
        let called = |dimension: u64, group: &u64| {
            let name = self.physical.get(&(dimension, *group));
            name.map_or_else(|| format!("group {group}"), String::clone)
        };
        names
            .groups
            .extend(groups.iter().map(|g| called(dimension, g)));
        let solid = if surface {
            self.solid_of.get(&tag).copied()
        } else {
            Some(tag)
        };
        // A face is also in what its solid is in.
        let around = solid
            .filter(|_| surface)
            .and_then(|s| self.groups_of.get(&(3, s)));
        let around = around.into_iter().flatten();
        names.groups.extend(around.map(|g| called(3, g)));
        names.object = solid.map(|solid| format!("solid {solid}"));
        self.elements.names(names)
    }

    fn element(
        &mut self,
        shape: Shape,
        row: &Row,
        first: usize,
        names: u32,
    ) -> Result<(), Located> {
        let nodes = (first..row.words.len()).map(|k| row.number(k));
        let nodes = nodes.collect::<Result<Vec<u64>, Located>>()?;
        self.elements
            .element(shape, &nodes, names, Place::Line(row.line))
    }
}

/// Lines that hold something.
struct Rows<'a> {
    lines: Lines<'a>,
    end: u64,
}

/// A line in words; there is one at least.
struct Row {
    text: String,
    words: Vec<String>,
    line: u64,
}

impl<'a> Rows<'a> {
    fn new(bytes: &'a [u8]) -> Rows<'a> {
        Rows {
            lines: Lines::new(bytes),
            end: bytes.len() as u64,
        }
    }

    fn next_row(&mut self) -> Option<Row> {
        self.lines.by_ref().find_map(|(line, raw)| {
            let text = decode(raw).into_owned();
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            (!words.is_empty()).then_some(Row { text, words, line })
        })
    }

    /// The next line, which must be there.
    fn row(&mut self) -> Result<Row, Located> {
        let message = "a section is cut short".to_owned();
        let row = self.next_row();
        row.ok_or((Place::Byte(self.end), Problem::Truncated(message)))
    }
}

impl Row {
    fn syntax(&self, message: String) -> Located {
        (Place::Line(self.line), Problem::Syntax(message))
    }

    fn word(&self, at: usize) -> &str {
        self.words.get(at).map_or("", String::as_str)
    }

    fn number(&self, at: usize) -> Result<u64, Located> {
        let word = self.word(at);
        let bad = || self.syntax(format!("{:?} is not a whole number", excerpt(word)));
        word.parse().map_err(|_| bad())
    }

    fn signed(&self, at: usize) -> Result<i64, Located> {
        let word = self.word(at);
        let bad = || self.syntax(format!("{:?} is not a whole number", excerpt(word)));
        word.parse().map_err(|_| bad())
    }

    fn point(&self, at: usize) -> Result<DVec3, Located> {
        let coordinate = |k| finite(self.word(at + k)).map_err(|p| (Place::Line(self.line), p));
        Ok(DVec3::new(coordinate(0)?, coordinate(1)?, coordinate(2)?))
    }
}
