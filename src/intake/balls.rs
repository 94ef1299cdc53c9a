//! Surfaces with a ball at every vertex: what is to be said of their files, and
//! thicknesses by the names in them.

use std::path::Path;

use miette::Diagnostic;
use thiserror::Error;

use crate::io::{FacetNames, LoadedMesh, LoadedSurface, NameSet, RadiusSource};
use crate::rethicken::BallSurface;
use crate::settings::quote::{shown, shown_path};
use crate::settings::warning::Warning;

/// What a file leaves open of the balls, of a surface whose free borders are
/// `rounded` anyway or not.
pub fn doubts(
    file: &Path,
    loaded: &LoadedSurface,
    surface: &BallSurface,
    rounded: bool,
) -> Vec<Warning> {
    let mut doubts = Vec::new();
    let mut doubt = |code, words: &str| {
        let message = format!("{}: {words}", shown_path(file));
        doubts.push(Warning::new(code, message));
    };
    if matches!(loaded.radius, RadiusSource::HalfThickness(_)) {
        doubt(
            "half_thickness",
            "no radius is given, half the thickness is taken: a little small near seams",
        );
    }
    if !loaded.kinds && !rounded && surface.flat_edges() > 0 {
        doubt(
            "unknown_borders",
            "the file does not tell coping from fading borders: all end flat",
        );
    }
    doubts
}

/// A thickness was given to a name that the file does not have.
#[derive(Clone, Debug, PartialEq, Eq, Error, Diagnostic)]
#[error("has no group named {}", shown(name))]
#[diagnostic(help("{}", self.remedy()))]
pub struct UnknownGroup {
    /// The name.
    pub name: String,
    /// Those that it has.
    pub known: Vec<String>,
}

impl UnknownGroup {
    fn remedy(&self) -> String {
        match &self.known[..] {
            [] => "the file names no groups; leave --group away".to_owned(),
            known => format!("it names {}", shown(&known.join(", "))),
        }
    }
}

/// Refuses names that a file does not have.
pub(super) fn check_groups(
    groups: &[(String, f64)],
    names: &FacetNames,
) -> Result<(), UnknownGroup> {
    let mut known: Vec<&str> = names.sets().iter().flat_map(|set| set.all()).collect();
    known.sort_unstable();
    known.dedup();
    match groups.iter().find(|(name, _)| !known.contains(&&**name)) {
        None => Ok(()),
        Some((name, _)) => Err(UnknownGroup {
            name: name.clone(),
            known: known.into_iter().map(str::to_owned).collect(),
        }),
    }
}

/// Thickness of a facet with these names: that of the last group which names
/// it, or the common one.
pub(super) fn thickness_of(groups: &[(String, f64)], names: &NameSet, common: f64) -> f64 {
    let mut last_first = groups.iter().rev();
    let own = last_first.find(|(name, _)| names.all().any(|n| n == name));
    own.map_or(common, |&(_, thickness)| thickness)
}

/// A thickness for every triangle, common or by the names of its facet.
///
/// # Errors
///
/// [`UnknownGroup`].
pub fn thickness_by_group(
    loaded: &LoadedMesh,
    common: f64,
    groups: &[(String, f64)],
) -> Result<Vec<f64>, UnknownGroup> {
    check_groups(groups, &loaded.names)?;
    let of = |face| thickness_of(groups, loaded.names_of(face), common);
    Ok(loaded.mesh.faces().map(of).collect())
}
