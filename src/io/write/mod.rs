//! Writers of mid-surfaces, of shell models and of solids, one file a format.
//!
//! Numbers are written so that reading them gives the same f64 back, except
//! in STL and GLB, which hold single precision, and in BDF, whose fields are
//! short. Files appear complete or not at all.

mod bdf;
mod csv;
mod fields;
mod glb;
mod inp;
mod msh;
mod obj;
mod painted;
mod picture;
mod ply;
mod real;
mod scalar;
mod shell;
mod solid;
mod stage;
mod stl;
mod template;
mod vtu;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;
use miette::Diagnostic;
use thiserror::Error;

use crate::settings::quote::shown_path;

pub use fields::{Figures, stage_fields};
pub use inp::Dialect;
pub use painted::stage_deviation;
pub use picture::stage_picture;
pub use scalar::{Scalars, stage_scalars};
pub use shell::{ShellFormat, ShellOptions, stage_shell, write_shell};
pub use solid::{Shade, SolidFormat, stage_solid, write_solid};
pub use stage::{Staged, abandon, check_target, stage};
pub use template::Template;

use crate::surface::{BorderKind, MidSurface, VertexKind};

/// Why an output file cannot be written.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum WriteError {
    /// Suffix of no known format.
    #[error("{}: has no suffix of a known output format", shown_path(file))]
    #[diagnostic(help("use {known}"))]
    UnknownFormat {
        /// The file asked for.
        file: PathBuf,
        /// Suffixes that would do.
        known: &'static str,
    },
    /// The folder is not there.
    #[error(
        "{}: the folder {} does not exist",
        shown_path(file),
        shown_path(folder)
    )]
    #[diagnostic(help("create the folder first, or write elsewhere"))]
    NoFolder {
        /// The file asked for.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The name belongs to a folder or a device.
    #[error("{}: is not a regular file and will not be replaced", shown_path(file))]
    #[diagnostic(help("choose another name"))]
    NotAFile {
        /// The file asked for.
        file: PathBuf,
    },
    /// Two outputs, or an output and an input, have the same name.
    #[error(
        "{}: this file is named twice, as {first} and as {second}",
        shown_path(file)
    )]
    #[diagnostic(help("give every file its own name"))]
    NamedTwice {
        /// The file.
        file: PathBuf,
        /// One role.
        first: &'static str,
        /// The other role.
        second: &'static str,
    },
    /// A number that no file should hold.
    #[error(
        "{}: vertex {vertex} would be written with a number that is not finite",
        shown_path(file)
    )]
    #[diagnostic(help("take a part of smaller coordinates, or smaller lengths"))]
    NotFinite {
        /// The file asked for.
        file: PathBuf,
        /// The first such vertex, counted from 0.
        vertex: usize,
    },
    /// The system refused.
    #[error("{}: cannot be written: {source}", shown_path(file))]
    #[diagnostic(help("check free space and permissions; nothing was left behind"))]
    Io {
        /// The file asked for.
        file: PathBuf,
        /// What the system said.
        #[source]
        source: io::Error,
    },
}

/// Formats of a mid-surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceFormat {
    /// Wavefront OBJ, one group a sheet, with a CSV of thickness beside it.
    Obj,
    /// Binary PLY with thickness, radius and kind a vertex, sheet a face, and
    /// seams and borders as edges.
    Ply,
    /// VTK unstructured grid for ParaView: triangles, and seams and borders
    /// as lines.
    Vtu,
    /// Binary STL: triangles only, single precision.
    Stl,
}

impl SurfaceFormat {
    /// The format that a file name's suffix stands for, in any case of letters.
    ///
    /// # Errors
    ///
    /// [`WriteError::UnknownFormat`].
    pub fn of(file: &Path) -> Result<SurfaceFormat, WriteError> {
        let suffix = file.extension().and_then(|suffix| suffix.to_str());
        match suffix.map(str::to_ascii_lowercase).as_deref() {
            Some("obj") => Ok(SurfaceFormat::Obj),
            Some("ply") => Ok(SurfaceFormat::Ply),
            Some("vtu") => Ok(SurfaceFormat::Vtu),
            Some("stl") => Ok(SurfaceFormat::Stl),
            _ => Err(WriteError::UnknownFormat {
                file: file.to_owned(),
                known: ".obj, .ply, .vtu, .stl, .inp, .bdf, .msh or .glb",
            }),
        }
    }
}

