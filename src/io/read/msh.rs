//! Gmsh meshes, ASCII, of versions 4.1 and 2.2: triangles and quads of any
//! order by their corners, the physical group or surface that holds them, and
//! nodal data called `thickness`.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::deck::{Deck, whole};
use super::loaded::RawMesh;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{Lines, decode, finite};

/// Lines with their words.
struct Rows<'b> {
    lines: Lines<'b>,
    last: u64,
}

impl Rows<'_> {
    fn next(&mut self) -> Option<Vec<String>> {
        loop {
            let (line, raw) = self.lines.next()?;
            self.last = line;
            let text = decode(raw);
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            if !words.is_empty() {
                return Some(words);
            }
        }
    }

    fn row(&mut self, least: usize) -> Result<Vec<String>, Located> {
        match self.next() {
            Some(words) if words.len() >= least && !words[0].starts_with('$') => Ok(words),
            Some(_) => Err(self.refuse(format!("expected {least} figures"))),
            None => {
                let message = "a section does not end".to_owned();
                Err((Place::Line(self.last), Problem::Truncated(message)))
            }
        }
    }

    fn whole(&self, word: &str) -> Result<i64, Located> {
        whole(word, self.last)
    }

    fn wholes(&mut self, least: usize) -> Result<Vec<i64>, Located> {
        let words = self.row(least)?;
        words.iter().map(|w| self.whole(w)).collect()
    }

    fn real(&self, word: &str) -> Result<f64, Located> {
        finite(word).map_err(|problem| (Place::Line(self.last), problem))
    }

    fn point(&self, words: &[String]) -> Result<DVec3, Located> {
        Ok(DVec3::new(
            self.real(&words[0])?,
            self.real(&words[1])?,
            self.real(&words[2])?,
        ))
    }

    fn refuse(&self, message: String) -> Located {
        (Place::Line(self.last), Problem::Syntax(message))
    }
}

/// Corners of an element type, if it is a triangle or quad.
fn corners(kind: i64) -> Option<usize> {
    match kind {
        2 | 9 | 20 | 21 | 22 | 23 => Some(3),
        3 | 10 | 16 => Some(4),
        _ => None,
    }
}

/// Names by dimension and physical tag.
type Names = FxHashMap<(i64, i64), String>;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut rows = Rows {
        lines: Lines::new(bytes),
        last: 1,
    };
    let mut deck = Deck::default();
    let mut names = Names::default();
    // Physical group of each surface.
    let mut groups: FxHashMap<i64, i64> = FxHashMap::default();
    let mut version = 4.1;
    while let Some(words) = rows.next() {
        match words[0].as_str() {
            "$MeshFormat" => {
                let head = rows.row(2)?;
                version = rows.real(&head[0])?;
                if head[1] != "0" {
                    return Err(rows.refuse(
                        "binary .msh is not read; write it with `gmsh -format msh41` as text"
                            .to_owned(),
                    ));
                }
                if version != 2.2 && version != 4.1 {
                    return Err(
                        rows.refuse(format!("version {version} is not read; write 4.1 or 2.2"))
                    );
                }
            }
            "$PhysicalNames" => {
                let count = rows.wholes(1)?[0];
                for _ in 0..count {
                    let row = rows.row(3)?;
                    let name = row[2..].join(" ").trim_matches('"').to_owned();
                    names.insert((rows.whole(&row[0])?, rows.whole(&row[1])?), name);
                }
            }
            "$Entities" => entities(&mut rows, &mut groups)?,
            "$Nodes" if version == 4.1 => nodes_4(&mut rows, &mut deck)?,
            "$Nodes" => {
                for _ in 0..rows.wholes(1)?[0] {
                    let row = rows.row(4)?;
                    deck.node(rows.whole(&row[0])?, rows.point(&row[1..])?, rows.last)?;
                }
            }
            "$Elements" if version == 4.1 => elements_4(&mut rows, &mut deck, &names, &groups)?,
            "$Elements" => elements_2(&mut rows, &mut deck, &names)?,
            "$NodeData" => node_data(&mut rows, &mut deck)?,
            _ => {}
        }
    }
    deck.finish()
}

