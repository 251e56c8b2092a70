//! A glTF document as a scene: the triangle primitives of the default scene in face order, each
//! mesh at its first use and in the place of its largest instance.

use std::collections::{BTreeMap, BTreeSet};

use bytes::Bytes;
use glam::{DMat4, DVec3};
use gltf::json::accessor::Type;
use serde_json::Value;

use super::accessor::Elements;
use super::extensions;
use super::hierarchy::{self, Hierarchy, MeshUse};
use super::textures;
use super::triangles::Corners;
use super::view::{GltfView, PrimitiveView};
use crate::contract::{Limits, Warning, WarningCode};
use crate::mesh::import::ImportError;
use crate::mesh::scene::{
    Attribute, Component, Document, Material, Mesh, Node, Primitive, Renumbering, Scene,
    TexcoordOrigin, Values,
};

/// Vertices that one accessor may declare, per triangle that a file may have. A soup has three.
const MOST_VERTICES_PER_TRIANGLE: u64 = 4;
/// Bytes of vertex attributes that a result may need, per byte that an upload may have: a few
/// bytes of JSON can ask for any amount of them.
const MOST_GROWTH: u64 = 4;
/// What reading one replacement of a sparse accessor costs, in bytes.
const REPLACEMENT: u64 = 64;
/// Label of a face of which nothing is known.
const UNKNOWN: i32 = -1;
/// Warnings of one kind.
const MOST_WARNINGS: usize = 8;
/// Characters of a name that are kept for telling parts apart.
const NAME_LENGTH: usize = 120;

/// Read the default scene of a document.
pub(super) fn read(
    json: Value,
    buffers: Vec<Bytes>,
    limits: &Limits,
) -> Result<Scene, ImportError> {
    let mut scene = shown(&json, &buffers, limits)?;
    scene.source = Some(Document::Gltf { json, buffers });
    Ok(scene)
}

fn shown(json: &Value, buffers: &[Bytes], limits: &Limits) -> Result<Scene, ImportError> {
    let mut reader = Reader {
        view: GltfView::new(json, buffers)?,
        limits,
        quantized: extensions::used(json, "KHR_mesh_quantization"),
        faces: 0,
        bytes: 0,
        renumbering: Renumbering::default(),
        labels: Vec::new(),
        labels_hold: true,
        values: BTreeMap::new(),
        material_sets: BTreeMap::new(),
        texture_sets: BTreeSet::new(),
        scene: Scene { texcoord_origin: TexcoordOrigin::TopLeft, ..Scene::default() },
    };
    let Hierarchy { parents, uses, instances } = hierarchy::read(&reader.view, limits.node_depth)?;
    reader.scene.instances = instances;
    for used in uses {
        for number in 0..reader.view.meshes[used.mesh].primitives.len() {
            reader.primitive(&used, number)?;
        }
    }
    Ok(reader.finish(&parents))
}

struct Reader<'a> {
    view: GltfView<'a>,
    limits: &'a Limits,
    /// Whether positions may be integers.
    quantized: bool,
    /// Triangles so far.
    faces: u64,
    /// Bytes of vertex attributes so far.
    bytes: u64,
    renumbering: Renumbering,
    /// Labels so far, from `_PART`.
    labels: Vec<i32>,
    /// Whether `_PART` was flat on every face so far.
    labels_hold: bool,
    /// The values of accessors so far: many primitives may share one.
    values: BTreeMap<usize, Option<Values>>,
    /// Texture coordinate sets that the textures of each material so far read.
    material_sets: BTreeMap<usize, BTreeSet<u64>>,
    /// Those of them that a primitive so far has.
    texture_sets: BTreeSet<u64>,
    scene: Scene,
}

impl<'a> Reader<'a> {
    fn warn(&mut self, code: WarningCode, message: String) {
        let held = self.scene.warnings.iter().filter(|held| held.code == code).count();
        if held < MOST_WARNINGS {
            self.scene.warnings.push(Warning::new(code, message));
        }
    }

    /// The name of an element, cut to a bearable length.
    fn name(&self, list: &str, index: usize) -> Option<String> {
        self.view.name(list, index).map(|name| name.chars().take(NAME_LENGTH).collect())
    }

