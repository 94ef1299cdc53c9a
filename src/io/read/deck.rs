//! What solver decks and Gmsh files have in common: nodes and shell elements by
//! number, in any order.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::loaded::{FacetPlaces, RawMesh, ReadWarning};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::NamesBuilder;

/// A shell element: its corners, and what the file says of it.
struct Facet {
    corners: Vec<i64>,
    /// Set, property or group that holds it.
    name: Option<String>,
    /// Thickness at its corners, or none.
    thickness: Vec<f64>,
    line: u64,
}

/// Collects nodes and elements.
#[derive(Default)]
pub(super) struct Deck {
    number: FxHashMap<i64, u32>,
    positions: Vec<DVec3>,
    facets: Vec<Facet>,
    /// Thickness of nodes.
    nodal: FxHashMap<i64, f64>,
    /// Elements of other kinds: how many, the first kind, and its line.
    skipped: Option<(usize, String, u64)>,
}

impl Deck {
    /// A node; one number twice is an error unless both are in one place.
    pub(super) fn node(&mut self, id: i64, at: DVec3, line: u64) -> Result<(), Located> {
        match self.number.get(&id) {
            Some(&known) if self.positions[known as usize] == at => Ok(()),
            Some(_) => {
                let message = format!("node {id} is given twice, in two places");
                Err((Place::Line(line), Problem::Syntax(message)))
            }
            None if self.positions.len() >= u32::MAX as usize - 1 => {
                Err((Place::Line(line), Problem::TooMany("nodes")))
            }
            None => {
                self.number.insert(id, self.positions.len() as u32);
                self.positions.push(at);
                Ok(())
            }
        }
    }

    /// A shell element by its corners; its place among the elements.
    pub(super) fn shell(
        &mut self,
        corners: Vec<i64>,
        name: Option<String>,
        thickness: Vec<f64>,
        line: u64,
    ) -> usize {
        self.facets.push(Facet {
            corners,
            name,
            thickness,
            line,
        });
        self.facets.len() - 1
    }

    /// Thickness of a node.
    pub(super) fn thickness(&mut self, id: i64, thickness: f64) {
        self.nodal.insert(id, thickness);
    }

    /// Thickness of the elements of a set that have none of their own.
    pub(super) fn thickness_of_set(&mut self, name: &str, thickness: f64) {
        for facet in &mut self.facets {
            if facet.thickness.is_empty() && facet.name.as_deref() == Some(name) {
                facet.thickness = vec![thickness; facet.corners.len()];
            }
        }
    }

    /// An element that is no shell.
    pub(super) fn skip(&mut self, kind: &str, line: u64) {
        let skipped = (self.skipped).get_or_insert_with(|| (0, kind.to_owned(), line));
        skipped.0 += 1;
    }

    /// The mesh: the nodes that are corners, in the order of the file.
    pub(super) fn finish(self) -> Result<RawMesh, Located> {
        let mut used = vec![false; self.positions.len()];
        for facet in &self.facets {
            for id in &facet.corners {
                let Some(&known) = self.number.get(id) else {
                    let message = format!("an element names node {id}, which is not given");
                    return Err((Place::Line(facet.line), Problem::Syntax(message)));
                };
                used[known as usize] = true;
            }
        }
        let mut place = vec![0; used.len()];
        let mut positions = Vec::new();
        for (known, _) in used.iter().enumerate().filter(|u| *u.1) {
            place[known] = positions.len() as u32;
            positions.push(self.positions[known]);
        }
        let vertex = |id: &i64| self.number.get(id).map_or(0, |&k| place[k as usize]);
        let thickness = self.corner_thickness(&vertex, positions.len());
        let mut sink = FacetSink::with_capacity(self.facets.len());
        let mut names = NamesBuilder::default();
        let mut lines = Vec::with_capacity(self.facets.len());
        for facet in &self.facets {
            let corners: Vec<u32> = facet.corners.iter().map(vertex).collect();
            names.set_groups(facet.name.iter().cloned().collect());
            names.push_facet();
            sink.push(&corners, &positions, Place::Line(facet.line))?;
            lines.push(facet.line);
        }
        let warnings = self.skipped.map(|(count, kind, line)| ReadWarning {
            code: "other_elements",
            place: Place::Line(line),
            message: format!("{count} elements that are no shells, as {kind}, are left out"),
        });
        let mut raw = sink.finish(
            positions,
            names.finish(),
            FacetPlaces::Lines(lines),
            warnings.into_iter().collect(),
        );
        raw.values.thickness = thickness;
        Ok(raw)
    }

    /// Thickness by vertex: that of the node, else the mean of the element
    /// corners there; none at all if a vertex has neither.
    fn corner_thickness(&self, vertex: &dyn Fn(&i64) -> u32, count: usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0u32); count];
        for facet in &self.facets {
            for (k, id) in facet.corners.iter().enumerate() {
                let own = facet
                    .thickness
                    .get(k)
                    .filter(|_| !self.nodal.contains_key(id));
                if let Some(t) = own.or_else(|| self.nodal.get(id)) {
                    let sum = &mut sums[vertex(id) as usize];
                    *sum = (sum.0 + t, sum.1 + 1);
                }
            }
        }
        if sums.iter().any(|s| s.1 == 0) {
            return Vec::new();
        }
        sums.iter().map(|s| s.0 / f64::from(s.1)).collect()
    }
}

/// A whole number, or what is wrong with the word.
pub(super) fn whole(word: &str, line: u64) -> Result<i64, Located> {
    word.trim().parse().map_err(|_| {
        let message = format!("{:?} is not a whole number", crate::io::text::excerpt(word));
        (Place::Line(line), Problem::Syntax(message))
    })
}
