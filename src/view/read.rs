//! A mid-surface from a file, to look at.

use std::path::{Path, PathBuf};

use miette::Diagnostic;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;
use thiserror::Error;

use crate::io::write::vertex_code;
use crate::io::{ReadError, read_mesh};
use crate::mesh::sets::Sets;
use crate::surface::{
    Ball, Border, BorderKind, MidSurface, MidTriangle, MidVertex, Seam, SurfaceError, SurfaceParts,
    VertexKind,
};

/// Why a file cannot be shown as a mid-surface.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ShowError {
    /// No mesh.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mesh(#[from] ReadError),
    /// A mesh, but its figures make no mid-surface.
    #[error("{}: {source}", file.display())]
    #[diagnostic(help("give a file that `midsurf extract` wrote"))]
    Surface {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        #[source]
        source: SurfaceError,
    },
}

/// Reads a mid-surface as [`crate::io::write`] makes it. Sheets are what hangs
/// together over edges of two triangles, numbered by their lowest; footpoints are
/// not in files. Seams are found where three triangles meet, borders where the
/// file says what they are; each is a line of one edge.
///
/// # Errors
///
/// [`ShowError`] names the file and what to do.
pub fn read_surface(file: &Path) -> Result<MidSurface, ShowError> {
    let loaded = read_mesh(file)?;
    let mut mesh = loaded.mesh;
    mesh.triangles
        .retain(|&[a, b, c]| a != b && b != c && c != a);
    let values = loaded.values;
    let edges = mesh.edges();
    let mut sets = Sets::new(mesh.triangles.len());
    for uses in edges.by_edge() {
        if let [a, b] = uses {
            sets.join(a.face.0, b.face.0);
        }
    }
    let mut numbers = FxHashMap::default();
    let sheets: Vec<u32> = (0..mesh.triangles.len() as u32)
        .map(|triangle| {
            let next = numbers.len() as u32;
            *numbers.entry(sets.find(triangle)).or_insert(next)
        })
        .collect();
    let known: FxHashMap<[u32; 2], f64> = (values.edges.iter())
        .map(|&([a, b], kind)| ([a.min(b), a.max(b)], kind))
        .collect();
    let (mut seams, mut borders) = (Vec::new(), Vec::new());
    for uses in edges.by_edge() {
        let path = uses[0].edge.to_vec();
        match uses {
            [_, _] => {}
            [only] => {
                let border = known.get(&only.edge).and_then(|&kind| border_kind(kind));
                borders.extend(border.map(|kind| Border {
                    path,
                    sheet: sheets[only.face.index()],
                    kind,
                    closed: false,
                }));
            }
            _ => {
                let mut around: Vec<u32> = uses.iter().map(|u| sheets[u.face.index()]).collect();
                around.sort_unstable();
                seams.push(Seam {
                    path,
                    sheets: around,
                    closed: false,
                    unmarked: 0,
                });
            }
        }
    }
    let vertices = mesh.positions.iter().enumerate().map(|(v, &position)| {
        let of = |values: &[f64]| values.get(v).copied().unwrap_or(0.0);
        let thickness = of(&values.thickness);
        let radius = of(&values.radius);
        MidVertex {
            position,
            kind: vertex_kind(of(&values.kind)),
            ball: Ball {
                radius: if radius > 0.0 {
                    radius
                } else {
                    0.5 * thickness
                },
                thickness: if thickness > 0.0 {
                    thickness
                } else {
                    2.0 * radius
                },
                footpoints: SmallVec::new(),
            },
        }
    });
    let parts = SurfaceParts {
        vertices: vertices.collect(),
        triangles: (mesh.triangles.iter().zip(&sheets))
            .map(|(&corners, &sheet)| MidTriangle { corners, sheet })
            .collect(),
        seams,
        borders,
        creases: Vec::new(),
        junctions: Vec::new(),
    };
    MidSurface::new(parts).map_err(|source| ShowError::Surface {
        file: file.to_owned(),
        source,
    })
}

fn border_kind(code: f64) -> Option<BorderKind> {
    match vertex_kind(code) {
        VertexKind::CopingBorder => Some(BorderKind::Coping),
        VertexKind::FadingBorder => Some(BorderKind::Fading),
        _ => None,
    }
}

fn vertex_kind(code: f64) -> VertexKind {
    let kinds = [
        VertexKind::Seam,
        VertexKind::Junction,
        VertexKind::CopingBorder,
        VertexKind::FadingBorder,
    ];
    let found = kinds
        .into_iter()
        .find(|&k| f64::from(vertex_code(k)) == code);
    found.unwrap_or(VertexKind::Sheet)
}