    fn primitive(&mut self, used: &MeshUse, number: usize) -> Result<(), ImportError> {
        let name = self.name("nodes", used.node);
        let name = name.or_else(|| self.name("meshes", used.mesh)).unwrap_or_default();
        let place = match name.as_str() {
            "" => format!("node {}, mesh {}, primitive {number}", used.node, used.mesh),
            _ => format!("node {} {name:?}, mesh {}, primitive {number}", used.node, used.mesh),
        };
        let primitive = self.view.primitive(used.mesh, number, &place)?;
        let Some(mode) = primitive.mode else { return Ok(()) };
        let Some(accessor) = primitive.attribute("POSITION") else {
            self.warn(
                WarningCode::SkippedPrimitive,
                format!("{place} has no POSITION: left as it is"),
            );
            return Ok(());
        };
        let positions = self.positions(accessor, &primitive, &place)?;
        let corners = Corners::new(&self.view, &primitive, mode, positions.count, &place)?;
        if corners.left_over() > 0 {
            let left = corners.left_over();
            let message = format!("{place}: its last {left} corners make no triangle: left out");
            self.warn(WarningCode::LeftOverCorners, message);
        }
        if corners.triangle_count() == 0 {
            return Ok(());
        }
        self.count(&primitive, &positions, corners.triangle_count() as u64, &place)?;
        let triangles = corners.triangles(&place)?;
        self.read_labels(&primitive, &triangles, &place)?;
        let material = self.material(&primitive, &place)?;
        let shown = Primitive {
            node: used.node as u32,
            mesh: used.mesh as u32,
            number: number as u32,
            material: material.map(|m| m as u32),
            world: Some(used.world),
            positions: self.values(accessor, &place)?.unwrap_or_default(),
            attributes: self.attributes(&primitive, &place)?,
            triangles,
            polygons: None,
        };
        for vertex in self.renumbering.used(&shown.triangles, positions.count) {
            check_position(&shown, vertex).map_err(|what| {
                ImportError::invalid(format!(
                    "{place}, POSITION (accessor {accessor}), vertex {vertex}: {what}"
                ))
            })?;
        }
        self.scene.primitives.push(shown);
        Ok(())
    }

    /// The values of an accessor, counted before; nothing where they are matrices.
    fn values(&mut self, accessor: usize, place: &str) -> Result<Option<Values>, ImportError> {
        if let Some(held) = self.values.get(&accessor) {
            return Ok(held.clone());
        }
        let values = self.view.elements(accessor, place)?.values();
        self.values.insert(accessor, values.clone());
        Ok(values)
    }

    /// What vertices have besides positions. Matrices stay in the document.
    fn attributes(
        &mut self,
        primitive: &PrimitiveView,
        place: &str,
    ) -> Result<Vec<Attribute>, ImportError> {
        let mut attributes = Vec::new();
        for &(name, accessor) in primitive.attributes.iter().filter(|(name, _)| *name != "POSITION")
        {
            if let Some(values) = self.values(accessor, &format!("{place}, {name}"))? {
                attributes.push(Attribute { name: name.to_owned(), values, corners: None });
            }
        }
        Ok(attributes)
    }

    /// The positions: three floats each, or integers where the document says so.
    fn positions(
        &self,
        accessor: usize,
        primitive: &PrimitiveView,
        place: &str,
    ) -> Result<Elements, ImportError> {
        use Component::{F32, I8, I16, U8, U16};
        let elements = self.view.elements(accessor, &format!("{place}, POSITION"))?;
        let component = match elements.component {
            F32 => true,
            I8 | U8 | I16 | U16 => self.quantized,
            Component::U32 | Component::F64 => false,
        };
        if elements.shape != Type::Vec3 || !component {
            return Err(ImportError::invalid(format!(
                "{place}: POSITION (accessor {accessor}) must be VEC3 of F32, or of 8 or 16 bits \
                 with KHR_mesh_quantization, not {:?} of {:?}",
                elements.shape, elements.component
            )));
        }
        let draco = primitive.json.pointer("/extensions/KHR_draco_mesh_compression");
        if draco.is_some() && self.view.accessors[accessor].buffer_view.is_none() {
            return Err(ImportError::Extension(format!(
                "{place} has its vertices only in KHR_draco_mesh_compression, which is not \
                 supported: save it without Draco"
            )));
        }
        let most = self.limits.triangles.saturating_mul(MOST_VERTICES_PER_TRIANGLE);
        if elements.count as u64 > most {
            return Err(ImportError::TooLarge(format!(
                "{place}: POSITION (accessor {accessor}) declares {} vertices and the limit is \
                 {most}: split the vertex buffer",
                elements.count
            )));
        }
        Ok(elements)
    }

