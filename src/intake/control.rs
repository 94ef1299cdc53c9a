//! Control meshes of subdivision surfaces, read and checked.

use std::path::Path;

use super::balls::{check_groups, thickness_of};
use super::{IntakeError, check_size, read_warning};
use crate::io::{BoundaryTag, ControlMesh, Place, TagKind, read_control};
use crate::settings::quote::shown_path;
use crate::settings::warning::Warning;
use crate::subdivide::{Boundary, Cage, CageError, Tags};

/// A checked control mesh that looks outward, and what is worth knowing of it.
#[derive(Clone, Debug)]
pub struct ControlInput {
    /// The mesh with its tags.
    pub cage: Cage,
    /// What becomes of the boundary, by the file's tag.
    pub boundary: Boundary,
    /// SHA-256 of the file's bytes, in hexadecimal; empty where there is no file.
    pub sha256: String,
    /// What was odd but could be put right.
    pub warnings: Vec<Warning>,
}

impl ControlInput {
    /// Reads a control mesh. Walls of `thickness` are others where `groups` name
    /// faces.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn read(
        file: &Path,
        thickness: Option<f64>,
        groups: &[(String, f64)],
    ) -> Result<ControlInput, IntakeError> {
        check_size(file)?;
        let mesh = read_control(file)?;
        check_groups(groups, &mesh.names).map_err(|problem| IntakeError::Group {
            file: file.to_owned(),
            problem,
        })?;
        let tags = Tags {
            creases: mesh.tags.creases.clone(),
            corners: mesh.tags.corners.clone(),
            holes: mesh.tags.holes.clone(),
            shares: shares(&mesh, thickness, groups),
        };
        let cage = Cage::new(mesh.positions.clone(), &mesh.faces)
            .and_then(|cage| cage.tagged(&tags))
            .map_err(|problem| IntakeError::Control {
                file: file.to_owned(),
                place: place_of(&problem, &mesh),
                problem,
            })?;
        let boundary = match mesh.tags.boundary {
            Some(BoundaryTag::EdgeOnly) => Boundary::EdgeOnly,
            Some(BoundaryTag::None) => Boundary::None,
            Some(BoundaryTag::EdgeAndCorner) | None => Boundary::EdgeAndCorner,
        };
        let warnings = mesh.warnings.iter().map(|w| read_warning(file, w));
        Ok(ControlInput {
            boundary,
            sha256: mesh.sha256.clone(),
            ..ControlInput::of(cage, file, warnings.collect())
        })
    }

    /// A control mesh; shells that are inside out are turned. `file` is its name in
    /// messages, `warnings` what was said of it so far.
    pub fn of(cage: Cage, file: &Path, mut warnings: Vec<Warning>) -> ControlInput {
        let faces = cage.face_count();
        let (cage, turned) = cage.outward();
        if turned > 0 {
            let message = format!(
                "{}: {turned} of {faces} faces belong to shells that were inside out, and were turned",
                shown_path(file)
            );
            warnings.push(Warning::new("inside_out", message));
        }
        ControlInput {
            cage,
            boundary: Boundary::default(),
            sha256: String::new(),
            warnings,
        }
    }
}

/// Thickness at each vertex over the common one: the mean of the faces' there.
fn shares(mesh: &ControlMesh, thickness: Option<f64>, groups: &[(String, f64)]) -> Vec<f64> {
    let (false, Some(common)) = (groups.is_empty(), thickness) else {
        return Vec::new();
    };
    let mut sums = vec![(0.0, 0.0); mesh.positions.len()];
    for (face, corners) in (0..).zip(&mesh.faces) {
        let share = thickness_of(groups, mesh.names.of(face), common) / common;
        for &v in corners {
            let (sum, count) = &mut sums[v as usize];
            *sum += share;
            *count += 1.0;
        }
    }
    // A vertex without faces is refused later.
    let mean = |(sum, count): (f64, f64)| if count > 0.0 { sum / count } else { 1.0 };
    sums.into_iter().map(mean).collect()
}

/// Where the file states what an error names.
fn place_of(error: &CageError, mesh: &ControlMesh) -> Place {
    if let Some(face) = error.face() {
        return mesh.place_of_face(face);
    }
    if let Some(vertex) = error.vertex() {
        return mesh.place_of_vertex(vertex);
    }
    match *error {
        CageError::NoSuchEdge { tag, .. } => mesh.tags.place_of(TagKind::Crease, tag),
        CageError::NoSuchCorner { tag, .. } => mesh.tags.place_of(TagKind::Corner, tag),
        CageError::NoSuchHole { tag, .. } => mesh.tags.place_of(TagKind::Hole, tag),
        _ => Place::Whole,
    }
}
