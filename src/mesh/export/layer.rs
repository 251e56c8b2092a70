//! What is new in a file that is written: coordinates at the corners of its faces, or a part a face.

use serde_json::{Map, Value};

use super::stored;
use crate::mesh::formats::gltf::binary::Streams;

/// The vertex attribute that tells parts: a whole number as a float, −1 unknown. Import reads it back as
/// labels.
pub(in crate::mesh) const PART: &str = "_PART";

/// One new value at each corner of each face, as the bits that tell vertices apart.
pub(in crate::mesh) type Bits = [u32; 2];

/// What is written.
#[derive(Debug, Clone, Copy)]
pub(in crate::mesh) enum Layer<'a> {
    /// Texture coordinates of the corners of each face, v up, into `TEXCOORD_{channel}`.
    Uvs {
        /// Faces × corners.
        uvs: &'a [[[f32; 2]; 3]],
        /// Which set.
        channel: u8,
    },
    /// One part a face, into `_PART`.
    Parts(&'a [i32]),
}

impl Layer<'_> {
    /// Faces that it has values for.
    pub fn faces(&self) -> usize {
        match self {
            Self::Uvs { uvs, .. } => uvs.len(),
            Self::Parts(parts) => parts.len(),
        }
    }

    /// The first `count` faces, and the others.
    pub fn split_at(self, count: usize) -> (Self, Self) {
        match self {
            Self::Uvs { uvs, channel } => {
                let (own, others) = uvs.split_at(count);
                (Self::Uvs { uvs: own, channel }, Self::Uvs { uvs: others, channel })
            }
            Self::Parts(parts) => {
                let (own, others) = parts.split_at(count);
                (Self::Parts(own), Self::Parts(others))
            }
        }
    }

    /// The value of each corner, face by face.
    pub fn corners(&self) -> impl Iterator<Item = Bits> {
        (0..3 * self.faces()).map(|corner| match self {
            Self::Uvs { uvs, .. } => stored(uvs[corner / 3][corner % 3]).map(f32::to_bits),
            Self::Parts(parts) => [(parts[corner / 3] as f32).to_bits(), 0],
        })
    }

    /// The attribute that it becomes.
    pub fn attribute(&self) -> String {
        match self {
            Self::Uvs { channel, .. } => format!("TEXCOORD_{channel}"),
            Self::Parts(_) => PART.to_owned(),
        }
    }

    /// Attributes that must stand in the file with it: glTF numbers sets without gaps.
    pub fn with_lower_sets(&self) -> Vec<String> {
        match self {
            Self::Uvs { channel, .. } => (0..=*channel).map(|n| format!("TEXCOORD_{n}")).collect(),
            Self::Parts(_) => vec![PART.to_owned()],
        }
    }

    /// The texture coordinates' set, if it is that.
    pub fn channel(&self) -> Option<u8> {
        match self {
            Self::Uvs { channel, .. } => Some(*channel),
            Self::Parts(_) => None,
        }
    }

    /// Append the values of vertices, and describe them as an accessor.
    pub fn append(
        &self,
        streams: &mut Streams,
        values: impl ExactSizeIterator<Item = Bits>,
    ) -> Map<String, Value> {
        match self {
            Self::Uvs { .. } => streams.append_floats(values.map(|v| v.map(f32::from_bits))),
            Self::Parts(_) => streams.append_floats(values.map(|v| [f32::from_bits(v[0])])),
        }
    }
}
