//! A scene as it was uploaded, whatever its format. What the solvers ask for is here; the document it was
//! read from stands beside it, so that a result changes texture coordinates, splits vertices at seams, and
//! nothing else.

mod attribute;
mod instance;
mod primitive;
mod used;
mod values;
mod view;

pub use attribute::{ABSENT, Attribute, TEXCOORD};
pub use instance::{Instance, Other};
pub use primitive::Primitive;
pub(in crate::mesh) use used::Renumbering;
pub use values::Values;
pub use view::Component;
pub(in crate::mesh) use view::{Replaced, View};

use bytes::Bytes;
use glam::{DMat4, DVec3};

use crate::contract::Warning;

/// What was read from a file, or made by hand.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Every node of the source, also those that are not shown, in its order.
    pub nodes: Vec<Node>,
    /// Every mesh of the source, in its order.
    pub meshes: Vec<Mesh>,
    /// Every material of the source, in its order.
    pub materials: Vec<Material>,
    /// Every triangle primitive that is shown, each mesh at its first use, in face order.
    pub primitives: Vec<Primitive>,
    /// Every use of a mesh by a node of what is shown, depth-first; empty where each stands once and in the
    /// world already.
    pub instances: Vec<Instance>,
    /// Where the source's texture coordinates are (0, 0).
    pub texcoord_origin: TexcoordOrigin,
    /// Numbers of the sets of texture coordinates that the textures of what is shown are drawn through, in
    /// ascending order.
    pub texture_sets: Vec<u64>,
    /// One label a face (−1 unknown), from the file or given with the request.
    pub labels: Option<Vec<i32>>,
    /// What the user should know about the file.
    pub warnings: Vec<Warning>,
    /// What it was read from, where the result is written into that; else a fresh document is written.
    pub source: Option<Document>,
}

/// Where something stands.
#[derive(Debug, Clone, Default)]
pub struct Node {
    /// Its name, or empty.
    pub name: String,
    /// Index of the node above.
    pub parent: Option<u32>,
    /// Transform against the node above; `None` for the identity. Apart, for most have none.
    pub transform: Option<Box<DMat4>>,
    /// Index of the mesh that it shows.
    pub mesh: Option<u32>,
}

/// What one or more nodes show; its primitives stand in the scene's list.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Its name, or empty.
    pub name: String,
}

/// What a surface is made of.
#[derive(Debug, Clone, Default)]
pub struct Material {
    /// Its name, or empty.
    pub name: String,
}

/// Where a picture's texture coordinates begin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TexcoordOrigin {
    /// Bottom left: v points up.
    #[default]
    BottomLeft,
    /// Top left: v points down.
    TopLeft,
}

/// The document behind a scene.
#[derive(Debug, Clone)]
pub enum Document {
    /// glTF, binary or not: the JSON with everything in it, and its buffers, decoded.
    Gltf {
        /// The whole JSON.
        json: serde_json::Value,
        /// The bytes of each buffer; the scene's attributes are views into them.
        buffers: Vec<Bytes>,
    },
}

impl Scene {
    /// A scene of one primitive, made by hand.
    pub fn from_triangles(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let mut scene = Self::default();
        scene.add("", Primitive::from_triangles(positions, triangles));
        scene
    }

    /// Add a primitive with a node and a mesh of its own, both of this name.
    pub fn add(&mut self, name: &str, primitive: Primitive) {
        let (node, mesh) = (self.nodes.len() as u32, self.meshes.len() as u32);
        self.nodes.push(Node { name: name.into(), mesh: Some(mesh), ..Node::default() });
        self.meshes.push(Mesh { name: name.into() });
        self.primitives.push(Primitive { node, mesh, number: 0, ..primitive });
    }

    /// Faces over all primitives.
    pub fn face_count(&self) -> usize {
        self.primitives.iter().map(|p| p.triangles.len()).sum()
    }

    /// The name of a primitive: of its node, or else of its mesh, or else empty.
    pub fn name(&self, primitive: &Primitive) -> &str {
        let node = self.nodes.get(primitive.node as usize).map_or("", |node| &node.name);
        let mesh = || self.meshes.get(primitive.mesh as usize).map_or("", |mesh| &mesh.name);
        if node.is_empty() { mesh() } else { node }
    }

    /// The name of a primitive's material, or empty.
    pub fn material_name(&self, primitive: &Primitive) -> &str {
        let material = primitive.material.and_then(|m| self.materials.get(m as usize));
        material.map_or("", |material| &material.name)
    }

    /// The transform of a node into the world. A node with more nodes above it than there are has
    /// none: it is its own ancestor.
    pub fn world(&self, node: u32) -> Option<DMat4> {
        let mut world = DMat4::IDENTITY;
        let mut at = Some(node);
        for _ in 0..self.nodes.len() {
            let node = self.nodes.get(at? as usize)?;
            if let Some(transform) = &node.transform {
                world = **transform * world;
            }
            at = node.parent;
            if at.is_none() {
                return Some(world);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_back_and_transforms_go_upwards() {
        let triangle = || Primitive::from_triangles(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]);
        let mut scene = Scene::from_triangles(vec![DVec3::ZERO; 3], vec![[0, 1, 2]]);
        scene.add("seat", triangle());
        assert_eq!(
            scene.primitives.iter().map(|p| scene.name(p)).collect::<Vec<_>>(),
            ["", "seat"]
        );
        scene.nodes[1].name.clear();
        scene.meshes[1].name = "board".into();
        assert_eq!(scene.name(&scene.primitives[1]), "board");
        scene.primitives[1].material = Some(3);
        assert_eq!(scene.material_name(&scene.primitives[1]), "", "no such material");

        let moved = |by| Some(Box::new(DMat4::from_translation(by)));
        scene.nodes[0].transform = Some(Box::new(DMat4::from_scale(DVec3::splat(2.0))));
        scene.nodes[1].parent = Some(0);
        scene.nodes[1].transform = moved(DVec3::X);
        assert_eq!(scene.world(1).unwrap().transform_point3(DVec3::Y), DVec3::new(2.0, 2.0, 0.0));
        scene.nodes[0].parent = Some(1);
        assert_eq!(scene.world(1), None, "a cycle");
        assert_eq!(scene.world(9), None);
    }
}
