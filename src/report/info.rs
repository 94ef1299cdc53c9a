//! What a part is, in figures.

use std::collections::HashSet;

use serde::Serialize;

use crate::inspect::{Shape, WallThickness};
use crate::intake::Input;
use crate::io::{NameSet, Unit};
use crate::settings::warning::Warning;

/// What a part is.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The file.
    pub part: String,
    /// SHA-256 of the file's bytes.
    pub sha256: String,
    /// Checksum of the geometry alone.
    pub geometry: String,
    /// Facets of the file.
    pub facets: usize,
    /// Counts and measures.
    #[serde(flatten)]
    pub shape: Shape,
    /// Unit of all lengths, where it is known.
    pub unit: Option<Unit>,
    /// Groups that the file names.
    pub groups: Vec<String>,
    /// Objects that the file names.
    pub objects: Vec<String>,
    /// Materials that the file names.
    pub materials: Vec<String>,
    /// Wall thickness; none where no wall faces another.
    pub thickness: Option<WallThickness>,
    /// What was odd.
    pub warnings: Vec<Warning>,
}

impl Info {
    /// Of a part whose walls were measured.
    pub fn of(input: &Input, thickness: Option<WallThickness>) -> Info {
        let sets = input.names.sets();
        let object = |set: &NameSet| set.object.clone();
        let material = |set: &NameSet| set.material.clone();
        Info {
            part: input.file.to_string_lossy().into_owned(),
            sha256: input.sha256.clone(),
            geometry: input.geometry.clone(),
            facets: input.facets,
            shape: Shape::of(&input.part),
            unit: input.unit,
            groups: unique(sets.iter().flat_map(|set| set.groups.clone())),
            objects: unique(sets.iter().filter_map(object)),
            materials: unique(sets.iter().filter_map(material)),
            thickness,
            warnings: input.warnings.clone(),
        }
    }
}

/// Each name once, in order of first use.
fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = HashSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}
