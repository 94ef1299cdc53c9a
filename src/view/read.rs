//! A mid-surface from a file, to look at.

use std::path::Path;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::io::write::vertex_code;
use crate::io::{ReadError, read_mesh};
use crate::mesh::sets::Sets;
use crate::surface::{
    BorderKind, BorderLine, MidSurface, MidTriangle, MidVertex, SeamLine, VertexKind,
};

/// Reads a mid-surface as [`crate::io::write`] makes it. Sheets are what hangs
/// together over edges of two triangles, numbered by their lowest; footpoints are
/// not in files. Seams are found where three triangles meet, borders where the
/// file says what they are; each is a line of one edge.
///
/// # Errors
///
/// [`ReadError`] names the file, the line or byte, and what to do.
pub fn read_surface(file: &Path) -> Result<MidSurface, ReadError> {
    let loaded = read_mesh(file)?;
    let mesh = loaded.mesh;
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
                borders.extend(border.map(|kind| BorderLine {
                    path,
                    sheet: sheets[only.face.index()],
                    kind,
                    closed: false,
                }));
            }
            _ => {
                let mut around: Vec<u32> = uses.iter().map(|u| sheets[u.face.index()]).collect();
                around.sort_unstable();
                seams.push(SeamLine {
                    path,
                    sheets: around,
                    closed: false,
                });
            }
        }
    }
    let vertices = mesh.positions.iter().enumerate().map(|(v, &position)| {
        let radius = || values.radius.get(v).map_or(0.0, |radius| 2.0 * radius);
        MidVertex {
            position,
            kind: vertex_kind(values.kind.get(v).copied().unwrap_or(0.0)),
            thickness: values.thickness.get(v).copied().unwrap_or_else(radius),
            footpoints: SmallVec::new(),
        }
    });
    Ok(MidSurface {
        vertices: vertices.collect(),
        triangles: (mesh.triangles.iter().zip(&sheets))
            .map(|(&corners, &sheet)| MidTriangle { corners, sheet })
            .collect(),
        seams,
        borders,
        junctions: Vec::new(),
        sheet_count: numbers.len() as u32,
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
