//! A mesh as it is told: nothing but faces, their vertices, and the primitive that each is in.

use std::fmt::Write;

use glam::DVec3;

use crate::mesh::Scene;

/// A mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlainMesh {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Normals of the corners of each face; empty where none are told.
    pub normals: Vec<[DVec3; 3]>,
    /// Vertex triples.
    pub triangles: Vec<[u32; 3]>,
    /// Primitive of each face; faces of one stand together.
    pub primitive: Vec<u32>,
    /// The face of the first telling that each is, or is a piece of; `None` for what was not there.
    pub source: Vec<Option<u32>>,
}

impl PlainMesh {
    /// The faces of a scene, in the world.
    pub fn of(scene: &Scene) -> Self {
        let mut mesh = Self::default();
        for (number, primitive) in (0u32..).zip(&scene.primitives) {
            let base = mesh.positions.len() as u32;
            let count = primitive.positions.count() as u32;
            mesh.positions.extend((0..count).map(|v| primitive.position(v)));
            mesh.triangles.extend(primitive.triangles.iter().map(|t| t.map(|v| v + base)));
            mesh.primitive.resize(mesh.triangles.len(), number);
        }
        mesh.source = (0..mesh.triangles.len() as u32).map(Some).collect();
        mesh
    }

    /// Positions of a face's corners.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.positions[v as usize])
    }

    /// Area of a face.
    pub fn area(&self, face: usize) -> f64 {
        let [a, b, c] = self.corners(face);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Diagonal of the box of what faces use.
    pub fn diagonal(&self) -> f64 {
        let used = || self.triangles.iter().flatten().map(|&v| self.positions[v as usize]);
        let low = used().fold(DVec3::INFINITY, DVec3::min);
        used().fold(DVec3::NEG_INFINITY, DVec3::max).distance(low)
    }

    /// The same with these of its faces, in this order but for primitives, which stay together.
    pub fn with(&self, faces: impl Iterator<Item = (u32, [u32; 3])>) -> Self {
        let mut faces: Vec<(u32, [u32; 3])> = faces.collect();
        faces.sort_by_key(|f| self.primitive[f.0 as usize]);
        Self {
            positions: self.positions.clone(),
            normals: Vec::new(),
            primitive: faces.iter().map(|f| self.primitive[f.0 as usize]).collect(),
            source: faces.iter().map(|f| self.source[f.0 as usize]).collect(),
            triangles: faces.into_iter().map(|f| f.1).collect(),
        }
    }

    /// As a Wavefront OBJ file: an object a primitive.
    pub fn obj(&self) -> String {
        let mut text = String::new();
        for p in &self.positions {
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
        }
        for n in self.normals.as_flattened() {
            let _ = writeln!(text, "vn {} {} {}", n.x, n.y, n.z);
        }
        let mut last = None;
        for (f, t) in self.triangles.iter().enumerate() {
            if last != Some(self.primitive[f]) {
                last = Some(self.primitive[f]);
                let _ = writeln!(text, "o part_{}", self.primitive[f]);
            }
            text.push('f');
            for (k, v) in t.iter().enumerate() {
                let _ = match self.normals.is_empty() {
                    true => write!(text, " {}", v + 1),
                    false => write!(text, " {}//{}", v + 1, 3 * f + k + 1),
                };
            }
            text.push('\n');
        }
        text
    }
}
