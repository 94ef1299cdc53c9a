//! What is done to a mesh between its file and the part: one solid of several,
//! another scale, repairs. Names, tags and places in the file go along.

use miette::Diagnostic;
use thiserror::Error;

use super::LoadedMesh;
use crate::mesh::{FaceId, Mended, PartError, PartOptions, Repair, TriMesh, mend};
use crate::settings::quote::quoted;

/// A solid that a file does not have.
#[derive(Clone, Debug, PartialEq, Eq, Error, Diagnostic)]
#[error("there is no solid {}; {}", quoted(wanted), known(names))]
#[diagnostic(help("give --solid a number, counted from 1, a name, or `all`"))]
pub struct NoSolid {
    /// As asked for.
    pub wanted: String,
    /// Those that there are, in their order.
    pub names: Vec<String>,
}

fn known(names: &[String]) -> String {
    match names {
        [] => "the file names none".to_owned(),
        [one] => format!("the only one is {}", quoted(one)),
        all => {
            let shown: Vec<String> = all.iter().take(10).map(|name| quoted(name)).collect();
            format!("there are {}: {}", all.len(), shown.join(", "))
        }
    }
}

impl LoadedMesh {
    /// Names of the solids: objects, in the order of their first facets.
    pub fn solids(&self) -> Vec<String> {
        let mut seen = rustc_hash::FxHashSet::default();
        let objects = self.source.iter().map(|&facet| self.names.set_of(facet));
        let mut sets: Vec<u32> = Vec::new();
        for set in objects {
            if seen.insert(set) {
                sets.push(set);
            }
        }
        let mut names: Vec<String> = Vec::new();
        for set in sets {
            if let Some(name) = &self.names.sets()[set as usize].object
                && !names.contains(name)
            {
                names.push(name.clone());
            }
        }
        names
    }

    /// Leaves only the triangles of one solid: by its name, by its number among
    /// [`LoadedMesh::solids`], counted from 1, or by a group that it is in, as its name
    /// in a CAD model.
    ///
    /// # Errors
    ///
    /// [`NoSolid`].
    pub fn keep_solid(&mut self, wanted: &str) -> Result<(), NoSolid> {
        let names = self.solids();
        let number = wanted.parse::<usize>().ok();
        let by_number = number.and_then(|n| names.get(n.checked_sub(1)?));
        let by_name = names.iter().find(|name| *name == wanted);
        let name = by_name.or(by_number).map_or(wanted, String::as_str);
        let of_it = |triangle: &usize| {
            let names = self.names_of(FaceId(*triangle as u32));
            names.object.as_deref() == Some(name) || names.groups.iter().any(|g| g == name)
        };
        let kept: Vec<usize> = (0..self.source.len()).filter(of_it).collect();
        if kept.is_empty() {
            let wanted = wanted.to_owned();
            return Err(NoSolid { wanted, names });
        }
        if kept.len() == self.source.len() {
            return Ok(());
        }
        self.remember();
        self.mesh = TriMesh {
            positions: std::mem::take(&mut self.mesh.positions),
            triangles: kept.iter().map(|&t| self.mesh.triangles[t]).collect(),
        };
        self.source = kept.iter().map(|&t| self.source[t]).collect();
        Ok(())
    }

    /// Multiplies all coordinates.
    pub fn scale(&mut self, factor: f64) {
        if factor != 1.0 {
            self.remember();
            self.mesh.positions.iter_mut().for_each(|p| *p *= factor);
        }
    }

    /// Puts the mesh right; see [`mend()`].
    ///
    /// # Errors
    ///
    /// As [`mend()`].
    pub fn mend(&mut self, options: PartOptions) -> Result<Vec<Repair>, PartError> {
        let Mended {
            mesh,
            origin,
            repairs,
        } = mend(self.mesh.clone(), options)?;
        if !repairs.is_empty() {
            self.remember();
            self.source = origin.iter().map(|&o| self.source[o as usize]).collect();
            self.mesh = mesh;
            // They count the vertices of the file.
            self.values = Default::default();
        }
        Ok(repairs)
    }

    /// Keeps the checksum of the mesh as it was read.
    fn remember(&mut self) {
        let geometry = self.geometry();
        self.as_read.get_or_insert(geometry);
    }
}
