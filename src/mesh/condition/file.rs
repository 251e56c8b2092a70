//! The faces of a scene in the order of the file, over all primitives.

use glam::DVec3;

use crate::mesh::scene::Renumbering;
use crate::mesh::{FaceOrigin, NONE, Scene};

/// Faces as the file has them.
pub struct FileFaces {
    /// Positions of the vertices that faces use, in the world.
    pub positions: Vec<DVec3>,
    /// Primitive, and vertex there, of each.
    pub source: Vec<(u32, u32)>,
    /// Vertices of each face.
    pub triangles: Vec<[u32; 3]>,
    /// The same faces on welded vertices; empty before those are known.
    pub welded: Vec<[u32; 3]>,
    /// Where each face comes from.
    pub origins: Vec<FaceOrigin>,
    /// First face of each primitive.
    pub primitives: Vec<u32>,
    /// Lowest corner of their box, and its diagonal (1 for a point).
    pub low: DVec3,
    /// Diagonal of the box, world units.
    pub diagonal: f64,
}

/// An object that lies farther from the origin than so many diagonals is moved there, for the solvers.
const FAR: f64 = 64.0;

impl FileFaces {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let (mut positions, mut source) = (Vec::new(), Vec::new());
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(scene.face_count());
        let mut origins = Vec::with_capacity(scene.face_count());
        let mut numbers = Renumbering::default();
        let mut primitives = Vec::with_capacity(scene.primitives.len());
        for (p, primitive) in (0u32..).zip(&scene.primitives) {
            let (base, first) = (positions.len() as u32, triangles.len());
            primitives.push(first as u32);
            triangles.extend_from_slice(&primitive.triangles);
            let used = numbers.apply(&mut triangles[first..], primitive.positions.count());
            positions.extend(used.iter().map(|&vertex| primitive.position(vertex)));
            source.extend(used.iter().map(|&vertex| (p, vertex)));
            triangles[first..].as_flattened_mut().iter_mut().for_each(|vertex| *vertex += base);
            for _ in &primitive.triangles {
                origins.push(FaceOrigin {
                    face: origins.len() as u32,
                    primitive: p,
                    material: primitive.material.unwrap_or(NONE),
                    shell: 0,
                });
            }
        }
        let (mut low, diagonal) = extent(&positions);
        if low.length() > FAR * diagonal {
            // What is far from the origin loses its shape where numbers are kept in single precision.
            positions.iter_mut().for_each(|p| *p -= low);
            low = DVec3::ZERO;
        }
        Self {
            positions,
            source,
            triangles,
            welded: Vec::new(),
            origins,
            primitives,
            low,
            diagonal,
        }
    }

    /// First face of a primitive.
    pub fn first_face(&self, primitive: u32) -> u32 {
        self.primitives[primitive as usize]
    }

    /// Positions of a face's corners.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.triangles[face].map(|v| self.positions[v as usize])
    }
}

/// Lowest corner and diagonal of the box around all positions.
fn extent(positions: &[DVec3]) -> (DVec3, f64) {
    let low = positions.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = positions.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let diagonal = (high - low).length();
    if diagonal.is_finite() && diagonal > 0.0 { (low, diagonal) } else { (DVec3::ZERO, 1.0) }
}
