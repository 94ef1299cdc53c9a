//! Mid-surfaces read back: triangles, a ball at every vertex, and which free
//! borders end flat.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use rustc_hash::FxHashSet;
use thiserror::Error;

use super::{ReadWarning, read_mesh};
use crate::io::error::ReadError;
use crate::io::text::{Lines, decode, excerpt};
use crate::io::write::{thickness_file, vertex_code};
use crate::rethicken::{BallSurface, RethickenError};
use crate::surface::VertexKind;

/// Where the radii come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RadiusSource {
    /// A column or property `radius`, in this file.
    Radius(PathBuf),
    /// Half of a column or property `thickness`, in this file: a little small
    /// near seams, where a ball is larger than that.
    HalfThickness(PathBuf),
}

/// A mid-surface from files.
#[derive(Clone, Debug)]
pub struct LoadedSurface {
    /// The surface.
    pub surface: BallSurface,
    /// Where its radii come from.
    pub radius: RadiusSource,
    /// Whether the file tells coping borders from fading ones; if not, all
    /// end flat.
    pub kinds: bool,
    /// Vertices of the file.
    pub vertices: usize,
    /// Triangles of the file.
    pub triangles: usize,
    /// SHA-256 of the mesh file.
    pub sha256: String,
    /// What was odd but could be read.
    pub warnings: Vec<ReadWarning>,
}

/// Why a mid-surface could not be read.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum SurfaceReadError {
    /// No mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mesh(#[from] ReadError),
    /// No radius or thickness.
    #[error("{}: no thickness: {looked}", file.display())]
    #[diagnostic(help(
        "give a .ply with a vertex property `radius` or `thickness`, or an .obj with NAME.thickness.csv beside it, as `midsurf extract` writes them"
    ))]
    NoThickness {
        /// The mesh.
        file: PathBuf,
        /// Where it was looked for.
        looked: String,
    },
    /// The table could not be read.
    #[error("{}: cannot be read: {source}", file.display())]
    #[diagnostic(help("check the path and the permissions"))]
    Io {
        /// The table.
        file: PathBuf,
        /// What the system said.
        #[source]
        source: std::io::Error,
    },
    /// A line of the table makes no sense.
    #[error("{}, line {line}: {problem}", file.display())]
    #[diagnostic(help(
        "the table has a header `vertex_index,thickness` or `vertex_index,radius`, and one line for every vertex, counted from 0"
    ))]
    Table {
        /// The table.
        file: PathBuf,
        /// Counted from 1.
        line: u64,
        /// What is wrong.
        problem: String,
    },
    /// The numbers make no solid.
    #[error("{}: {source}", file.display())]
    #[diagnostic(help(
        "every vertex needs a radius or thickness that is zero or more; extract the mid-surface again"
    ))]
    Balls {
        /// Where the radii come from.
        file: PathBuf,
        /// What is wrong.
        #[source]
        source: RethickenError,
    },
}

