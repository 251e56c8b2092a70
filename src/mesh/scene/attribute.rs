//! A named attribute of a primitive.

use super::values::Values;

/// "This corner has none of it."
pub const ABSENT: u32 = u32::MAX;

/// Name of the first set of texture coordinates.
pub const TEXCOORD: &str = "TEXCOORD_0";

/// An attribute, named as in glTF whatever the format: NORMAL, COLOR_0, TEXCOORD_0, or what the file calls
/// it behind an underscore.
#[derive(Debug, Clone)]
pub struct Attribute {
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: Values,
    /// Index of the value of each corner, or [`ABSENT`]. Length: faces. `None` where the corner's vertex
    /// is the index.
    pub corners: Option<Vec<[u32; 3]>>,
}

impl Attribute {
    /// Index of the value of a face's corner `k`, which is at `vertex`.
    pub fn index(&self, face: usize, k: usize, vertex: u32) -> Option<usize> {
        let index = self.corners.as_ref().map_or(vertex, |corners| corners[face][k]);
        (index != ABSENT).then_some(index as usize)
    }

    /// Whether every corner has a value.
    pub fn is_whole(&self) -> bool {
        let corners = self.corners.as_deref().unwrap_or_default();
        !corners.as_flattened().contains(&ABSENT)
    }
}
