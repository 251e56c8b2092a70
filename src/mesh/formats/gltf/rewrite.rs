//! A new layer in a glTF document: texture coordinates or parts. Of a triangle primitive the vertices,
//! the indices and that layer are written anew; all else stays as it was.

use std::collections::{BTreeMap, BTreeSet};

use bytes::Bytes;
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Mode;
use serde_json::{Map, Value, json};

use super::accessor::Elements;
use super::binary::{Kind, Streams, drop_compressed, lay_out};
use super::references;
use super::textures::tangent_set;
use super::triangles::Corners;
use super::view::{GltfView, PrimitiveView};
use crate::mesh::export::{ExportError, Layer, split};
use crate::mesh::import::ImportError;
use crate::mesh::scene::{Component, Primitive};

/// The document with `layer` in its `primitives`, and its binary chunk.
pub(in crate::mesh) fn rewrite(
    json: &Value,
    buffers: &[Bytes],
    primitives: &[Primitive],
    layer: Layer,
) -> Result<(Value, Vec<u8>), ExportError> {
    let view = GltfView::new(json, buffers)?;
    let mut writer = Writer {
        streams: Streams::new(view.views.len()),
        json: json.clone(),
        accessors: Vec::new(),
        named: BTreeSet::new(),
        view,
    };
    let mut rest = layer;
    for primitive in primitives {
        let (own, others) = rest.split_at(primitive.triangles.len());
        writer.primitive(primitive.mesh as usize, primitive.number as usize, own)?;
        rest = others;
    }
    let Writer { view, mut json, streams, accessors, .. } = writer;
    append(&mut json, "accessors", accessors);
    append(&mut json, "bufferViews", streams.views());
    let kept = references::prune(&mut json);
    let bin = lay_out(&mut json, &kept, Some(&view), &streams)?;
    Ok((json, bin))
}

fn append(json: &mut Value, list: &str, items: impl IntoIterator<Item = Value>) {
    match json.get_mut(list) {
        Some(Value::Array(held)) => held.extend(items),
        _ => json[list] = items.into_iter().collect(),
    }
}

struct Writer<'a> {
    view: GltfView<'a>,
    json: Value,
    /// New accessors, to stand behind the old ones.
    accessors: Vec<Value>,
    /// Old accessors that have a copy with their name.
    named: BTreeSet<usize>,
    streams: Streams,
}

