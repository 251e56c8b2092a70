//! Small meshes, good and bad.

use serde_json::{Value, json};

pub use super::glb::glb;

/// A unit cube.
pub const CUBE_OBJ: &str = "\
o cube
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
";

/// The corners and the triangles of a tetrahedron.
pub fn tetrahedron() -> ([[f32; 3]; 4], [u16; 12]) {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    (corners, [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
}

/// The document and the binary chunk of a mesh.
pub fn parts(corners: [[f32; 3]; 4], triangles: [u16; 12]) -> (Value, Vec<u8>) {
    let mut binary: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    binary.extend(triangles.iter().flat_map(|i| i.to_le_bytes()));
    let document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [0.0, 0.0, 0.0], "max": [1.0, 1.0, 1.0]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"byteLength": 72}],
    });
    (document, binary)
}

/// A tetrahedron as binary glTF.
pub fn tetrahedron_glb() -> Vec<u8> {
    let (corners, triangles) = tetrahedron();
    let (document, binary) = parts(corners, triangles);
    glb(&document, &binary)
}

/// A ball of about 2·n² triangles: it has to be trained, which takes a while.
pub fn ball_obj(n: usize) -> String {
    use std::f64::consts::PI;
    let mut text = String::from("o ball\nv 0 0 1\nv 0 0 -1\n");
    for i in 1..n {
        for j in 0..n {
            let (a, b) = (PI * i as f64 / n as f64, 2.0 * PI * j as f64 / n as f64);
            let (x, y, z) = (a.sin() * b.cos(), a.sin() * b.sin(), a.cos());
            text += &format!("v {x:.6} {y:.6} {z:.6}\n");
        }
    }
    let at = |i: usize, j: usize| 3 + (i - 1) * n + j % n;
    for j in 0..n {
        text += &format!("f 1 {} {}\n", at(1, j), at(1, j + 1));
        text += &format!("f 2 {} {}\n", at(n - 1, j + 1), at(n - 1, j));
        for i in 1..n - 1 {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}