/// Reads a mid-surface. The balls are those of the PLY file itself, or of the
/// table beside another file (`mid.obj`: `mid.thickness.csv`), or of `table`.
/// With `round`, free borders of every kind end round.
///
/// # Errors
///
/// [`SurfaceReadError`] names the file, and the line of a table.
pub fn read_surface(
    file: &Path,
    table: Option<&Path>,
    round: bool,
) -> Result<LoadedSurface, SurfaceReadError> {
    let loaded = read_mesh(file)?;
    let count = loaded.mesh.positions.len();
    let beside = thickness_file(file);
    let values = loaded.values;
    let (radii, radius) = match table {
        Some(table) => read_table(table, count)?,
        None if !values.radius.is_empty() => (values.radius, RadiusSource::Radius(file.into())),
        None if !values.thickness.is_empty() => halved(values.thickness, file),
        None if beside.is_file() => read_table(&beside, count)?,
        None => {
            return Err(SurfaceReadError::NoThickness {
                file: file.into(),
                looked: format!(
                    "the file gives none for its vertices, and there is no {}",
                    beside.display()
                ),
            });
        }
    };
    let kinds = !values.kind.is_empty() || !values.edges.is_empty();
    let is = |kind: f64, of: VertexKind| kind == f64::from(vertex_code(of));
    let coping: FxHashSet<[u32; 2]> = (values.edges.iter())
        .filter(|(_, kind)| is(*kind, VertexKind::CopingBorder))
        .map(|([a, b], _)| [*a.min(b), *a.max(b)])
        .collect();
    let fading = |v: u32| {
        let kind = values.kind.get(v as usize);
        kind.is_some_and(|&kind| is(kind, VertexKind::FadingBorder))
    };
    // A vertex where both kinds of border meet is of the coping one, so edges
    // that say what they are know better.
    let flat = |[a, b]: [u32; 2]| {
        !round
            && if values.edges.is_empty() {
                !fading(a) && !fading(b)
            } else {
                coping.contains(&[a.min(b), a.max(b)])
            }
    };
    let triangles = loaded.mesh.triangles.len();
    let surface = BallSurface::new(loaded.mesh.positions, radii, loaded.mesh.triangles, flat)
        .map_err(|source| SurfaceReadError::Balls {
            file: match &radius {
                RadiusSource::Radius(file) | RadiusSource::HalfThickness(file) => file.clone(),
            },
            source,
        })?;
    Ok(LoadedSurface {
        surface,
        radius,
        kinds,
        vertices: count,
        triangles,
        sha256: loaded.sha256,
        warnings: loaded.warnings,
    })
}

fn halved(mut thickness: Vec<f64>, file: &Path) -> (Vec<f64>, RadiusSource) {
    for value in &mut thickness {
        *value *= 0.5;
    }
    (thickness, RadiusSource::HalfThickness(file.into()))
}

/// Radii of all vertices from a table.
fn read_table(file: &Path, count: usize) -> Result<(Vec<f64>, RadiusSource), SurfaceReadError> {
    let bytes = std::fs::read(file).map_err(|source| SurfaceReadError::Io {
        file: file.into(),
        source,
    })?;
    let fail = |line: u64, problem: String| SurfaceReadError::Table {
        file: file.into(),
        line,
        problem,
    };
    let mut lines = Lines::new(&bytes)
        .map(|(number, line)| (number, decode(line)))
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (number, header) = lines
        .next()
        .ok_or_else(|| fail(1, "the table is empty".to_owned()))?;
    let names: Vec<String> = header
        .split(',')
        .map(|n| n.trim().to_ascii_lowercase())
        .collect();
    let column = |name: &str| names.iter().position(|n| n == name);
    let index = column("vertex_index").ok_or_else(|| {
        let names = excerpt(&header);
        fail(number, format!("no column `vertex_index` in {names:?}"))
    })?;
    let (value, is_radius) = match (column("radius"), column("thickness")) {
        (Some(radius), _) => (radius, true),
        (None, Some(thickness)) => (thickness, false),
        (None, None) => {
            let names = excerpt(&header);
            return Err(fail(
                number,
                format!("no column `radius` or `thickness` in {names:?}"),
            ));
        }
    };
    let mut radii: Vec<Option<f64>> = vec![None; count];
    for (number, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let cell = |at: usize| cells.get(at).copied().unwrap_or("");
        let vertex: usize = (cell(index).parse()).map_err(|_| {
            fail(
                number,
                format!("{:?} is not a vertex number", excerpt(cell(index))),
            )
        })?;
        let given: f64 = (cell(value).parse()).map_err(|_| {
            fail(
                number,
                format!("{:?} is not a number", excerpt(cell(value))),
            )
        })?;
        let slot = radii.get_mut(vertex).ok_or_else(|| {
            fail(
                number,
                format!("vertex {vertex} does not exist: the mesh has {count}"),
            )
        })?;
        if slot.replace(given).is_some() {
            return Err(fail(number, format!("vertex {vertex} is given twice")));
        }
    }
    let total = Lines::new(&bytes).count() as u64;
    let radii = (radii.into_iter().enumerate())
        .map(|(v, radius)| radius.ok_or_else(|| fail(total, format!("vertex {v} is missing"))))
        .collect::<Result<Vec<f64>, SurfaceReadError>>()?;
    Ok(if is_radius {
        (radii, RadiusSource::Radius(file.into()))
    } else {
        halved(radii, file)
    })
}
