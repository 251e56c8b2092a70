//! Small glTF documents for tests, built accessor by accessor.

use serde_json::{Value, json};

/// `componentType` of the specification.
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const F32: u32 = 5126;

/// A document under construction and its binary chunk.
#[derive(Clone)]
pub struct Fixture {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Fixture {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [],
        });
        Self { json, bin: Vec::new() }
    }

    /// Add an element to one of the document's lists.
    pub fn add(&mut self, list: &str, element: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let items = self.json[list].as_array_mut().unwrap();
        items.push(element);
        items.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        self.add("bufferViews", view)
    }

    pub fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "type": shape, "count": count});
        self.add("accessors", accessor)
    }

    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let shape = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessor(F32, shape, values.len(), bytemuck::cast_slice(values.as_flattened()))
    }

    pub fn indices(&mut self, values: &[u16]) -> usize {
        self.accessor(U16, "SCALAR", values.len(), bytemuck::cast_slice(values))
    }

    /// Add a mesh and a node that shows it to the default scene.
    pub fn show(&mut self, primitives: Value) -> usize {
        let mesh = self.add("meshes", json!({"primitives": primitives}));
        let node = self.add("nodes", json!({"mesh": mesh}));
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(node.into());
        mesh
    }

    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bin.len()}]);
        glb(json.to_string().as_bytes(), &self.bin)
    }
}

/// A GLB file of two chunks.
pub fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, bytes, pad) in [(b"JSON", json, b' '), (b"BIN\0", bin, 0)] {
        let size = bytes.len().next_multiple_of(4);
        out.extend((size as u32).to_le_bytes());
        out.extend(kind);
        out.extend(bytes);
        out.resize(out.len() + size - bytes.len(), pad);
    }
    let length = out.len() as u32;
    out[8..12].copy_from_slice(&length.to_le_bytes());
    out
}

/// Positions of a strip of `n` unit squares in the plane, two vertices a column.
pub fn strip(n: usize) -> Vec<[f32; 3]> {
    (0..=n).flat_map(|i| [[i as f32, 0.0, 0.0], [i as f32, 1.0, 0.0]]).collect()
}

/// Two squares as an indexed mesh with normals.
pub fn squares() -> Fixture {
    let mut f = Fixture::new();
    let positions = f.floats(&strip(2));
    let normals = f.floats(&[[0.0, 0.0, 1.0]; 6]);
    let indices = f.indices(&[0, 2, 3, 0, 3, 1, 2, 4, 5, 2, 5, 3]);
    f.show(json!([{
        "attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices,
    }]));
    f
}

/// One of everything: strips, lines, points, shared vertex buffers, instances, a skin, sparse morph
/// targets, an animation, labels, an embedded image, integers, a mesh that is not shown.
pub fn rich() -> Fixture {
    let mut f = Fixture::new();
    let shared = f.floats(&strip(4));
    let first = f.indices(&[0, 2, 3, 0, 3, 1]);
    let second = f.indices(&[4, 6, 7, 4, 7, 5, 6, 8, 9, 6, 9, 7]);
    let colors = f.accessor(U8, "VEC3", 10, &(0..30).collect::<Vec<u8>>());
    f.json["accessors"][colors]["normalized"] = json!(true);
    let colors_view = f.json["accessors"][colors]["bufferView"].as_u64().unwrap() as usize;
    f.bin.extend([9; 10]);
    f.json["bufferViews"][colors_view]["byteLength"] = json!(40);
    f.json["bufferViews"][colors_view]["byteStride"] = json!(4);
    let coordinates = f.floats(&[[0.25, 0.75]; 10]);
    let tangents = f.floats(&[[1.0, 0.0, 0.0, 1.0]; 10]);
    let normals = f.floats(&[[0.0, 0.0, 1.0]; 10]);
    let joints = f.accessor(U8, "VEC4", 10, &[0; 40]);
    let weights = f.floats(&[[1.0, 0.0, 0.0, 0.0]; 10]);
    let keys = f.view(bytemuck::cast_slice(&[3u16, 8]));
    let values = f.view(bytemuck::cast_slice(&[[0.0f32, 0.0, 1.0], [0.0, 0.0, 2.0]]));
    let morph = f.add(
        "accessors",
        json!({"componentType": F32, "type": "VEC3", "count": 10, "sparse": {
            "count": 2,
            "indices": {"bufferView": keys, "componentType": U16},
            "values": {"bufferView": values},
        }}),
    );
    let image = f.view(b"not really a png");
    f.add("images", json!({"bufferView": image, "mimeType": "image/png"}));
    f.add("textures", json!({"source": 0}));
    f.add("materials", json!({"name": "wood", "normalTexture": {"index": 0}}));
    let bind =
        f.accessor(F32, "MAT4", 1, bytemuck::cast_slice(&glam::Mat4::IDENTITY.to_cols_array()));
    f.show(json!([
        {"attributes": {"POSITION": shared, "COLOR_0": colors, "TEXCOORD_0": coordinates,
            "NORMAL": normals, "TANGENT": tangents, "JOINTS_0": joints, "WEIGHTS_0": weights},
         "indices": first, "material": 0, "targets": [{"POSITION": morph}], "extras": {"keep": 1}},
        {"attributes": {"POSITION": shared, "NORMAL": normals, "TANGENT": tangents},
         "indices": second, "targets": [{"POSITION": morph}]},
        {"attributes": {"POSITION": shared}, "mode": 1, "targets": [{"POSITION": morph}]},
    ]));
    f.json["nodes"][0]["skin"] = json!(0);
    f.json["nodes"][0]["name"] = json!("bench");
    f.add("skins", json!({"joints": [0], "inverseBindMatrices": bind}));
    let small = f.accessor(
        I16,
        "VEC3",
        5,
        bytemuck::cast_slice(&[
            [0i16, 0, 0, 7],
            [100, 0, 0, 7],
            [0, 100, 0, 7],
            [100, 100, 0, 7],
            [0, 200, 0, 7],
        ]),
    );
    let small_view = f.json["accessors"][small]["bufferView"].as_u64().unwrap() as usize;
    f.json["bufferViews"][small_view]["byteStride"] = json!(8);
    f.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    f.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let parts = f.floats(&[[4.0]; 5]);
    let mesh = f.show(json!([
        {"attributes": {"POSITION": small, "_PART": parts}, "mode": 5},
        {"attributes": {"POSITION": small}, "mode": 0},
    ]));
    f.json["nodes"][1]["scale"] = json!([0.01, 0.01, 0.01]);
    f.add("nodes", json!({"mesh": mesh, "scale": [0.5, 0.5, 0.5], "children": [3]}));
    f.add("nodes", json!({"translation": [0, 0, 1]}));
    f.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let times = f.floats(&[[0.0], [1.0]]);
    let path = f.floats(&[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    f.add(
        "animations",
        json!({
            "samplers": [{"input": times, "output": path}],
            "channels": [{"sampler": 0, "target": {"node": 3, "path": "translation"}}],
        }),
    );
    let hidden = f.floats(&[[5.0, 5.0, 5.0], [6.0, 5.0, 5.0], [5.0, 6.0, 5.0]]);
    f.add(
        "meshes",
        json!({"name": "hidden", "primitives": [{"attributes": {"POSITION": hidden}}]}),
    );
    f.json["extras"] = json!({"author": "someone"});
    f
}
