//! Control meshes of subdivision surfaces, read and checked.

use std::path::Path;

use super::{IntakeError, check_size, read_warning};
use crate::io::quote::{figure, shown_path};
use crate::io::{ControlMesh, Place, read_control};
use crate::settings::warning::Warning;
use crate::subdivide::Cage;

/// A checked control mesh that looks outward, and what is worth knowing of it.
#[derive(Clone, Debug)]
pub struct ControlInput {
    /// The mesh.
    pub cage: Cage,
    /// SHA-256 of the file's bytes, in hexadecimal; empty where there is no file.
    pub sha256: String,
    /// What was odd but could be put right.
    pub warnings: Vec<Warning>,
}

impl ControlInput {
    /// Reads a control mesh.
    ///
    /// # Errors
    ///
    /// [`IntakeError`].
    pub fn read(file: &Path) -> Result<ControlInput, IntakeError> {
        check_size(file)?;
        let mesh = read_control(file)?;
        let cage = Cage::new(mesh.positions.clone(), &mesh.faces).map_err(|problem| {
            let place = match (problem.face(), problem.vertex()) {
                (Some(face), _) => mesh.place_of_face(face),
                (_, Some(vertex)) => mesh.place_of_vertex(vertex),
                _ => Place::Whole,
            };
            IntakeError::Control {
                file: file.to_owned(),
                place,
                problem,
            }
        })?;
        let ControlMesh {
            sha256, warnings, ..
        } = mesh;
        let warnings = warnings.iter().map(|warning| read_warning(file, warning));
        Ok(ControlInput {
            sha256,
            ..ControlInput::of(cage, file, warnings.collect())
        })
    }

    /// A control mesh; one that is inside out is turned. `file` is its name in
    /// messages, `warnings` what was said of it so far.
    pub fn of(cage: Cage, file: &Path, mut warnings: Vec<Warning>) -> ControlInput {
        let volume = cage.volume();
        let inside_out = cage.is_closed() && volume < 0.0;
        if inside_out {
            let message = format!(
                "{}: the control mesh was inside out (volume {}); all faces were turned",
                shown_path(file),
                figure(volume)
            );
            warnings.push(Warning::new("inside_out", message));
        }
        ControlInput {
            cage: if inside_out { cage.turned_over() } else { cage },
            sha256: String::new(),
            warnings,
        }
    }
}
