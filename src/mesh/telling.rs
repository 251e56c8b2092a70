//! How a file tells a surface: which of its faces stands where, and on which side. The surface has one order,
//! the file another; what comes from the file is read, and what goes back is written, through this alone.

use super::{NONE, Surface};

/// How a file tells a surface.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Telling {
    /// The surface's face at the place of each face of the file, or [`NONE`] for one without area.
    pub face: Vec<u32>,
    /// Whether it is the second side of that face. Length: faces of the file.
    pub second: Vec<bool>,
    /// The surface's vertices at the corners of each face of the file, in the file's order.
    pub triangles: Vec<[u32; 3]>,
    /// First face of each primitive.
    pub primitives: Vec<u32>,
}

impl Telling {
    /// Primitive of a face of the file.
    pub fn primitive(&self, file_face: u32) -> u32 {
        self.primitives.partition_point(|&first| first <= file_face).saturating_sub(1) as u32
    }

    /// Which corner of the surface's face lies where corner `k` of a face of the file does.
    pub fn corner(&self, surface: &Surface, file_face: usize, k: usize) -> usize {
        let vertex = self.triangles[file_face][k];
        let face = self.face[file_face] as usize;
        surface.triangles[face].iter().position(|&v| v == vertex).unwrap_or(k)
    }

    /// Whether the file winds a face the other way than the surface does.
    pub fn is_against(&self, surface: &Surface, file_face: usize) -> bool {
        let [a, b] = [0, 1].map(|k| self.corner(surface, file_face, k));
        (a + 1) % 3 != b
    }

    /// Values of the surface's faces in the order of the file; `none` where there is no face.
    pub fn in_file_order<T: Copy>(&self, of_face: &[T], none: T) -> Vec<T> {
        let value = |&f: &u32| if f == NONE { none } else { of_face[f as usize] };
        self.face.iter().map(value).collect()
    }
}
