//! The binary forms of Gmsh MSH 2.2 and 4.1.
//!
//! Sections are announced by lines of text as in the ASCII form; in between stand
//! numbers: `int` of 4 bytes, `size_t` and `double` of 8, in either byte order.

use glam::DVec3;

use super::msh::{File, Version, shape, syntax};
use crate::io::error::{Located, Place, Problem};
use crate::io::text::decode;

/// Reads the sections after the line that states the format, which ends at `at`.
pub(super) fn sections(
    bytes: &[u8],
    at: usize,
    version: Version,
    file: &mut File,
) -> Result<(), Located> {
    let mut data = Data {
        bytes,
        at,
        big: false,
    };
    data.big = match data.take::<4>()? {
        [1, 0, 0, 0] => false,
        [0, 0, 0, 1] => true,
        _ => {
            let message = "the byte order of this binary MSH is neither".to_owned();
            return Err(syntax(data.place(), message));
        }
    };
    while let Some(section) = data.next_section() {
        match (section.as_str(), version) {
            ("PhysicalNames", _) => data.physical_names(file)?,
            ("Entities", Version::Four) => data.entities(file)?,
            ("Nodes", Version::Two) => data.nodes_2(file)?,
            ("Nodes", Version::Four) => data.nodes_4(file)?,
            ("Elements", Version::Two) => data.elements_2(file)?,
            ("Elements", Version::Four) => data.elements_4(file)?,
            _ => {}
        }
        data.skip_to_end_of(&section)?;
    }
    Ok(())
}

/// Nodes of an element by Gmsh's number for its type.
fn nodes_of(kind: u64) -> Option<usize> {
    Some(match kind {
        15 => 1,
        1 => 2,
        2 | 8 => 3,
        3 | 4 | 26 => 4,
        7 | 27 => 5,
        6 | 9 | 28 => 6,
        5 | 16 => 8,
        10 | 20 => 9,
        11 | 21 => 10,
        22 => 12,
        19 => 13,
        14 => 14,
        18 | 23 | 24 => 15,
        13 => 18,
        17 | 29 => 20,
        25 => 21,
        12 => 27,
        30 => 35,
        31 => 56,
        92 => 64,
        93 => 125,
        _ => return None,
    })
}

struct Data<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether the highest byte comes first.
    big: bool,
}

