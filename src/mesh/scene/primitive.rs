//! The triangles of one primitive, and what its vertices and corners have.

use glam::{DMat4, DVec3};

use super::attribute::{Attribute, TEXCOORD};
use super::values::Values;

/// The triangles of one primitive.
#[derive(Debug, Clone, Default)]
pub struct Primitive {
    /// Index of the node of its mesh's first use.
    pub node: u32,
    /// Index of its mesh.
    pub mesh: u32,
    /// Its number within the mesh of the source.
    pub number: u32,
    /// Index of its material.
    pub material: Option<u32>,
    /// World transform of the largest instance of its mesh; `None` where the vertices stand in the world
    /// already.
    pub world: Option<DMat4>,
    /// Positions of vertices, three numbers each. Primitives may share them, and then each uses some.
    pub positions: Values,
    /// Vertex triples in file winding, strips, fans and polygons expanded. Length: faces.
    pub triangles: Vec<[u32; 3]>,
    /// Corners of each polygon of the source, in order: one of n corners is the next n − 2 triangles, a
    /// fan around its first corner. `None` where all are triangles.
    pub polygons: Option<Vec<u32>>,
    /// What else there is, but the positions.
    pub attributes: Vec<Attribute>,
}

impl Primitive {
    /// A primitive of nothing but triangles, made by hand, in the world.
    pub fn from_triangles(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let positions = Values::doubles(positions.iter().map(DVec3::to_array).collect());
        Self { positions, triangles, ..Self::default() }
    }

    /// A vertex in the world.
    pub fn position(&self, vertex: u32) -> DVec3 {
        let local = DVec3::from_array(self.positions.vector(vertex as usize));
        self.world.map_or(local, |world| world.transform_point3(local))
    }

    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Texture coordinates of set 0 at the corners of each face as the source has them, NaN where a corner
    /// has none. `None` where there are none at all.
    pub fn texcoords(&self) -> Option<impl Iterator<Item = [[f32; 2]; 3]>> {
        let set = self.attribute(TEXCOORD).filter(|set| set.values.width() == 2)?;
        let at = move |(face, triangle): (usize, &[u32; 3])| {
            [0, 1, 2].map(|k| match set.index(face, k, triangle[k]) {
                Some(index) => set.values.vector(index).map(|x| x as f32),
                None => [f32::NAN; 2],
            })
        };
        Some(self.triangles.iter().enumerate().map(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::scene::ABSENT;

    #[test]
    fn corners_and_vertices_have_coordinates() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mut primitive = Primitive::from_triangles(corners, vec![[0, 1, 2], [2, 1, 0]]);
        assert!(primitive.texcoords().is_none());
        let values = Values::floats(vec![[0.0, 0.5], [1.0, 0.5], [2.0, 0.5]]);
        let name = TEXCOORD.to_owned();
        primitive.attributes = vec![Attribute { name, values, corners: None }];
        let u =
            |p: &Primitive| p.texcoords().unwrap().map(|t| t.map(|uv| uv[0])).collect::<Vec<_>>();
        assert_eq!(u(&primitive), [[0.0, 1.0, 2.0], [2.0, 1.0, 0.0]]);
        primitive.attributes[0].corners = Some(vec![[1, 1, 1], [0, ABSENT, 2]]);
        assert_eq!(u(&primitive)[0], [1.0; 3]);
        assert!(u(&primitive)[1][1].is_nan());
        assert!(!primitive.attributes[0].is_whole());
    }
}
