//! Objects as binary glTF 2.0 (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html).

use std::borrow::Cow;

use glam::DVec3;
use gltf::binary::{Glb, Header};
use serde_json::{Value, json};

use super::shading::{Shaded, shade};
use super::{SynthObject, SynthVariant};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Muted colours for the kinds of parts, in order of their first appearance (linear RGB).
const COLOURS: [[f64; 3]; 8] = [
    [0.43, 0.25, 0.12],
    [0.60, 0.42, 0.24],
    [0.18, 0.26, 0.33],
    [0.52, 0.52, 0.50],
    [0.55, 0.16, 0.12],
    [0.20, 0.33, 0.20],
    [0.09, 0.09, 0.10],
    [0.63, 0.53, 0.20],
];

/// The buffer and what stands in it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Append an accessor with a view of its own and return its index.
    fn push(&mut self, bytes: &[u8], target: u32, accessor: Value) -> usize {
        let view = self.views.len();
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut accessor = accessor;
        accessor["bufferView"] = json!(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[[f32; 3]], bounds: bool) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let mut accessor = json!({
            "componentType": FLOAT, "count": vectors.len(), "type": "VEC3",
        });
        if bounds {
            let fold = |f: fn(f32, f32) -> f32| {
                let first = vectors.first().copied().unwrap_or_default();
                vectors.iter().fold(first, |m, v| [f(m[0], v[0]), f(m[1], v[1]), f(m[2], v[2])])
            };
            accessor["min"] = json!(fold(f32::min));
            accessor["max"] = json!(fold(f32::max));
        }
        self.push(&bytes, ARRAY_BUFFER, accessor)
    }

    fn scalars(&mut self, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        let accessor = json!({"componentType": FLOAT, "count": values.len(), "type": "SCALAR"});
        self.push(&bytes, ARRAY_BUFFER, accessor)
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let all = triangles.iter().flatten();
        // 65535 itself means "restart the primitive" and may not be an index.
        let (kind, bytes): (u32, Vec<u8>) = if vertices <= 65535 {
            (UNSIGNED_SHORT, all.flat_map(|&i| (i as u16).to_le_bytes()).collect())
        } else {
            (UNSIGNED_INT, all.flat_map(|&i| i.to_le_bytes()).collect())
        };
        let accessor =
            json!({"componentType": kind, "count": 3 * triangles.len(), "type": "SCALAR"});
        self.push(&bytes, ELEMENT_ARRAY_BUFFER, accessor)
    }

    /// A primitive whose positions are relative to `origin`.
    fn primitive(&mut self, shaded: &Shaded, origin: DVec3, parts: Option<&[f32]>) -> Value {
        let single = |v: &DVec3| v.as_vec3().to_array();
        let positions: Vec<_> = shaded.positions.iter().map(|&p| single(&(p - origin))).collect();
        // Unit length again after rounding to single precision.
        let normals: Vec<_> =
            shaded.normals.iter().map(|n| n.as_vec3().normalize().to_array()).collect();
        let mut attributes = json!({
            "POSITION": self.vectors(&positions, true),
            "NORMAL": self.vectors(&normals, false),
        });
        if let Some(parts) = parts {
            attributes["_PART"] = json!(self.scalars(parts));
        }
        let indices = self.indices(&shaded.triangles, positions.len());
        json!({"attributes": attributes, "indices": indices, "mode": 4, "material": 0})
    }
}

/// The object as the bytes of a GLB file.
pub(super) fn write(object: &SynthObject) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (mut nodes, mut meshes, mut materials) = (vec![], vec![], vec![]);
    let name = object.kind.as_str();
    match (&object.fused, object.variant) {
        (Some(body), _) => {
            let shaded = shade(&body.positions, &body.triangles);
            let primitive = buffer.primitive(&shaded, DVec3::ZERO, None);
            meshes.push(json!({"name": name, "primitives": [primitive]}));
            materials.push(material(name, 0));
        }
        (None, SynthVariant::MultiNode) => {
            let mut kinds: Vec<&str> = vec![];
            let children: Vec<usize> = (1..=object.parts.len()).collect();
            nodes.push(json!({"name": name, "children": children}));
            for (i, part) in object.parts.iter().enumerate() {
                let coarse = part.coarse_name();
                let kind = kinds.iter().position(|&k| k == coarse).unwrap_or_else(|| {
                    materials.push(material(coarse, kinds.len()));
                    kinds.push(coarse);
                    kinds.len() - 1
                });
                // A pivot that single precision holds exactly, so that the file gives back the
                // positions that were put in.
                let middle = part.positions.iter().sum::<DVec3>() / part.positions.len() as f64;
                let pivot = (middle * 64.0).round() / 64.0;
                let shaded = shade(&part.positions, &part.triangles);
                let mut primitive = buffer.primitive(&shaded, pivot, None);
                primitive["material"] = json!(kind);
                meshes.push(json!({"name": part.name, "primitives": [primitive]}));
                nodes.push(json!({
                    "name": part.name, "mesh": i, "translation": pivot.to_array(),
                }));
            }
        }
        (None, _) => {
            let mut all = Shaded { positions: vec![], normals: vec![], triangles: vec![] };
            let mut labels = vec![];
            for (i, part) in object.parts.iter().enumerate() {
                let shaded = shade(&part.positions, &part.triangles);
                let base = all.positions.len() as u32;
                labels.resize(labels.len() + shaded.positions.len(), i as f32);
                all.positions.extend(shaded.positions);
                all.normals.extend(shaded.normals);
                all.triangles.extend(shaded.triangles.iter().map(|t| t.map(|v| v + base)));
            }
            let primitive = buffer.primitive(&all, DVec3::ZERO, Some(&labels));
            meshes.push(json!({"name": name, "primitives": [primitive]}));
            materials.push(material(name, 0));
        }
    }
    if nodes.is_empty() {
        nodes.push(json!({"name": name, "mesh": 0}));
    }
    file(buffer, nodes, meshes, materials)
}

/// One mesh of one primitive. Vertices stay as they are: none is split at a crease.
pub(super) fn write_body(
    name: &str,
    positions: &[DVec3],
    normals: Vec<DVec3>,
    triangles: &[[u32; 3]],
) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (positions, triangles) = (positions.to_vec(), triangles.to_vec());
    let shaded = Shaded { positions, normals, triangles };
    let primitive = buffer.primitive(&shaded, DVec3::ZERO, None);
    let meshes = vec![json!({"name": name, "primitives": [primitive]})];
    file(buffer, vec![json!({"name": name, "mesh": 0})], meshes, vec![material(name, 0)])
}

/// The file of a scene whose root is the first node.
fn file(buffer: Buffer, nodes: Vec<Value>, meshes: Vec<Value>, materials: Vec<Value>) -> Vec<u8> {
    let document = json!({
        "asset": {"version": "2.0", "generator": "uvsegnet synth"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": buffer.bytes.len()}],
    });
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = (12 + 8 + json.len() + 8 + buffer.bytes.len()) as u32;
    let header = Header { magic: *b"glTF", version: 2, length };
    let glb = Glb { header, json: Cow::Owned(json), bin: Some(Cow::Owned(buffer.bytes)) };
    // Writing to memory cannot fail.
    glb.to_vec().unwrap_or_default()
}

fn material(name: &str, number: usize) -> Value {
    let [r, g, b] = COLOURS[number % COLOURS.len()];
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.7,
        },
    })
}
