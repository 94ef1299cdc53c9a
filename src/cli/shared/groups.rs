//! A thickness by group: `--group NAME=LENGTH`.

use std::str::FromStr;

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

/// Names and thicknesses.
pub(crate) fn pairs(groups: &[Group]) -> Vec<(String, f64)> {
    let pair = |group: &Group| (group.name.clone(), group.thickness);
    groups.iter().map(pair).collect()
}