fn entities(rows: &mut Rows, groups: &mut FxHashMap<i64, i64>) -> Result<(), Located> {
    let counts = rows.wholes(4)?;
    for _ in 0..counts[0] + counts[1] {
        rows.row(1)?;
    }
    for _ in 0..counts[2] {
        let row = rows.row(8)?;
        if rows.whole(&row[7])? > 0
            && let Some(group) = row.get(8)
        {
            groups.insert(rows.whole(&row[0])?, rows.whole(group)?);
        }
    }
    Ok(())
}

fn nodes_4(rows: &mut Rows, deck: &mut Deck) -> Result<(), Located> {
    let blocks = rows.wholes(4)?[0];
    for _ in 0..blocks {
        let count = rows.wholes(4)?[3];
        let mut ids = Vec::new();
        for _ in 0..count {
            ids.push(rows.wholes(1)?[0]);
        }
        for id in ids {
            let row = rows.row(3)?;
            deck.node(id, rows.point(&row)?, rows.last)?;
        }
    }
    Ok(())
}

fn elements_4(
    rows: &mut Rows,
    deck: &mut Deck,
    names: &Names,
    groups: &FxHashMap<i64, i64>,
) -> Result<(), Located> {
    let blocks = rows.wholes(4)?[0];
    for _ in 0..blocks {
        let head = rows.wholes(4)?;
        let [dimension, entity, kind, count] = [head[0], head[1], head[2], head[3]];
        let group = groups.get(&entity);
        let named = group.and_then(|&g| names.get(&(2, g)).cloned());
        let name = named.unwrap_or_else(|| format!("surface_{entity}"));
        for _ in 0..count {
            let row = rows.wholes(2)?;
            match corners(kind) {
                Some(n) if row.len() > n => {
                    deck.shell(
                        row[1..=n].to_vec(),
                        Some(name.clone()),
                        Vec::new(),
                        rows.last,
                    );
                }
                Some(n) => return Err(rows.refuse(format!("expected {n} nodes"))),
                // Points and lines are no elements of a surface.
                None if dimension < 2 => {}
                None => deck.skip(&format!("type {kind}"), rows.last),
            }
        }
    }
    Ok(())
}

fn elements_2(rows: &mut Rows, deck: &mut Deck, names: &Names) -> Result<(), Located> {
    for _ in 0..rows.wholes(1)?[0] {
        let row = rows.wholes(3)?;
        let tags = usize::try_from(row[2]).unwrap_or(0);
        let Some(n) = corners(row[1]) else {
            if !matches!(row[1], 1 | 8 | 15) {
                deck.skip(&format!("type {}", row[1]), rows.last);
            }
            continue;
        };
        let nodes = row
            .get(3usize.saturating_add(tags)..)
            .filter(|nodes| nodes.len() >= n);
        let nodes = nodes.ok_or_else(|| rows.refuse(format!("expected {n} nodes")))?;
        let named = row.get(3).and_then(|&g| names.get(&(2, g)).cloned());
        let name = named.or_else(|| row.get(4).map(|entity| format!("surface_{entity}")));
        deck.shell(nodes[..n].to_vec(), name, Vec::new(), rows.last);
    }
    Ok(())
}

fn node_data(rows: &mut Rows, deck: &mut Deck) -> Result<(), Located> {
    let mut name = String::new();
    for n in 0..rows.wholes(1)?[0] {
        let row = rows.row(1)?;
        if n == 0 {
            name = row.join(" ").trim_matches('"').to_owned();
        }
    }
    for _ in 0..rows.wholes(1)?[0] {
        rows.row(1)?;
    }
    let mut tags = Vec::new();
    for _ in 0..rows.wholes(1)?[0] {
        tags.push(rows.wholes(1)?[0]);
    }
    let count = tags.get(2).copied().unwrap_or(0);
    for _ in 0..count {
        let row = rows.row(2)?;
        if name == "thickness" {
            deck.thickness(rows.whole(&row[0])?, rows.real(&row[1])?);
        }
    }
    Ok(())
}
