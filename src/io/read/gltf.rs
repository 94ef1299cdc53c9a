//! glTF 2.0: the triangles of the scene's nodes, placed as they say.
//!
//! A facet's object is the name of its node, or of its mesh; its material is that
//! of its primitive. Numbers stay as they are; the format says that they are metres.
//! Vertices that are split for their normals are one where they are equal to the
//! bit. Not read: compressed and sparse data, skins, morphs.

use std::path::{Component, Path};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{DMat4, DQuat, DVec3, DVec4};
use serde::Deserialize;

use super::bytes::{read_bytes, room};
use super::loaded::{FacetPlaces, RawMesh};
use crate::io::error::{Located, Place, Problem};
use crate::io::names::NamesBuilder;
use crate::io::text::excerpt;
use crate::io::unit::Unit;
use crate::mesh::{TriMesh, weld_exact};

/// First bytes of a binary file, and the names of its chunks.
const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// Most triangles that nodes of one mesh may add up to: a small file can claim any
/// number of them.
const MOST_TRIANGLES: usize = 200_000_000;

/// Extensions without which the geometry cannot be read.
const COMPRESSED: [&str; 3] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
#[derive(Default)]
struct Document {
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
    extensions_required: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Node {
    name: Option<String>,
    mesh: Option<usize>,
    children: Vec<usize>,
    matrix: Option<[f64; 16]>,
    translation: Option<[f64; 3]>,
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Mesh {
    name: Option<String>,
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: Attributes,
    indices: Option<usize>,
    material: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
}

fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "POSITION")]
    position: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Material {
    name: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// Reads a file; `folder` is where buffers in files of their own lie, if anywhere.
pub(super) fn parse(bytes: &[u8], folder: Option<&Path>) -> Result<RawMesh, Located> {
    let (text, chunk) = if bytes.starts_with(MAGIC) {
        chunks(bytes)?
    } else {
        (bytes, None)
    };
    let document: Document = serde_json::from_slice(text).map_err(|error| {
        let place = match bytes.starts_with(MAGIC) {
            true => Place::Whole,
            false => Place::Line(error.line() as u64),
        };
        (place, Problem::Syntax(format!("this is no glTF: {error}")))
    })?;
    let needs = |name: &&&str| document.extensions_required.iter().any(|own| own == *name);
    if let Some(name) = COMPRESSED.iter().find(needs) {
        return Err(syntax(format!(
            "its geometry is compressed ({name}): export it without compression"
        )));
    }
    let buffers = buffers(&document, chunk, folder)?;
    let mut scene = SceneReader {
        document: &document,
        buffers,
        positions: Vec::new(),
        triangles: Vec::new(),
        names: NamesBuilder::default(),
        visited: vec![false; document.nodes.len()],
    };
    scene.read()?;
    Ok(scene.finish())
}

fn syntax(message: String) -> Located {
    (Place::Whole, Problem::Syntax(message))
}

fn missing(what: &str, index: usize) -> Located {
    syntax(format!("{what} {index} does not exist"))
}

/// The text of a binary file, and its bytes.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Located> {
    let cut = |at: usize| {
        let message = "a chunk is cut short".to_owned();
        (Place::Byte(at as u64), Problem::Truncated(message))
    };
    let word = |at: usize| -> Result<u32, Located> {
        let word = bytes.get(at..at + 4).ok_or_else(|| cut(at))?;
        Ok(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    let version = word(4)?;
    if version != 2 {
        return Err(syntax(format!("glTF {version} is not read, only glTF 2")));
    }
    let (mut text, mut data) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let length = word(at)? as usize;
        let kind = bytes.get(at + 4..at + 8).ok_or_else(|| cut(at))?;
        let chunk = bytes.get(at + 8..at + 8 + length).ok_or_else(|| cut(at))?;
        match kind {
            JSON => text = text.or(Some(chunk)),
            BIN => data = data.or(Some(chunk)),
            _ => {}
        }
        at += 8 + length;
    }
    let text = text.ok_or_else(|| syntax("the file has no JSON chunk".to_owned()))?;
    Ok((text, data))
}

/// The bytes of all buffers.
fn buffers(
    document: &Document,
    chunk: Option<&[u8]>,
    folder: Option<&Path>,
) -> Result<Vec<Vec<u8>>, Located> {
    let one = |(index, buffer): (usize, &Buffer)| match (&buffer.uri, chunk) {
        (None, Some(chunk)) if index == 0 => Ok(chunk.to_vec()),
        (None, _) => Err(syntax(format!("buffer {index} has no data"))),
        (Some(uri), _) => match uri.strip_prefix("data:") {
            Some(data) => {
                let (_, text) = data.split_once(";base64,").unwrap_or(("", ""));
                (STANDARD.decode(text))
                    .map_err(|error| syntax(format!("buffer {index} is no base64: {error}")))
            }
            None => beside(uri, folder),
        },
    };
    document.buffers.iter().enumerate().map(one).collect()
}

/// A buffer in a file of its own, in the file's folder or below.
fn beside(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, Located> {
    let name = Path::new(uri);
    let below = name.components().all(|c| matches!(c, Component::Normal(_)));
    match folder {
        Some(folder) if below => read_bytes(&folder.join(name)).map_err(|problem| {
            let name = excerpt(uri);
            syntax(format!("its buffer {name:?}: {problem}"))
        }),
        _ => Err(syntax(format!(
            "its buffer {:?} lies elsewhere: save it as .glb",
            excerpt(uri)
        ))),
    }
}

struct SceneReader<'d> {
    document: &'d Document,
    buffers: Vec<Vec<u8>>,
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    names: NamesBuilder,
    /// Nodes met: a node stands in the tree once.
    visited: Vec<bool>,
}

impl SceneReader<'_> {
    fn read(&mut self) -> Result<(), Located> {
        let document = self.document;
        if document.nodes.is_empty() {
            for mesh in 0..document.meshes.len() {
                self.mesh(mesh, DMat4::IDENTITY, None)?;
            }
            return Ok(());
        }
        let roots: Vec<usize> = match document.scenes.get(document.scene.unwrap_or(0)) {
            Some(scene) => scene.nodes.clone(),
            None => {
                let mut child = vec![false; document.nodes.len()];
                for &index in document.nodes.iter().flat_map(|node| &node.children) {
                    if let Some(child) = child.get_mut(index) {
                        *child = true;
                    }
                }
                (0..child.len()).filter(|&n| !child[n]).collect()
            }
        };
        let mut open: Vec<(usize, DMat4)> =
            roots.iter().rev().map(|&n| (n, DMat4::IDENTITY)).collect();
        while let Some((index, above)) = open.pop() {
            let node = (document.nodes.get(index)).ok_or_else(|| missing("node", index))?;
            if std::mem::replace(&mut self.visited[index], true) {
                return Err(syntax(format!("node {index} is in the tree twice")));
            }
            let place = above * placement(node);
            if let Some(mesh) = node.mesh {
                self.mesh(mesh, place, node.name.as_deref())?;
            }
            open.extend(node.children.iter().rev().map(|&child| (child, place)));
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, place: DMat4, node: Option<&str>) -> Result<(), Located> {
        let meshes = &self.document.meshes;
        let mesh = meshes.get(index).ok_or_else(|| missing("mesh", index))?;
        let name = node.or(mesh.name.as_deref()).filter(|n| !n.is_empty());
        self.names.set_object(name.map(str::to_owned));
        for primitive in &mesh.primitives {
            if !(4..=6).contains(&primitive.mode) {
                continue;
            }
            let material = primitive
                .material
                .and_then(|m| self.document.materials.get(m));
            self.names
                .set_material(material.and_then(|m| m.name.clone()));
            self.primitive(primitive, place)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, place: DMat4) -> Result<(), Located> {
        let Some(position) = primitive.attributes.position else {
            return Ok(());
        };
        let first = self.positions.len();
        let points = self.values(position, "VEC3")?;
        let count = points.len() / 3;
        if first + count > u32::MAX as usize {
            return Err((Place::Whole, Problem::TooMany("vertices")));
        }
        room(&mut self.positions, count)?;
        for point in points.chunks_exact(3) {
            let at = place.transform_point3(DVec3::from_slice(point));
            if !at.is_finite() {
                let word = format!("{at}");
                return Err((Place::Whole, Problem::NotFinite { word }));
            }
            self.positions.push(at);
        }
        let corners: Vec<usize> = match primitive.indices {
            None => (0..count).collect(),
            Some(indices) => {
                let indices = self.values(indices, "SCALAR")?;
                let index = |value: &f64| *value as usize;
                indices.iter().map(index).collect()
            }
        };
        if let Some(&beyond) = corners.iter().find(|&&corner| corner >= count) {
            let (index, vertices) = (beyond as i64, count);
            let relative = false;
            let problem = Problem::IndexOutOfRange {
                index,
                vertices,
                relative,
            };
            return Err((Place::Whole, problem));
        }
        let picked: Vec<[usize; 3]> = match primitive.mode {
            4 => corners
                .chunks_exact(3)
                .map(|t| [t[0], t[1], t[2]])
                .collect(),
            // Every second triangle of a strip runs the other way round.
            5 => (corners.windows(3).enumerate())
                .map(|(k, t)| [t[k % 2], t[1 - k % 2], t[2]])
                .collect(),
            _ => (corners.get(1..).unwrap_or_default().windows(2))
                .map(|t| [corners[0], t[0], t[1]])
                .collect(),
        };
        if self.triangles.len() + picked.len() > MOST_TRIANGLES {
            return Err((Place::Whole, Problem::TooMany("triangles")));
        }
        // A mirrored copy would be inside out.
        let mirrored = place.determinant() < 0.0;
        for [a, b, c] in picked {
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            self.triangles.push(triangle.map(|v| (first + v) as u32));
            self.names.push_facet();
        }
        Ok(())
    }

    /// All numbers of an accessor, one after the other.
    fn values(&self, index: usize, kind: &str) -> Result<Vec<f64>, Located> {
        let document = self.document;
        let accessor = (document.accessors.get(index)).ok_or_else(|| missing("accessor", index))?;
        if accessor.kind != kind || accessor.sparse.is_some() {
            let message = format!("accessor {index} is no plain {kind}");
            return Err(syntax(message));
        }
        let view = (accessor.buffer_view).and_then(|view| document.buffer_views.get(view));
        let view = view.ok_or_else(|| syntax(format!("accessor {index} has no data")))?;
        let buffer =
            (self.buffers.get(view.buffer)).ok_or_else(|| missing("buffer", view.buffer))?;
        let cut = || syntax(format!("accessor {index} reaches past the end of its data"));
        let end = view.byte_offset.checked_add(view.byte_length);
        let data = end.and_then(|end| buffer.get(view.byte_offset..end));
        let data = data.and_then(|data| data.get(accessor.byte_offset..));
        let data = data.ok_or_else(cut)?;
        let (size, read) = component(accessor)
            .ok_or_else(|| syntax(format!("accessor {index} has numbers of no known type")))?;
        let width = if kind == "VEC3" { 3 } else { 1 };
        let stride = view.byte_stride.unwrap_or(size * width).max(1);
        let last = accessor.count.saturating_sub(1).checked_mul(stride);
        let needed = last.and_then(|last| last.checked_add(size * width));
        if accessor.count > 0 && needed.is_none_or(|needed| needed > data.len()) {
            return Err(cut());
        }
        let mut values = Vec::new();
        room(&mut values, accessor.count * width)?;
        for item in 0..accessor.count {
            for k in 0..width {
                let at = item * stride + k * size;
                values.push(read(&data[at..at + size]));
            }
        }
        Ok(values)
    }

    fn finish(self) -> RawMesh {
        let weld = weld_exact(&self.positions);
        let mesh = weld.apply(&TriMesh {
            positions: self.positions,
            triangles: self.triangles,
        });
        RawMesh {
            source: (0..mesh.triangles.len() as u32).collect(),
            mesh,
            names: self.names.finish(),
            places: FacetPlaces::None,
            warnings: Vec::new(),
            values: Default::default(),
            unit: Some(Unit::Metre),
        }
    }
}

type Component64 = fn(&[u8]) -> f64;

/// Bytes of a number, and how to read it.
fn component(accessor: &Accessor) -> Option<(usize, Component64)> {
    let normalized = accessor.normalized;
    Some(match (accessor.component_type, normalized) {
        (5120, false) => (1, |b| f64::from(b[0] as i8)),
        (5120, true) => (1, |b| (f64::from(b[0] as i8) / 127.0).max(-1.0)),
        (5121, false) => (1, |b| f64::from(b[0])),
        (5121, true) => (1, |b| f64::from(b[0]) / 255.0),
        (5122, false) => (2, |b| f64::from(i16::from_le_bytes([b[0], b[1]]))),
        (5122, true) => (2, |b| {
            (f64::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0)
        }),
        (5123, false) => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]]))),
        (5123, true) => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0),
        (5125, _) => (4, |b| {
            f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        }),
        (5126, _) => (4, |b| {
            f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        }),
        _ => return None,
    })
}

/// Where a node stands in the one above.
fn placement(node: &Node) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    let turn = node.rotation.map_or(DQuat::IDENTITY, |r| {
        let r = DVec4::from(r);
        // A rotation of no length turns nothing.
        r.try_normalize().map_or(DQuat::IDENTITY, DQuat::from_vec4)
    });
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, DVec3::from),
        turn,
        node.translation.map_or(DVec3::ZERO, DVec3::from),
    )
}
