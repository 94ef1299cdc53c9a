//! Mid-surfaces read back: triangles, a ball at every vertex, seams and borders
//! as far as the file tells them.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use smallvec::SmallVec;
use thiserror::Error;

use super::read_bytes;
use super::{LoadedMesh, MeshFormat, ReadWarning, read_mesh};
use crate::io::Place;
use crate::io::error::ReadError;
use crate::io::text::{Lines, decode, excerpt};
use crate::io::write::{CREASE_CODE, thickness_file, vertex_code};
use crate::mesh::weld_exact;
use crate::settings::quote::{bounded, shown_path};
use crate::surface::build::build;
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};
use crate::surface::{Ball, MidSurface, VertexKind};

/// Where the radii come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RadiusSource {
    /// A column or property `radius`, in this file.
    Radius(PathBuf),
    /// Half of a column or property `thickness`, in this file: a little small
    /// near seams, where a ball is larger than that.
    HalfThickness(PathBuf),
}

impl RadiusSource {
    /// The file.
    pub fn file(&self) -> &Path {
        let (RadiusSource::Radius(file) | RadiusSource::HalfThickness(file)) = self;
        file
    }
}

/// A mid-surface from files.
#[derive(Clone, Debug)]
pub struct LoadedSurface {
    /// The surface; its footpoints are not known.
    pub surface: MidSurface,
    /// Where its radii come from.
    pub radius: RadiusSource,
    /// Whether the file tells coping borders from fading ones; if not, all
    /// count as coping.
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
    #[error("{}: no thickness: {looked}", shown_path(file))]
    #[diagnostic(help(
        "give a .ply with a vertex property `radius` or `thickness`, or an .obj with NAME.thickness.csv beside it, as `midsurf extract` writes them"
    ))]
    NoThickness {
        /// The mesh.
        file: PathBuf,
        /// Where it was looked for.
        looked: String,
    },
    /// A line of the table makes no sense.
    #[error("{}, line {line}: {}", shown_path(file), bounded(problem))]
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
    /// A radius or thickness is none.
    #[error(
        "{}: the radius {radius} of vertex {vertex} is not a length ({count} such in all)",
        shown_path(file)
    )]
    #[diagnostic(help(
        "every vertex needs a radius or thickness that is zero or more; extract the mid-surface again"
    ))]
    BadRadius {
        /// Where the radii come from.
        file: PathBuf,
        /// The first such vertex.
        vertex: usize,
        /// Its radius.
        radius: f64,
        /// Vertices with a radius that is negative or not finite.
        count: usize,
    },
}

/// Reads a mid-surface. The balls are those of the PLY file itself, or of the
/// table beside another file (`mid.obj`: `mid.thickness.csv`), or of `table`.
///
/// What `midsurf extract` wrote as a PLY comes back as it was, but for the
/// footpoints.
///
/// # Errors
///
/// [`SurfaceReadError`] names the file, and the line of a table.
pub fn read_surface(file: &Path, table: Option<&Path>) -> Result<LoadedSurface, SurfaceReadError> {
    let mut loaded = read_mesh(file)?;
    let count = loaded.mesh.positions.len();
    let beside = thickness_file(file);
    let given = std::mem::take(&mut loaded.values.radius);
    let thickness = std::mem::take(&mut loaded.values.thickness);
    let (radii, radius) = match table {
        Some(table) => read_table(table, count)?,
        None if !given.is_empty() => (given, RadiusSource::Radius(file.into())),
        None if !thickness.is_empty() => halved(thickness.clone(), file),
        None if beside.is_file() => read_table(&beside, count)?,
        None => {
            return Err(SurfaceReadError::NoThickness {
                file: file.into(),
                looked: format!(
                    "the file gives none for its vertices, and there is no {}",
                    shown_path(&beside)
                ),
            });
        }
    };
    // Twice the radius is a thickness.
    let bad = |r: &f64| !((2.0 * r).is_finite() && *r >= 0.0);
    if let Some(vertex) = radii.iter().position(bad) {
        return Err(SurfaceReadError::BadRadius {
            file: radius.file().into(),
            vertex,
            radius: radii[vertex],
            count: radii.iter().filter(|r| bad(r)).count(),
        });
    }
    // A thickness that stands beside the radius in the file itself is its own.
    let own = |v: usize| thickness.get(v).filter(|t| table.is_none() && !bad(t));
    let balls = (radii.iter().enumerate())
        .map(|(v, &radius)| Ball {
            radius,
            thickness: own(v).copied().unwrap_or(2.0 * radius),
            footpoints: SmallVec::new(),
        })
        .collect();
    let values = &loaded.values;
    Ok(LoadedSurface {
        kinds: !values.kind.is_empty() || !values.edges.is_empty(),
        surface: build(&marked(&loaded), balls),
        radius,
        vertices: count,
        triangles: loaded.mesh.triangles.len(),
        sha256: loaded.sha256,
        warnings: loaded.warnings,
    })
}

