//! Shell models: formats, options, staging.

use std::io::{self, Write};
use std::path::Path;

use super::inp::Dialect;
use super::template::Template;
use super::{Staged, WriteError, bdf, check_rows, glb, inp, msh, stage};
use crate::shell::{Order, ShellModel, ShellNode};

/// Formats of a shell model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShellFormat {
    /// CalculiX or Abaqus.
    Inp,
    /// Nastran bulk data.
    Bdf,
    /// Gmsh 4.1.
    Msh,
    /// Binary glTF, to look at.
    Glb,
}

/// Choices for the writers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShellOptions {
    /// Whose names the elements of an `.inp` have.
    pub dialect: Dialect,
    /// Supports, loads and steps of an `.inp`.
    pub template: Option<Template>,
}

impl ShellFormat {
    /// The format that a file name's suffix stands for, in any case of letters.
    pub fn of(file: &Path) -> Option<ShellFormat> {
        let suffix = file.extension()?.to_str()?.to_ascii_lowercase();
        match suffix.as_str() {
            "inp" => Some(ShellFormat::Inp),
            "bdf" | "nas" | "dat" => Some(ShellFormat::Bdf),
            "msh" => Some(ShellFormat::Msh),
            "glb" => Some(ShellFormat::Glb),
            _ => None,
        }
    }

    /// Order of the elements where none is asked for: triangles of first order
    /// are much too stiff in CalculiX.
    pub fn order(self, dialect: Dialect) -> Order {
        match (self, dialect) {
            (ShellFormat::Inp, Dialect::Calculix) => Order::Quadratic,
            _ => Order::Linear,
        }
    }
}

/// Writes a model in the format of the file's suffix to a place beside its
/// target; nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_shell(
    model: &ShellModel,
    file: &Path,
    options: ShellOptions,
) -> Result<Staged, WriteError> {
    let format = ShellFormat::of(file).ok_or_else(|| WriteError::UnknownFormat {
        file: file.to_owned(),
        known: ".inp, .bdf, .msh or .glb",
    })?;
    check_model(model, format, file)?;
    stage(file, |out| write_shell(model, format, options, out))
}

/// Refuses a model with numbers that are not finite as they will be written.
fn check_model(model: &ShellModel, format: ShellFormat, file: &Path) -> Result<(), WriteError> {
    let single = format == ShellFormat::Glb;
    let node = |n: &ShellNode| {
        let [x, y, z] = n.position.to_array();
        [x, y, z, n.thickness]
    };
    check_rows(model.nodes.iter().map(node), single, file)?;
    // A normal is named by a node that has it.
    let corners =
        (model.elements.iter()).flat_map(|element| element.nodes.iter().zip(&element.normals));
    let bad = |&&n: &&u32| !model.normals[n as usize].is_finite();
    let vertex = corners
        .into_iter()
        .find(|(_, n)| bad(n))
        .map(|(v, _)| *v as usize);
    vertex.map_or(Ok(()), |vertex| {
        Err(WriteError::NotFinite {
            file: file.to_owned(),
            vertex,
        })
    })
}

/// Writes a model to any sink.
///
/// # Errors
///
/// Those of the sink.
pub fn write_shell(
    model: &ShellModel,
    format: ShellFormat,
    options: ShellOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        ShellFormat::Inp => inp::write(model, options.dialect, options.template, out),
        ShellFormat::Bdf => bdf::write(model, out),
        ShellFormat::Msh => msh::write(model, out),
        ShellFormat::Glb => glb::write(model, out),
    }
}