/// Choices for the writers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SurfaceOptions {
    /// Write seams and borders into OBJ files too, as `l` lines in groups of
    /// their own. Off by default, as many readers refuse or misread them.
    pub obj_lines: bool,
}

/// Refuses positions that are not finite as they will be written: the last
/// check before any file of a mesh. A [`MidSurface`] holds no others.
pub(crate) fn check_finite(
    positions: &[DVec3],
    single: bool,
    file: &Path,
) -> Result<(), WriteError> {
    check_rows(positions.iter().map(|p| p.to_array()), single, file)
}

/// The same for all numbers that stand at each vertex.
fn check_rows<const N: usize>(
    rows: impl Iterator<Item = [f64; N]>,
    single: bool,
    file: &Path,
) -> Result<(), WriteError> {
    let finite = |x: f64| match single {
        true => (x as f32).is_finite(),
        false => x.is_finite(),
    };
    let mut rows = rows;
    match rows.position(|row| !row.into_iter().all(finite)) {
        None => Ok(()),
        Some(vertex) => Err(WriteError::NotFinite {
            file: file.to_owned(),
            vertex,
        }),
    }
}

/// Number for a vertex kind in PLY and VTU.
pub fn vertex_code(kind: VertexKind) -> u8 {
    match kind {
        VertexKind::Sheet => 0,
        VertexKind::Seam => 1,
        VertexKind::Junction => 2,
        VertexKind::CopingBorder => 3,
        VertexKind::FadingBorder => 4,
    }
}

/// Number for an edge on a crease in PLY and VTU; its vertices are those of a
/// sheet.
pub const CREASE_CODE: u8 = 5;

/// Number for a border kind in PLY and VTU; that of its vertices.
fn border_code(kind: BorderKind) -> u8 {
    vertex_code(match kind {
        BorderKind::Coping => VertexKind::CopingBorder,
        BorderKind::Fading => VertexKind::FadingBorder,
    })
}

/// The CSV of thickness that goes beside an OBJ: `mid.obj` gives
/// `mid.thickness.csv`.
pub fn thickness_file(obj: &Path) -> PathBuf {
    obj.with_extension("thickness.csv")
}

/// All files that writing `file` makes.
///
/// # Errors
///
/// [`WriteError::UnknownFormat`].
pub fn files_for(file: &Path) -> Result<Vec<PathBuf>, WriteError> {
    let mut files = vec![file.to_owned()];
    if ShellFormat::of(file).is_some() {
        return Ok(files);
    }
    if SurfaceFormat::of(file)? == SurfaceFormat::Obj {
        files.push(thickness_file(file));
    }
    Ok(files)
}

/// Writes a mid-surface in the format of the file's suffix to a place beside
/// its target; nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_surface(
    surface: &MidSurface,
    file: &Path,
    options: SurfaceOptions,
) -> Result<Vec<Staged>, WriteError> {
    let format = SurfaceFormat::of(file)?;
    if format == SurfaceFormat::Stl {
        let positions: Vec<DVec3> = surface.vertices().iter().map(|v| v.position).collect();
        check_finite(&positions, true, file)?;
    }
    let mut staged = vec![stage(file, |out| {
        write_surface(surface, format, options, out)
    })?];
    if format == SurfaceFormat::Obj {
        staged.push(stage(&thickness_file(file), |out| {
            csv::write(surface, out)
        })?);
    }
    Ok(staged)
}

/// Writes a mid-surface to any sink.
///
/// # Errors
///
/// Those of the sink.
pub fn write_surface(
    surface: &MidSurface,
    format: SurfaceFormat,
    options: SurfaceOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    match format {
        SurfaceFormat::Obj => obj::write(surface, options, out),
        SurfaceFormat::Ply => ply::write(surface, out),
        SurfaceFormat::Vtu => vtu::write(surface, out),
        SurfaceFormat::Stl => {
            let position = |v: u32| surface.vertices()[v as usize].position;
            let corners = surface.triangles().iter().map(|t| t.corners.map(position));
            stl::write(corners, "mid-surface, binary STL", out)
        }
    }
}

/// Writes the thickness and radius of every vertex as CSV.
///
/// # Errors
///
/// Those of the sink.
pub fn write_thickness(surface: &MidSurface, out: &mut dyn Write) -> io::Result<()> {
    csv::write(surface, out)
}
