//! A scene of any format as a fresh glTF document: its nodes, its meshes with the primitives that are shown,
//! materials by name.

use std::collections::BTreeMap;

use glam::DMat4;
use serde_json::{Map, Value, json};

use super::binary::{Streams, lay_out};
use crate::mesh::export::{ExportError, Layer, split, stored};
use crate::mesh::scene::{Attribute, Primitive, Scene, TexcoordOrigin, Values};

/// The document with `layer`, and its binary chunk. Whatever attribute all corners of a primitive have is
/// kept, unless it is the layer.
pub(in crate::mesh) fn fresh(scene: &Scene, layer: Layer) -> Result<(Value, Vec<u8>), ExportError> {
    let mut writer = Writer {
        streams: Streams::new(0),
        accessors: Vec::new(),
        v_up: scene.texcoord_origin == TexcoordOrigin::BottomLeft,
    };
    let mut meshes: BTreeMap<u32, Vec<Value>> = BTreeMap::new();
    let mut rest = layer;
    for primitive in &scene.primitives {
        let (own, others) = rest.split_at(primitive.triangles.len());
        meshes.entry(primitive.mesh).or_default().push(writer.primitive(primitive, own));
        rest = others;
    }
    let mut json = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("uvsegnet ", env!("CARGO_PKG_VERSION")),
        },
        "scene": 0,
        "scenes": [{"nodes": roots(scene)}],
        "nodes": nodes(scene, &Vec::from_iter(meshes.keys().copied())),
    });
    let mesh = |(mesh, primitives): (u32, Vec<Value>)| {
        let name = scene.meshes.get(mesh as usize).map_or("", |mesh| &mesh.name);
        let mut object = named(name);
        object.insert("primitives".into(), primitives.into());
        Value::Object(object)
    };
    json["meshes"] = meshes.into_iter().map(mesh).collect();
    if !scene.materials.is_empty() {
        let matte = json!({"metallicFactor": 0.0});
        let material = |name: &str| {
            let mut object = named(name);
            object.insert("pbrMetallicRoughness".into(), matte.clone());
            Value::Object(object)
        };
        json["materials"] = scene.materials.iter().map(|m| material(&m.name)).collect();
    }
    json["accessors"] = writer.accessors.into();
    json["bufferViews"] = writer.streams.views().collect();
    let kept: Vec<usize> = (0..json["bufferViews"].as_array().map_or(0, Vec::len)).collect();
    let bin = lay_out(&mut json, &kept, None, &writer.streams)?;
    Ok((json, bin))
}

/// An object with a name, if it has one.
fn named(name: &str) -> Map<String, Value> {
    let mut object = Map::new();
    if !name.is_empty() {
        object.insert("name".into(), name.into());
    }
    object
}

fn roots(scene: &Scene) -> Vec<usize> {
    let nodes = scene.nodes.iter().enumerate();
    nodes.filter(|(_, node)| node.parent.is_none()).map(|(i, _)| i).collect()
}

/// The nodes; `meshes` are those that have primitives, ascending.
fn nodes(scene: &Scene, meshes: &[u32]) -> Value {
    let mut children: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (i, node) in scene.nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            children.entry(parent).or_default().push(i);
        }
    }
    let node = |(i, node): (u32, &crate::mesh::scene::Node)| {
        let mut object = named(&node.name);
        if let Some(mesh) = node.mesh.and_then(|mesh| meshes.binary_search(&mesh).ok()) {
            object.insert("mesh".into(), mesh.into());
        }
        if let Some(transform) = &node.transform {
            object.insert("matrix".into(), DMat4::to_cols_array(transform).to_vec().into());
        }
        if let Some(children) = children.remove(&i) {
            object.insert("children".into(), children.into());
        }
        Value::Object(object)
    };
    (0..).zip(&scene.nodes).map(node).collect()
}

struct Writer {
    streams: Streams,
    accessors: Vec<Value>,
    /// Whether the scene's texture coordinates have v upwards.
    v_up: bool,
}

