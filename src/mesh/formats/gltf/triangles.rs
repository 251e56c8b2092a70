//! The triangles of one glTF primitive: strips and fans expanded in face order, every index below
//! the vertex count.

use gltf::json::accessor::Type;
use gltf::json::mesh::Mode;

use super::accessor::Elements;
use super::view::{GltfView, PrimitiveView};
use crate::mesh::import::ImportError;
use crate::mesh::scene::Component;

/// How a primitive's corners are listed.
pub(in crate::mesh) struct Corners {
    indices: Option<Elements>,
    mode: Mode,
    vertices: usize,
}

impl Corners {
    /// The corners of a primitive of `vertices` vertices; nothing is read yet. `place` names it in
    /// errors.
    pub fn new(
        view: &GltfView,
        primitive: &PrimitiveView,
        mode: Mode,
        vertices: usize,
        place: &str,
    ) -> Result<Self, ImportError> {
        let read = |accessor| view.elements(accessor, &format!("{place}, indices"));
        let indices = primitive.indices.map(read).transpose()?;
        if let Some(indices) = &indices {
            use Component::{U8, U16, U32};
            let integers = matches!(indices.component, U8 | U16 | U32) && !indices.normalized;
            if !integers || indices.shape != Type::Scalar {
                return Err(ImportError::invalid(format!(
                    "{place}: indices must be SCALAR of unsigned integers, not {:?} of {:?}",
                    indices.shape, indices.component
                )));
            }
        }
        Ok(Self { indices, mode, vertices })
    }

    fn len(&self) -> usize {
        self.indices.as_ref().map_or(self.vertices, |indices| indices.count)
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        match self.mode {
            Mode::TriangleStrip | Mode::TriangleFan => self.len().saturating_sub(2),
            _ => self.len() / 3,
        }
    }

    /// How many corners at the end make no triangle.
    pub fn left_over(&self) -> usize {
        match self.mode {
            Mode::TriangleStrip | Mode::TriangleFan => 0,
            _ => self.len() % 3,
        }
    }

    /// The triangles, in file winding.
    pub fn triangles(&self, place: &str) -> Result<Vec<[u32; 3]>, ImportError> {
        let corner = |i: usize| {
            let Some(indices) = &self.indices else { return Ok(i as u32) };
            let vertex = indices.index(i);
            if (vertex as usize) < self.vertices {
                return Ok(vertex);
            }
            Err(ImportError::invalid(format!(
                "{place}: index {i} is {vertex} and there are {} vertices: export the mesh again",
                self.vertices
            )))
        };
        let triangle = |t: usize| match self.mode {
            // Every second triangle of a strip runs the other way in the list.
            Mode::TriangleStrip if t % 2 == 1 => [t + 1, t, t + 2],
            Mode::TriangleStrip => [t, t + 1, t + 2],
            Mode::TriangleFan => [0, t + 1, t + 2],
            _ => [3 * t, 3 * t + 1, 3 * t + 2],
        };
        (0..self.triangle_count())
            .map(|t| {
                let [a, b, c] = triangle(t);
                Ok([corner(a)?, corner(b)?, corner(c)?])
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expand(mode: Mode, vertices: usize) -> Vec<[u32; 3]> {
        Corners { indices: None, mode, vertices }.triangles("here").unwrap()
    }

    #[test]
    fn strips_and_fans_expand_in_order_and_keep_their_side() {
        assert_eq!(expand(Mode::Triangles, 7), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(expand(Mode::TriangleStrip, 5), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(expand(Mode::TriangleFan, 5), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(expand(Mode::TriangleStrip, 2), Vec::<[u32; 3]>::new());
        assert_eq!(expand(Mode::TriangleFan, 0), Vec::<[u32; 3]>::new());
    }
}
