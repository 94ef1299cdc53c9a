//! A thickness by group: `--group NAME=LENGTH`.

use std::path::Path;
use std::str::FromStr;

use midsurf::io::quote::shown_path;
use midsurf::io::{FacetNames, NameSet};

use super::failure::Failure;
use super::numbers::positive;

/// Thickness of the facets of a group, object or material.
#[derive(Clone)]
pub(crate) struct Group {
    pub(crate) name: String,
    pub(crate) thickness: f64,
}

impl FromStr for Group {
    type Err = String;

    fn from_str(text: &str) -> Result<Group, String> {
        let (name, thickness) = text.rsplit_once('=').ok_or("expected NAME=LENGTH")?;
        let (name, thickness) = (name.to_owned(), positive(thickness)?);
        Ok(Group { name, thickness })
    }
}

/// Refuses names that a file does not have.
pub(crate) fn check_groups(
    groups: &[Group],
    names: &FacetNames,
    file: &Path,
) -> Result<(), Failure> {
    let sets = names.sets();
    let named = |group: &Group| sets.iter().any(|set| set.all().any(|n| n == group.name));
    let Some(group) = groups.iter().find(|group| !named(group)) else {
        return Ok(());
    };
    let mut known: Vec<&str> = sets.iter().flat_map(|set| set.all()).collect();
    known.sort_unstable();
    known.dedup();
    Err(Failure::usage(
        format!("{} has no group named {}", shown_path(file), group.name),
        match &known[..] {
            [] => "the file names no groups; leave --group away".to_owned(),
            known => format!("it names {}", known.join(", ")),
        },
    ))
}

/// Thickness of a facet with these names: that of the last group which names
/// it, or the common one.
pub(crate) fn thickness_of(groups: &[Group], names: &NameSet, common: f64) -> f64 {
    let mut last_first = groups.iter().rev();
    let own = last_first.find(|group| names.all().any(|n| n == group.name));
    own.map_or(common, |group| group.thickness)
}