/// A mid-surface of any mesh file, and whether it tells a thickness; without
/// one its balls are empty. Vertices of an STL are joined where they are equal.
///
/// # Errors
///
/// As [`read_surface`], but for a missing thickness.
pub fn read_any_surface(file: &Path) -> Result<(MidSurface, bool), SurfaceReadError> {
    match read_surface(file, None) {
        Err(SurfaceReadError::NoThickness { .. }) => {}
        read => return read.map(|loaded| (loaded.surface, true)),
    }
    let mut loaded = read_mesh(file)?;
    if MeshFormat::of(file) == Some(MeshFormat::Stl) {
        let mesh = &mut loaded.mesh;
        let weld = weld_exact(&mesh.positions);
        let corners = mesh.triangles.iter_mut().flatten();
        corners.for_each(|v| *v = weld.new_index[*v as usize]);
        mesh.positions = (weld.kept.iter())
            .map(|&v| mesh.positions[v as usize])
            .collect();
    }
    let balls = vec![Ball::default(); loaded.mesh.positions.len()];
    Ok((build(&marked(&loaded), balls), false))
}

/// The mesh with what its file says of edges. A file that gives no edges marks
/// its borders by their vertices; one that gives no kinds at all has borders at
/// coping only.
fn marked(loaded: &LoadedMesh) -> MarkedMesh {
    let values = &loaded.values;
    let is = |kind: f64, of: VertexKind| kind == f64::from(vertex_code(of));
    let mut mesh = MarkedMesh {
        vertices: (loaded.mesh.positions.iter())
            .map(|&at| MarkedVertex {
                at,
                walls: SmallVec::new(),
                coping: None,
            })
            .collect(),
        triangles: loaded.mesh.triangles.clone(),
        ..MarkedMesh::default()
    };
    let fading = |v: u32| {
        let kind = values.kind.get(v as usize);
        kind.is_some_and(|&kind| is(kind, VertexKind::FadingBorder))
    };
    // A vertex where both kinds of border meet is of the coping one, so edges
    // that say what they are know better.
    if values.edges.is_empty() {
        for ((a, b), triangles) in mesh.edge_triangles() {
            let line = match triangles.len() {
                1 if fading(a) || fading(b) => Line::FadingBorder,
                1 => Line::CopingBorder,
                2 => continue,
                _ => Line::Seam,
            };
            mesh.lines.insert((a, b), line);
        }
    }
    for &([a, b], kind) in &values.edges {
        let line = [
            (vertex_code(VertexKind::Seam), Line::Seam),
            (vertex_code(VertexKind::CopingBorder), Line::CopingBorder),
            (vertex_code(VertexKind::FadingBorder), Line::FadingBorder),
            (CREASE_CODE, Line::Crease),
        ]
        .into_iter()
        .find(|(code, _)| kind == f64::from(*code));
        if let Some((_, line)) = line {
            mesh.lines.insert(edge(a, b), line);
        }
    }
    mesh
}

fn halved(mut thickness: Vec<f64>, file: &Path) -> (Vec<f64>, RadiusSource) {
    for value in &mut thickness {
        *value *= 0.5;
    }
    (thickness, RadiusSource::HalfThickness(file.into()))
}

/// Radii of all vertices from a table.
fn read_table(file: &Path, count: usize) -> Result<(Vec<f64>, RadiusSource), SurfaceReadError> {
    let bytes =
        read_bytes(file).map_err(|problem| ReadError::new(file, (Place::Whole, problem)))?;
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