impl Data<'_> {
    fn place(&self) -> Place {
        Place::Byte(self.at as u64)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Located> {
        let taken = self
            .bytes
            .get(self.at..)
            .and_then(|rest| rest.first_chunk::<N>());
        let Some(taken) = taken else {
            let message = "a section is cut short".to_owned();
            return Err((self.place(), Problem::Truncated(message)));
        };
        self.at += N;
        Ok(*taken)
    }

    fn int(&mut self) -> Result<i64, Located> {
        let bytes = self.take::<4>()?;
        let value = match self.big {
            true => i32::from_be_bytes(bytes),
            false => i32::from_le_bytes(bytes),
        };
        Ok(i64::from(value))
    }

    /// A whole number that counts or names something.
    fn number(&mut self) -> Result<u64, Located> {
        Ok(self.int()?.unsigned_abs())
    }

    fn size(&mut self) -> Result<u64, Located> {
        let bytes = self.take::<8>()?;
        Ok(match self.big {
            true => u64::from_be_bytes(bytes),
            false => u64::from_le_bytes(bytes),
        })
    }

    fn real(&mut self) -> Result<f64, Located> {
        Ok(f64::from_bits(self.size()?))
    }

    fn point(&mut self) -> Result<DVec3, Located> {
        let place = self.place();
        let at = DVec3::new(self.real()?, self.real()?, self.real()?);
        if !at.is_finite() {
            let word = format!("{at}");
            return Err((place, Problem::NotFinite { word }));
        }
        Ok(at)
    }

    /// The rest of a line of text.
    fn line(&mut self) -> String {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let length = rest.iter().position(|&b| b == b'\n');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.at += line.len() + 1;
        decode(line).trim().to_owned()
    }

    /// The number in a line of text.
    fn counted(&mut self) -> Result<u64, Located> {
        let place = self.place();
        let line = self.line();
        let bad = |_| syntax(place, "a count was expected here".to_owned());
        line.parse().map_err(bad)
    }

    /// Name of the next section.
    fn next_section(&mut self) -> Option<String> {
        while self.at < self.bytes.len() {
            let line = self.line();
            if let Some(name) = line.strip_prefix('$')
                && !name.starts_with("End")
            {
                return Some(name.to_owned());
            }
        }
        None
    }

    fn skip_to_end_of(&mut self, section: &str) -> Result<(), Located> {
        let mark = format!("$End{section}");
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let found = (rest.windows(mark.len())).position(|window| window == mark.as_bytes());
        let Some(found) = found else {
            let message = "a section does not end".to_owned();
            return Err((self.place(), Problem::Truncated(message)));
        };
        self.at += found + mark.len();
        Ok(())
    }

    /// Text in both forms.
    fn physical_names(&mut self, file: &mut File) -> Result<(), Located> {
        for _ in 0..self.counted()? {
            let place = self.place();
            if self.at >= self.bytes.len() {
                let message = "a section is cut short".to_owned();
                return Err((place, Problem::Truncated(message)));
            }
            let line = self.line();
            let mut words = line.split_whitespace().map(str::parse::<u64>);
            let (Some(Ok(dimension)), Some(Ok(tag))) = (words.next(), words.next()) else {
                return Err(syntax(place, "a physical name has two numbers".to_owned()));
            };
            let name = line.split('"').nth(1).unwrap_or("").to_owned();
            file.physical.insert((dimension, tag), name);
        }
        Ok(())
    }

    fn entities(&mut self, file: &mut File) -> Result<(), Located> {
        let counts = [self.size()?, self.size()?, self.size()?, self.size()?];
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let tag = self.number()?;
                // A point has one corner, all else a box.
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.real()?;
                }
                let mut groups = Vec::new();
                for _ in 0..self.size()? {
                    groups.push(self.number()?);
                }
                file.groups_of.insert((dimension, tag), groups);
                if dimension == 0 {
                    continue;
                }
                for _ in 0..self.size()? {
                    let bounding = self.number()?;
                    if dimension == 3 {
                        file.solid_of.entry(bounding).or_insert(tag);
                    }
                }
            }
        }
        Ok(())
    }

    fn nodes_2(&mut self, file: &mut File) -> Result<(), Located> {
        for _ in 0..self.counted()? {
            let tag = self.number()?;
            let at = self.point()?;
            file.elements.node(tag, at);
        }
        Ok(())
    }

    fn nodes_4(&mut self, file: &mut File) -> Result<(), Located> {
        let blocks = self.size()?;
        for _ in 0..3 {
            self.size()?;
        }
        for _ in 0..blocks {
            let dimension = self.number()?;
            self.int()?;
            let parameters = if self.int()? != 0 {
                dimension.min(3)
            } else {
                0
            };
            let mut tags = Vec::new();
            for _ in 0..self.size()? {
                tags.push(self.size()?);
            }
            for tag in tags {
                let at = self.point()?;
                file.elements.node(tag, at);
                for _ in 0..parameters {
                    self.real()?;
                }
            }
        }
        Ok(())
    }

    fn elements_2(&mut self, file: &mut File) -> Result<(), Located> {
        let mut left = self.counted()?;
        while left > 0 {
            let kind = self.number()?;
            let count = self.number()?;
            let tags = self.number()?;
            for _ in 0..count {
                self.int()?;
                let mut given = [0; 2];
                for k in 0..tags {
                    let tag = self.number()?;
                    if let Some(slot) = given.get_mut(k as usize) {
                        *slot = tag;
                    }
                }
                let groups: Vec<u64> = given[..1].iter().copied().filter(|&g| g > 0).collect();
                let nodes = self.nodes(kind, |data| data.number())?;
                file.add(kind, given[1], &groups, &nodes, self.place())?;
            }
            left = left.saturating_sub(count.max(1));
        }
        Ok(())
    }

    fn elements_4(&mut self, file: &mut File) -> Result<(), Located> {
        let blocks = self.size()?;
        for _ in 0..3 {
            self.size()?;
        }
        for _ in 0..blocks {
            let dimension = self.number()?;
            let tag = self.number()?;
            let kind = self.number()?;
            let groups = file.groups_of.get(&(dimension, tag)).cloned();
            let groups = groups.unwrap_or_default();
            for _ in 0..self.size()? {
                self.size()?;
                let nodes = self.nodes(kind, |data| data.size())?;
                file.add(kind, tag, &groups, &nodes, self.place())?;
            }
        }
        Ok(())
    }

    /// The nodes of an element.
    fn nodes(
        &mut self,
        kind: u64,
        read: impl Fn(&mut Self) -> Result<u64, Located>,
    ) -> Result<Vec<u64>, Located> {
        let Some(count) = nodes_of(kind) else {
            return Err(syntax(
                self.place(),
                format!("element type {kind} is not known"),
            ));
        };
        let mut nodes = Vec::with_capacity(count);
        for _ in 0..count {
            nodes.push(read(self)?);
        }
        // What has no faces is passed over.
        if shape(kind).is_none() {
            nodes.clear();
        }
        Ok(nodes)
    }
}
