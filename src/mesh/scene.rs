//! A scene as it was uploaded. The document is kept whole: unwrapping changes texture coordinates,
//! splits vertices at seams, and nothing else.

use glam::DVec3;

use super::formats::obj::ObjDocument;

/// What was read from a file.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The file itself.
    pub document: Document,
    /// Every triangle primitive of the default scene, each mesh at its first use, in face order.
    pub primitives: Vec<Primitive>,
    /// One label a face (−1 unknown), from a vertex attribute `_PART` or given with the request.
    pub labels: Option<Vec<i32>>,
    /// What the user should know about the file: a short code and a sentence each.
    pub warnings: Vec<(String, String)>,
}

/// The file behind a scene.
#[derive(Debug, Clone)]
pub enum Document {
    /// glTF, binary or not: the JSON with everything in it, and its buffers, decoded.
    Gltf {
        /// The whole JSON.
        json: serde_json::Value,
        /// The bytes of each buffer.
        buffers: Vec<Vec<u8>>,
    },
    /// Wavefront OBJ.
    Obj(ObjDocument),
}

/// The triangles of one primitive.
#[derive(Debug, Clone, Default)]
pub struct Primitive {
    /// Index of the node of its mesh's first use (OBJ: of the object or group).
    pub node: u32,
    /// Index of its mesh (OBJ: as `node`).
    pub mesh: u32,
    /// Index within its mesh (OBJ: 0).
    pub primitive: u32,
    /// Index of its material.
    pub material: Option<u32>,
    /// Name of the node, or else of the mesh, or else empty.
    pub name: String,
    /// Name of the material, or empty.
    pub material_name: String,
    /// World positions of its vertices, at the largest instance of its mesh.
    pub positions: Vec<DVec3>,
    /// Vertex triples in file winding, strips and fans expanded. Length: faces.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of its corners as the file has them (glTF: set 0), NaN where a corner has none.
    /// Length: faces, or 0 where there are none at all.
    pub texcoords: Vec<[[f32; 2]; 3]>,
}

impl Scene {
    /// Faces over all primitives.
    pub fn face_count(&self) -> usize {
        self.primitives.iter().map(|p| p.triangles.len()).sum()
    }
}
