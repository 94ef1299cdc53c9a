//! The solid of a part: its bodies in one, its cavities kept or filled.

use glam::DVec3;
use serde::Serialize;

use super::OffsetWarning;
use crate::mesh::{Part, closed_shells, self_intersections};

/// What becomes of cavities that a part has already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Voids {
    /// They stay; the solid is offset from them too.
    #[default]
    Keep,
    /// They are filled first.
    Fill,
}

/// A cavity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Void {
    /// Its volume, cubic part units.
    pub volume: f64,
    /// Middle of the box around it.
    pub at: DVec3,
}

/// A part made one solid.
pub(super) struct Bodies {
    /// None where the part is that solid as it stands.
    pub solid: Option<Part>,
    pub voids: Vec<Void>,
    pub warning: Option<OffsetWarning>,
}

/// Unites bodies that overlap or touch, and fills cavities if asked to.
pub(super) fn one_solid(part: &Part, voids: Voids) -> Bodies {
    let pairs = self_intersections(part.mesh()).len();
    let mut solid = (pairs > 0).then(|| part.united().ok()).flatten();
    let warning = match &solid {
        _ if pairs == 0 => None,
        None => Some(OffsetWarning::SelfIntersecting { pairs }),
        // Vertices of the seams are rounded: that may let needles cut others.
        Some(united) => Some(match self_intersections(united.mesh()).len() {
            0 => OffsetWarning::United { pairs },
            pairs => OffsetWarning::SelfIntersecting { pairs },
        }),
    };
    if voids == Voids::Fill
        && let Some(filled) = solid.as_ref().unwrap_or(part).without_voids()
    {
        solid = Some(filled);
    }
    Bodies {
        voids: voids_of(solid.as_ref().unwrap_or(part)),
        solid,
        warning,
    }
}

fn voids_of(part: &Part) -> Vec<Void> {
    let mesh = part.mesh();
    let shells = closed_shells(mesh, &mesh.edges()).into_iter();
    let voids = shells.filter(|shell| shell.volume < 0.0);
    let void = |shell: crate::mesh::Shell| Void {
        volume: -shell.volume,
        at: shell.bounds.center(),
    };
    voids.map(void).collect()
}
