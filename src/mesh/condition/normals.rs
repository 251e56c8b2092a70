//! What the vertex normals of a file say of the front of its faces.

use glam::{DMat3, DVec3};

use super::file::FileFaces;
use super::places::Places;
use super::sign::Said;
use super::tell::Count;
use crate::mesh::{Scene, Surface};

/// Name of the normals among the attributes.
const NORMAL: &str = "NORMAL";

/// Sum of the vertex normals of each face of the file, in the world; zero where it has none. Empty where
/// no face has any.
pub fn of_faces(scene: &Scene) -> Vec<DVec3> {
    if scene.primitives.iter().all(|p| p.attribute(NORMAL).is_none()) {
        return Vec::new();
    }
    let mut normals = Vec::with_capacity(scene.face_count());
    for primitive in &scene.primitives {
        let faces = primitive.triangles.len();
        let Some(set) = primitive.attribute(NORMAL).filter(|set| set.values.width() == 3) else {
            normals.resize(normals.len() + faces, DVec3::ZERO);
            continue;
        };
        let world = primitive.world.map_or(DMat3::IDENTITY, DMat3::from_mat4);
        let turn = world.inverse().transpose() * world.determinant().signum();
        let at = |face: usize, k: usize| {
            let index = set.index(face, k, primitive.triangles[face][k]);
            index.map_or(DVec3::ZERO, |i| DVec3::from_array(set.values.vector(i)))
        };
        let sum = |face: usize| turn * (at(face, 0) + at(face, 1) + at(face, 2));
        normals
            .extend((0..faces).map(|f| Some(sum(f)).filter(|n| n.is_finite()).unwrap_or_default()));
    }
    normals
}

/// Faces of the file that are wound against their own vertex normals.
pub fn against(normals: &[DVec3], file: &FileFaces, usable: &[bool]) -> Count {
    let mut against = Count::default();
    for (f, normal) in (0u32..).zip(normals).filter(|(f, _)| usable[*f as usize]) {
        let [a, b, c] = file.corners(f as usize);
        if normal.dot((b - a).cross(c - a)) < 0.0 {
            against.add(f);
        }
    }
    against
}

impl Said {
    /// What a file says of the faces of a surface, `faces` being the place of each. Where both sides stand,
    /// normals say nothing.
    pub fn of(normals: &[DVec3], surface: &Surface, places: &Places, faces: &[u32]) -> Self {
        let ascends = |f: usize| surface.triangles[f][1] < surface.triangles[f][2];
        let instances = |f: usize| places.instances(faces[f] as usize);
        let alike = |f: usize| instances(f)[0].ascending == ascends(f);
        let normal = |f: usize| {
            let sides = instances(f);
            let one = sides.iter().all(|i| i.ascending == sides[0].ascending);
            let normal = normals.get(sides[0].face as usize).filter(|_| one);
            normal.map_or(0.0, |n| n.normalize_or_zero().dot(surface.normals[f]) as f32)
        };
        Self {
            alike: (0..faces.len()).map(alike).collect(),
            normal: (0..faces.len()).map(normal).collect(),
        }
    }
}