impl Writer<'_> {
    fn add(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.view.accessors.len() + self.accessors.len() - 1
    }

    fn primitive(&mut self, mesh: usize, number: usize, layer: Layer) -> Result<(), ExportError> {
        let place = format!("mesh {mesh}, primitive {number}");
        let changed = || ImportError::invalid(format!("{place} is not as it was read"));
        let primitive = self.view.primitive(mesh, number, &place)?;
        let mode = primitive.mode.ok_or_else(changed)?;
        let positions = primitive.attribute("POSITION").ok_or_else(changed)?;
        let positions = self.view.elements(positions, &place)?;
        let corners = Corners::new(&self.view, &primitive, mode, positions.count, &place)?;
        let triangles = corners.triangles(&place)?;
        if triangles.len() != layer.faces() {
            return Err(changed().into());
        }
        let keys = triangles.as_flattened().iter().copied().zip(layer.corners());
        let (vertices, indices) = split(keys);

        let values = layer.append(&mut self.streams, vertices.iter().map(|&(_, value)| value));
        let values = self.add(Value::Object(values));
        let indices = self.streams.append_indices(&indices, vertices.len());
        let indices = self.add(indices);

        let set = layer.attribute();
        let replaced = self.replaced(&primitive, &set, layer.channel());
        let sources: Vec<u32> = vertices.iter().map(|&(source, _)| source).collect();
        let mut copies = BTreeMap::new();
        let mut attributes = Map::new();
        for &(name, accessor) in &primitive.attributes {
            if name == set {
                attributes.insert(set.clone(), values.into());
            } else if !replaced.contains(&name) {
                let copy = self.copy(accessor, name, &sources, &mut copies)?;
                attributes.insert(name.to_owned(), copy.into());
            }
        }
        for lower in layer.with_lower_sets() {
            attributes.entry(lower).or_insert_with(|| values.into());
        }
        let mut targets = Vec::with_capacity(primitive.targets.len());
        for target in &primitive.targets {
            let mut copied = Map::new();
            for &(name, accessor) in target.iter().filter(|(name, _)| !replaced.contains(name)) {
                let copy = self.copy(accessor, name, &sources, &mut copies)?;
                copied.insert(name.to_owned(), copy.into());
            }
            targets.push(Value::Object(copied));
        }

        let path = format!("/meshes/{mesh}/primitives/{number}");
        let object = self.json.pointer_mut(&path).and_then(Value::as_object_mut);
        let object = object.ok_or_else(changed)?;
        object.insert("attributes".into(), attributes.into());
        object.insert("indices".into(), indices.into());
        if mode != Mode::Triangles {
            object.insert("mode".into(), 4.into());
        }
        if !targets.is_empty() {
            object.insert("targets".into(), targets.into());
        }
        drop_compressed(object);
        Ok(())
    }

    /// What goes with the replaced set: its own old coordinates, and the tangents that follow it.
    fn replaced<'n>(
        &self,
        primitive: &PrimitiveView,
        set: &'n str,
        channel: Option<u8>,
    ) -> Vec<&'n str> {
        let material = primitive.material;
        let material = material.and_then(|m| self.view.json.get("materials")?.get(m));
        let follows = channel.is_some_and(|c| tangent_set(material) == u64::from(c));
        match primitive.attribute(set) {
            Some(_) if follows => vec![set, "TANGENT"],
            _ => vec![set],
        }
    }

    /// A new accessor with the elements of an old one at `sources`, in the type that they have.
    fn copy(
        &mut self,
        accessor: usize,
        name: &str,
        sources: &[u32],
        copies: &mut BTreeMap<(usize, bool), usize>,
    ) -> Result<usize, ExportError> {
        let bounded = name == "POSITION";
        if let Some(&copy) = copies.get(&(accessor, bounded)) {
            return Ok(copy);
        }
        let elements = self.view.elements(accessor, name)?;
        let mut object = Map::new();
        let old = self.view.json.get("accessors").and_then(|list| list.get(accessor));
        // Only the first of several copies bears the name and the extras, which may be long.
        let kept = match self.named.insert(accessor) {
            true => &["name", "componentType", "normalized", "type", "extras"][..],
            false => &["componentType", "normalized", "type"],
        };
        for &key in kept {
            if let Some(value) = old.and_then(|old| old.get(key)) {
                object.insert(key.into(), value.clone());
            }
        }
        object.insert("count".into(), sources.len().into());
        if elements.is_sparse() {
            if let Some(sparse) = self.sparse(&elements, sources) {
                object.insert("sparse".into(), sparse);
            }
        } else {
            let stride = elements.size.next_multiple_of(4);
            let all = sources.iter().map(|&v| elements.get(v as usize));
            let place = self.streams.append(Kind::Vertices(stride), all);
            object.insert("bufferView".into(), place.view.into());
            object.insert("byteOffset".into(), place.offset.into());
        }
        if let Some((min, max)) = bounds(&elements, sources).filter(|_| bounded) {
            object.insert("min".into(), min);
            object.insert("max".into(), max);
        }
        let copy = self.add(Value::Object(object));
        copies.insert((accessor, bounded), copy);
        Ok(copy)
    }

    /// The replacements of a sparse accessor that is zero elsewhere.
    fn sparse(&mut self, elements: &Elements, sources: &[u32]) -> Option<Value> {
        let replaced = |(new, &old): (u32, &u32)| Some((new, elements.replacement(old as usize)?));
        let replaced: Vec<_> = (0u32..).zip(sources).filter_map(replaced).collect();
        if replaced.is_empty() {
            return None;
        }
        let indices = replaced.iter().map(|(new, _)| new.to_le_bytes());
        let indices = self.streams.append(Kind::Sparse, indices);
        let values = self.streams.append(Kind::Sparse, replaced.iter().map(|(_, bytes)| bytes));
        Some(json!({
            "count": replaced.len(),
            "indices": {
                "bufferView": indices.view,
                "byteOffset": indices.offset,
                "componentType": ComponentType::U32.as_gl_enum(),
            },
            "values": {"bufferView": values.view, "byteOffset": values.offset},
        }))
    }
}

/// The least and the greatest value of each component as they are stored; nothing if one of them
/// is not finite.
fn bounds(elements: &Elements, sources: &[u32]) -> Option<(Value, Value)> {
    let bound = |start: f64, pick: fn(f64, f64) -> f64| {
        let component = |k| {
            let values = sources.iter().map(|&v| elements.stored(v as usize, k));
            let bound = values.fold(start, pick);
            match elements.component {
                _ if !bound.is_finite() => None,
                Component::F32 => Some(Value::from(bound)),
                _ => Some(Value::from(bound as i64)),
            }
        };
        (0..elements.shape.multiplicity()).map(component).collect::<Option<Vec<_>>>()
    };
    let min = bound(f64::INFINITY, f64::min)?;
    let max = bound(f64::NEG_INFINITY, f64::max)?;
    Some((min.into(), max.into()))
}