impl Writer {
    fn add(&mut self, accessor: impl Into<Value>) -> Value {
        self.accessors.push(accessor.into());
        Value::from(self.accessors.len() - 1)
    }

    fn primitive(&mut self, primitive: &Primitive, layer: Layer) -> Value {
        let is_kept = |attribute: &&Attribute| {
            is_known(attribute) && attribute.name != layer.attribute() && attribute.is_whole()
        };
        let kept: Vec<&Attribute> = primitive.attributes.iter().filter(is_kept).collect();
        // Corners are one vertex where they have all in common: position, then the indices of attributes,
        // the last first. Two are sorted at once with the layer, as most files have no more; others one
        // after the other before.
        let of_corners = kept.iter().rev().filter_map(|attribute| attribute.corners.as_deref());
        let mut own: Vec<&[u32]> = of_corners.map(<[[u32; 3]]>::as_flattened).collect();
        let mut corners = primitive.triangles.as_flattened().to_vec();
        for own in own.drain(..own.len().saturating_sub(2)) {
            corners = split(corners.into_iter().zip(own.iter().copied())).1;
        }
        let index = |n: usize, corner: usize| own.get(n).map_or(0, |own| own[corner]);
        let key = |(corner, &vertex): (usize, &u32)| [vertex, index(0, corner), index(1, corner)];
        let (vertices, indices) = split(corners.iter().enumerate().map(key).zip(layer.corners()));
        let mut corner_of = vec![0; vertices.len()];
        for (corner, &vertex) in indices.iter().enumerate().rev() {
            corner_of[vertex as usize] = corner;
        }

        let mut attributes = Map::new();
        let position = |&corner: &usize| {
            let vertex = primitive.triangles[corner / 3][corner % 3];
            primitive.positions.vector(vertex as usize).map(|x| x as f32)
        };
        let mut positions = self.streams.append_floats::<3>(corner_of.iter().map(position));
        for (bound, pick) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
            let points = corner_of.iter().map(position);
            let value =
                points.reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default();
            positions.insert(bound.into(), value.map(f64::from).to_vec().into());
        }
        attributes.insert("POSITION".into(), self.add(positions));
        for attribute in kept {
            let index = |&corner: &usize| {
                let (face, k) = (corner / 3, corner % 3);
                attribute.index(face, k, primitive.triangles[face][k]).unwrap_or_default()
            };
            let indices = corner_of.iter().map(index);
            let accessor = match attribute.values.width() {
                1 => self.vectors::<1>(&attribute.values, indices),
                2 if attribute.name.starts_with("TEXCOORD_") && self.v_up => {
                    let uv = |i| stored(attribute.values.vector(i).map(|x| x as f32));
                    self.streams.append_floats(indices.map(uv))
                }
                2 => self.vectors::<2>(&attribute.values, indices),
                3 => self.vectors::<3>(&attribute.values, indices),
                _ => self.vectors::<4>(&attribute.values, indices),
            };
            let accessor = self.add(accessor);
            attributes.insert(attribute.name.clone(), accessor);
        }
        let values = layer.append(&mut self.streams, vertices.iter().map(|&(_, value)| value));
        let values = self.add(values);
        for set in layer.with_lower_sets() {
            attributes.entry(set).or_insert_with(|| values.clone());
        }
        let indices = self.streams.append_indices(&indices, vertices.len());
        let indices = self.add(indices);
        let mut object = Map::new();
        object.insert("attributes".into(), attributes.into());
        object.insert("indices".into(), indices);
        if let Some(material) = primitive.material {
            object.insert("material".into(), material.into());
        }
        Value::Object(object)
    }

    fn vectors<const N: usize>(
        &mut self,
        values: &Values,
        indices: impl ExactSizeIterator<Item = usize>,
    ) -> Map<String, Value> {
        self.streams.append_floats::<N>(indices.map(|i| values.vector(i).map(|x| x as f32)))
    }
}