    /// Count what a primitive costs, from what it declares, and check its attributes.
    fn count(
        &mut self,
        primitive: &PrimitiveView,
        positions: &Elements,
        triangles: u64,
        place: &str,
    ) -> Result<(), ImportError> {
        self.faces = self.faces.saturating_add(triangles);
        if self.faces > self.limits.triangles {
            return Err(ImportError::TooLarge(format!(
                "the scene has more than {} triangles, the limit, at {place}: simplify it or split \
                 it into several files",
                self.limits.triangles
            )));
        }
        let vertices = (positions.count as u64).min(triangles * 3);
        for &(name, accessor) in
            primitive.attributes.iter().chain(primitive.targets.iter().flatten())
        {
            let elements = self.view.elements(accessor, &format!("{place}, {name}"))?;
            if elements.count != positions.count {
                return Err(ImportError::invalid(format!(
                    "{place}: {name} (accessor {accessor}) has {} elements and POSITION has {}",
                    elements.count, positions.count
                )));
            }
            let replaced = elements.replaced_count() as u64;
            let bytes = (vertices + replaced) * elements.size as u64 + replaced * REPLACEMENT;
            self.bytes = self.bytes.saturating_add(bytes);
        }
        let most = self.limits.upload_bytes.saturating_mul(MOST_GROWTH);
        if self.bytes > most {
            return Err(ImportError::TooLarge(format!(
                "the vertex attributes and morph targets of the scene need more than {most} bytes, \
                 the limit, at {place}: leave some out"
            )));
        }
        Ok(())
    }

    /// Labels of the faces, from the vertex attribute `_PART`.
    fn read_labels(
        &mut self,
        primitive: &PrimitiveView,
        triangles: &[[u32; 3]],
        place: &str,
    ) -> Result<(), ImportError> {
        let before = (self.faces as usize).saturating_sub(triangles.len());
        let Some(accessor) = primitive.attribute("_PART") else { return Ok(()) };
        let elements = self.view.elements(accessor, &format!("{place}, _PART"))?;
        if elements.shape != Type::Scalar || !self.labels_hold {
            return Ok(());
        }
        let label = |vertex: u32| {
            let value = elements.value(vertex as usize, 0);
            let whole = value.fract() == 0.0 && value >= -1.0 && value <= f64::from(i32::MAX);
            whole.then_some(value as i32)
        };
        self.labels.resize(before, UNKNOWN);
        for triangle in triangles {
            let [a, b, c] = triangle.map(label);
            match a {
                Some(value) if a == b && b == c => self.labels.push(value),
                _ => {
                    self.labels_hold = false;
                    self.warn(
                        WarningCode::PartAttributeIgnored,
                        format!(
                            "{place}: _PART must be one whole number, -1 or more, over all corners \
                             of a face: it is not read"
                        ),
                    );
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// The primitive's material, and a note of the coordinates that its textures read.
    fn material(
        &mut self,
        primitive: &PrimitiveView,
        place: &str,
    ) -> Result<Option<usize>, ImportError> {
        let Some(number) = primitive.material else { return Ok(None) };
        let material = self.view.json.get("materials").and_then(|list| list.get(number));
        let material = material.ok_or_else(|| {
            ImportError::invalid(format!("{place}: material {number} does not exist"))
        })?;
        let sets = self.material_sets.entry(number).or_insert_with(|| textures::sets(material));
        let held = |set: &&u64| primitive.attribute(&format!("TEXCOORD_{set}")).is_some();
        self.texture_sets.extend(sets.iter().filter(held));
        Ok(Some(number))
    }

    fn finish(mut self, parents: &[Option<usize>]) -> Scene {
        if self.labels_hold && !self.labels.is_empty() {
            self.labels.resize(self.faces as usize, UNKNOWN);
            self.scene.labels = Some(std::mem::take(&mut self.labels));
        }
        let named = |list, index| self.name(list, index).unwrap_or_default();
        let nodes = self.view.nodes.iter().zip(parents).enumerate();
        let node = |(i, (node, parent)): (usize, (_, &Option<usize>))| Node {
            name: named("nodes", i),
            parent: parent.map(|parent| parent as u32),
            transform: Some(hierarchy::local(node)).filter(|t| *t != DMat4::IDENTITY).map(Box::new),
            mesh: node.mesh.map(|mesh| mesh.value() as u32),
        };
        let nodes = nodes.map(node).collect();
        let meshes =
            (0..self.view.meshes.len()).map(|i| Mesh { name: named("meshes", i) }).collect();
        let materials = self.view.json.get("materials").and_then(Value::as_array);
        let materials = 0..materials.map_or(0, Vec::len);
        let materials = materials.map(|i| Material { name: named("materials", i) }).collect();
        let texture_sets = self.texture_sets.into_iter().collect();
        Scene { nodes, meshes, materials, texture_sets, ..self.scene }
    }
}

/// What is wrong with a vertex in the world.
fn check_position(primitive: &Primitive, vertex: u32) -> Result<(), String> {
    let local: [f64; 3] = primitive.positions.vector(vertex as usize);
    if !local.iter().all(|x| x.is_finite()) {
        let local = DVec3::from_array(local);
        return Err(format!("the position {local} is not finite: repair the mesh"));
    }
    match primitive.position(vertex).is_finite() {
        true => Ok(()),
        false => Err("the node's transform takes it out of the finite numbers".to_owned()),
    }
}
