//! An OBJ file as a fresh glTF document: a node and a mesh for each object or group, a primitive
//! for each of its materials, materials by name.

use serde_json::{Map, Value, json};

use super::{ABSENT, ObjCorner, ObjDocument, ObjRun};
use crate::mesh::export::{Bits, ExportError, Layer, split, stored};
use crate::mesh::formats::gltf::binary::{Streams, lay_out};

/// The document with `layer`, and its binary chunk. The file's own texture coordinates are kept as
/// TEXCOORD_0 unless that is the layer.
pub(in crate::mesh) fn document(
    document: &ObjDocument,
    layer: Layer,
) -> Result<(Value, Vec<u8>), ExportError> {
    let mut streams = Streams::new(0);
    let mut accessors = Vec::new();
    let mut meshes: Vec<Vec<Value>> = vec![Vec::new(); document.groups.len()];
    let mut rest = layer;
    for run in &document.runs {
        let (own, others) = rest.split_at(run.faces.len());
        let primitive = primitive(document, run, own, &mut streams, &mut accessors);
        meshes[run.group as usize].push(primitive);
        rest = others;
    }
    let named = |name: &str, rest: (&str, Value)| {
        let mut object = Map::new();
        if !name.is_empty() {
            object.insert("name".into(), name.into());
        }
        object.insert(rest.0.into(), rest.1);
        Value::Object(object)
    };
    let groups = || document.groups.iter().enumerate();
    let nodes: Vec<Value> = groups().map(|(i, name)| named(name, ("mesh", i.into()))).collect();
    let meshes: Vec<Value> = document
        .groups
        .iter()
        .zip(meshes)
        .map(|(name, primitives)| named(name, ("primitives", primitives.into())))
        .collect();
    let matte = json!({"metallicFactor": 0.0});
    let materials = document.materials.iter();
    let materials: Vec<Value> =
        materials.map(|name| named(name, ("pbrMetallicRoughness", matte.clone()))).collect();
    let mut json = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("uvsegnet ", env!("CARGO_PKG_VERSION")),
        },
        "scene": 0,
        "scenes": [{"nodes": groups().map(|(i, _)| i).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": meshes,
    });
    if !materials.is_empty() {
        json["materials"] = materials.into();
    }
    json["accessors"] = accessors.into();
    json["bufferViews"] = streams.views().collect();
    let kept: Vec<usize> = (0..json["bufferViews"].as_array().map_or(0, Vec::len)).collect();
    let bin = lay_out(&mut json, &kept, None, &streams)?;
    Ok((json, bin))
}

fn primitive(
    document: &ObjDocument,
    run: &ObjRun,
    layer: Layer,
    streams: &mut Streams,
    accessors: &mut Vec<Value>,
) -> Value {
    let corners = || run.faces.as_flattened().iter();
    let normals = corners().all(|corner| {
        corner.normal != ABSENT && document.normals[corner.normal as usize] != [0.0; 3]
    });
    let texcoords = layer.channel() != Some(0) && corners().all(|corner| corner.texcoord != ABSENT);
    let keys = corners().zip(layer.corners()).map(|(&corner, value)| {
        let key = ObjCorner {
            normal: if normals { corner.normal } else { ABSENT },
            texcoord: if texcoords { corner.texcoord } else { ABSENT },
            ..corner
        };
        (key, value)
    });
    let (vertices, indices) = split(keys);

    let mut add = |accessor: Value| {
        accessors.push(accessor);
        Value::from(accessors.len() - 1)
    };
    let mut attributes = Map::new();
    let position =
        |key: &(ObjCorner, Bits)| document.positions[key.0.position as usize].map(|c| c as f32);
    let mut positions = streams.append_floats(vertices.iter().map(position));
    for (bound, pick) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
        let points = vertices.iter().map(position);
        let value = points.reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default();
        positions.insert(bound.into(), value.map(f64::from).to_vec().into());
    }
    attributes.insert("POSITION".into(), add(positions.into()));
    if normals {
        let normal = vertices.iter().map(|(corner, _)| document.normals[corner.normal as usize]);
        attributes.insert("NORMAL".into(), add(streams.append_floats(normal).into()));
    }
    if let Some(colors) = &document.colors {
        let color = vertices.iter().map(|(corner, _)| colors[corner.position as usize]);
        attributes.insert("COLOR_0".into(), add(streams.append_floats(color).into()));
    }
    if texcoords {
        let uv =
            |(corner, _): &(ObjCorner, Bits)| stored(document.texcoords[corner.texcoord as usize]);
        let kept = streams.append_floats(vertices.iter().map(uv));
        attributes.insert("TEXCOORD_0".into(), add(kept.into()));
    }
    let values = layer.append(streams, vertices.iter().map(|&(_, value)| value));
    let values = add(values.into());
    for set in layer.with_lower_sets() {
        attributes.entry(set).or_insert_with(|| values.clone());
    }
    let indices = add(streams.append_indices(&indices, vertices.len()));
    let mut primitive = Map::new();
    primitive.insert("attributes".into(), attributes.into());
    primitive.insert("indices".into(), indices);
    if let Some(material) = run.material {
        primitive.insert("material".into(), material.into());
    }
    Value::Object(primitive)
}