/// Whether an attribute means the same in a fresh document: skins stay behind, and what is derived from
/// other attributes.
fn is_known(attribute: &Attribute) -> bool {
    let families = ["NORMAL", "COLOR_", "TEXCOORD_", "_"];
    families.iter().any(|family| attribute.name.starts_with(family))
        && (1..=4).contains(&attribute.values.width())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::contract::{Limits, MeshKind};
    use crate::mesh::{ABSENT, Mesh, TEXCOORD, export, import};

    #[test]
    fn a_scene_without_a_document_reads_back_as_it_was() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        let square = || Primitive::from_triangles(corners.clone(), vec![[0, 1, 2], [1, 3, 2]]);
        let mut scene = Scene { texcoord_origin: TexcoordOrigin::TopLeft, ..Scene::default() };
        scene.meshes.push(Mesh { name: "shown by nothing".into() });
        scene.add("box", square());
        scene.add("lid", square());
        scene.nodes[1].parent = Some(0);
        for node in &mut scene.nodes {
            node.transform = Some(Box::new(DMat4::from_translation(DVec3::Z)));
        }
        for node in [0, 1] {
            scene.primitives[node].world = scene.world(node as u32);
        }
        let attribute = |name: &str, values, corners| {
            let name = name.to_owned();
            Attribute { name, values, corners }
        };
        let uvs = Values::floats(vec![[0.0, 0.25], [0.5, 0.75]]);
        let turns = Values::doubles(vec![[1.0], [2.0], [3.0], [4.0]]);
        let flat = || Some(vec![[0, 0, 0], [0, 0, 0]]);
        scene.primitives[0].attributes = vec![
            attribute("_TURN", turns, None),
            attribute(TEXCOORD, uvs.clone(), Some(vec![[0, 1, 1], [0, 1, 0]])),
            attribute("TEXCOORD_1", uvs.clone(), flat()),
            attribute("TEXCOORD_2", uvs.clone(), Some(vec![[1, 0, 1], [0, 0, 1]])),
            attribute("JOINTS_0", uvs.clone(), None),
        ];
        scene.primitives[1].attributes =
            vec![attribute(TEXCOORD, uvs, Some(vec![[0, 1, ABSENT], [0, 1, 0]]))];

        let file = export::part_glb(&scene, &[5, 5, 5, 6], None).unwrap();
        let again = import(&file, MeshKind::Glb, &Limits::default()).unwrap();
        assert_eq!(again.meshes.len(), 2, "a mesh must have primitives");
        assert_eq!(again.labels, Some(vec![5, 5, 5, 6]));
        for (before, after) in scene.primitives.iter().zip(&again.primitives) {
            assert_eq!(scene.name(before), again.name(after));
            let points = |p: &Primitive| -> Vec<_> {
                p.triangles.iter().map(|t| t.map(|v| p.position(v))).collect()
            };
            assert_eq!(points(before), points(after));
        }
        let [first, second] = &again.primitives[..] else { panic!("two primitives") };
        let texcoords = |p: &Primitive| p.texcoords().map(Vec::from_iter);
        assert_eq!(texcoords(first), texcoords(&scene.primitives[0]), "v points down in both");
        assert_eq!(texcoords(second), None, "a corner had none");
        let third = &first.attribute("TEXCOORD_2").unwrap().values;
        let at = first.triangles[0].map(|v| third.vector::<2>(v as usize));
        assert_eq!(at, [[0.5, 0.75], [0.0, 0.25], [0.5, 0.75]]);
        assert!(first.attribute("JOINTS_0").is_none(), "there is no skin to it");
        // Two vertices are split in each: by coordinates in the first, by parts in the second.
        assert_eq!((first.positions.count(), second.positions.count()), (6, 6));
        let turn = &first.attribute("_TURN").unwrap().values;
        let at = first.triangles[1].map(|v| turn.value(v as usize, 0));
        assert_eq!(at, [2.0, 4.0, 3.0]);
    }
}
