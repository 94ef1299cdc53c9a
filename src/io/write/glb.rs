//! Binary glTF 2.0 for viewers, thickness as colour.
//!
//! A primitive for every sheet, and one of lines for the seams. Positions are
//! f32 about the middle of the box, which the node's translation puts back;
//! glTF means metres, so a viewer that tells lengths is off by the part's unit.
//! Attributes: `POSITION`, `NORMAL`, `COLOR_0`, `_THICKNESS`.

use std::io::{self, Write};

use glam::DVec3;
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

use crate::mesh::Bounds;
use crate::shell::{SetKind, ShellModel};

const FLOAT: u32 = 5126;
const WHOLE: u32 = 5125;
const BYTE: u32 = 5121;
/// Buffer of vertices, buffer of indices.
const TARGETS: [u32; 2] = [34962, 34963];
/// Drawing modes.
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// The one buffer, with its views and accessors.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an array; its accessor's number.
    fn push(&mut self, bytes: Vec<u8>, target: u32, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], kind: &str, components: usize) -> usize {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut accessor = json!({
            "componentType": FLOAT, "count": values.len() / components, "type": kind,
        });
        if kind == "VEC3" {
            let of = |fold: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
                (0..3)
                    .map(|k| values.iter().skip(k).step_by(3).copied().fold(start, fold))
                    .collect()
            };
            accessor["min"] = json!(of(f32::min, f32::INFINITY));
            accessor["max"] = json!(of(f32::max, f32::NEG_INFINITY));
        }
        self.push(bytes, TARGETS[0], accessor)
    }

    fn colours(&mut self, colours: &[[u8; 4]]) -> usize {
        let accessor = json!({
            "componentType": BYTE, "normalized": true, "count": colours.len(), "type": "VEC4",
        });
        self.push(colours.concat(), TARGETS[0], accessor)
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let accessor = json!({
            "componentType": WHOLE, "count": indices.len(), "type": "SCALAR",
        });
        self.push(bytes, TARGETS[1], accessor)
    }
}

pub(super) fn write(model: &ShellModel, out: &mut dyn Write) -> io::Result<()> {
    let middle = Bounds::of(model.nodes.iter().map(|n| n.position)).center();
    let range = model
        .nodes
        .iter()
        .map(|n| n.thickness)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| {
            [low.min(t), high.max(t)]
        });
    let mut buffer = Buffer::default();
    let mut meshes = Vec::new();
    let mut names = Vec::new();
    for (n, own) in (1..).zip(model.by_sheet()) {
        meshes.push(sheet_primitive(model, &own, middle, range, &mut buffer));
        names.push(format!("SHEET_{n}"));
    }
    if let Some(seams) = seam_primitive(model, middle, &mut buffer) {
        meshes.push(seams);
        names.push("SEAMS".to_owned());
    }
    let nodes: Vec<Value> = (names.iter().enumerate())
        .map(|(n, name)| json!({ "mesh": n, "name": name, "translation": middle.to_array() }))
        .collect();
    let meshes: Vec<Value> = (meshes.iter().zip(&names))
        .map(|(primitive, name)| json!({ "name": name, "primitives": [primitive] }))
        .collect();
    let scene = json!({
        "asset": { "version": "2.0", "generator": concat!("midsurf ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{
            "nodes": (0..nodes.len()).collect::<Vec<_>>(),
            "extras": { "thickness_min": range[0], "thickness_max": range[1] },
        }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [
            { "name": "thickness", "doubleSided": true,
              "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.8 } },
            { "name": "seam",
              "pbrMetallicRoughness": { "baseColorFactor": [0.1, 0.1, 0.1, 1.0], "metallicFactor": 0.0 } },
        ],
        "buffers": [{ "byteLength": buffer.bytes.len() }],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    });
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunks: [(&[u8; 4], &[u8]); 2] = [(b"JSON", &text), (b"BIN\0", &buffer.bytes)];
    let length = 12 + chunks.iter().map(|c| 8 + c.1.len()).sum::<usize>();
    out.write_all(b"glTF")?;
    out.write_all(&2u32.to_le_bytes())?;
    out.write_all(&(length as u32).to_le_bytes())?;
    for (kind, bytes) in chunks {
        out.write_all(&(bytes.len() as u32).to_le_bytes())?;
        out.write_all(kind)?;
        out.write_all(bytes)?;
    }
    Ok(())
}

/// Vertices are pairs of a node and a normal, so that a crease stays sharp.
fn sheet_primitive(
    model: &ShellModel,
    elements: &[usize],
    middle: DVec3,
    [thin, thick]: [f64; 2],
    buffer: &mut Buffer,
) -> Value {
    let mut number: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let (mut positions, mut normals, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    let (mut thickness, mut indices) = (Vec::new(), Vec::new());
    for &e in elements {
        let element = &model.elements[e];
        let mut corner = |k: usize| {
            let key = [element.nodes[k], element.normals[k]];
            *number.entry(key).or_insert_with(|| {
                let node = &model.nodes[key[0] as usize];
                positions.extend((node.position - middle).as_vec3().to_array());
                normals.extend(model.normals[key[1] as usize].as_vec3().to_array());
                thickness.push(node.thickness as f32);
                // The middle of the scale where all is equally thick.
                let share = (node.thickness - thin) / (thick - thin);
                colours.push(colour(if share.is_finite() { share } else { 0.5 }));
                thickness.len() as u32 - 1
            })
        };
        for k in 1..element.sides() - 1 {
            indices.extend([corner(0), corner(k), corner(k + 1)]);
        }
    }
    json!({
        "attributes": {
            "POSITION": buffer.floats(&positions, "VEC3", 3),
            "NORMAL": buffer.floats(&normals, "VEC3", 3),
            "COLOR_0": buffer.colours(&colours),
            "_THICKNESS": buffer.floats(&thickness, "SCALAR", 1),
        },
        "indices": buffer.indices(&indices),
        "material": 0,
        "mode": TRIANGLES,
    })
}

fn seam_primitive(model: &ShellModel, middle: DVec3, buffer: &mut Buffer) -> Option<Value> {
    let seams = model.lines.iter().filter(|l| l.kind == SetKind::Seam);
    let positions: Vec<f32> = (seams.flat_map(|l| &l.sides).flat_map(|s| s.0))
        .map(|n| (model.nodes[n as usize].position - middle).as_vec3())
        .flat_map(|p| p.to_array())
        .collect();
    (!positions.is_empty()).then(|| {
        json!({
            "attributes": { "POSITION": buffer.floats(&positions, "VEC3", 3) },
            "material": 1,
            "mode": LINES,
        })
    })
}

/// Colours of thin, middling and thick walls: blue, green, yellow; equally
/// far apart to the eye, and to the colour-blind.
const SCALE: [[f64; 3]; 5] = [
    [0.17, 0.20, 0.55],
    [0.13, 0.44, 0.56],
    [0.13, 0.65, 0.50],
    [0.55, 0.80, 0.30],
    [0.98, 0.90, 0.20],
];

fn colour(share: f64) -> [u8; 4] {
    let place = share.clamp(0.0, 1.0) * (SCALE.len() - 1) as f64;
    let low = (place as usize).min(SCALE.len() - 2);
    let rest = place - low as f64;
    let mix = |k: usize| SCALE[low][k] + rest * (SCALE[low + 1][k] - SCALE[low][k]);
    let [r, g, b] = [0, 1, 2].map(|k| (255.0 * mix(k)).round() as u8);
    [r, g, b, 255]
}
