//! Writing a scene with new texture coordinates, or with its parts, as GLB. Everything else of a glTF
//! document stays as it was, in the same face order; a scene of another format becomes a fresh document.
//!
//! Inside, v points up; in glTF it points down. Here, and at no other place on the way out, v
//! becomes 1 − v.

mod layer;
mod split;

#[cfg(test)]
mod tests;

use serde_json::{Value, json};

use super::formats::{self, gltf};
use super::import::ImportError;
use super::scene::Scene;
pub(in crate::mesh) use layer::Layer;
pub(in crate::mesh) use split::split;

/// A scene that cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// There must be a value for each face.
    #[error("the scene has {faces} faces and there are values for {given}")]
    FaceCount {
        /// Faces of the scene.
        faces: usize,
        /// Faces that values were given for.
        given: usize,
    },
    /// A texture coordinate is infinite or no number.
    #[error("face {face} has a texture coordinate that is not finite")]
    NotFinite {
        /// The face, in face order.
        face: usize,
    },
    /// GLB counts its bytes in 32 bits.
    #[error("the result would have {0} bytes and a GLB file can have 4 GiB: split the scene")]
    TooLarge(u64),
    /// The document of the scene is not as import left it.
    #[error(transparent)]
    Document(#[from] ImportError),
}

/// A coordinate as a reader of the file gets it back. Since v is stored as 1 − v in single
/// precision, a v below ½ keeps only the 24 bits behind the point; a certificate of the exported
/// coordinates is taken on these. Idempotent.
pub fn as_exported(uv: [f32; 2]) -> [f32; 2] {
    let [u, v] = stored(uv);
    [u, 1.0 - v]
}

/// A coordinate as it stands in the file. No zero is negative, so that equal values have equal
/// bits.
pub(super) fn stored([u, v]: [f32; 2]) -> [f32; 2] {
    [u + 0.0, 1.0 - v]
}

/// The scene as GLB with `uvs` in `TEXCOORD_{uv_channel}`: for each face, in face order, the
/// coordinates of its corners in file winding, v up.
///
/// Vertices are split only where their corners differ in these coordinates; vertices that no face
/// uses are left out. Lower sets that a primitive lacks are filled with the same coordinates,
/// since glTF numbers sets without gaps. TANGENT goes when the set that it belongs to is replaced.
/// `extras` is stored as `asset.extras.uvsegnet`.
pub fn glb(
    scene: &Scene,
    uvs: &[[[f32; 2]; 3]],
    uv_channel: u8,
    extras: Option<&Value>,
) -> Result<Vec<u8>, ExportError> {
    if let Some(face) = uvs.iter().position(|uv| !uv.as_flattened().iter().all(|c| c.is_finite())) {
        return Err(ExportError::NotFinite { face });
    }
    write(scene, Layer::Uvs { uvs, channel: uv_channel }, extras)
}

/// The scene as GLB with the part of each face in the vertex attribute `_PART`, as a float; −1 where there
/// is none. Vertices are split where parts meet, for a vertex has one value; import reads the attribute
/// as labels. All else, texture coordinates too, stays. `extras` is stored as
/// `asset.extras.uvsegnet`.
pub fn part_glb(
    scene: &Scene,
    parts: &[i32],
    extras: Option<&Value>,
) -> Result<Vec<u8>, ExportError> {
    write(scene, Layer::Parts(parts), extras)
}

fn write(scene: &Scene, layer: Layer, extras: Option<&Value>) -> Result<Vec<u8>, ExportError> {
    let faces = scene.face_count();
    if faces != layer.faces() {
        return Err(ExportError::FaceCount { faces, given: layer.faces() });
    }
    let (mut json, bin) = formats::write(scene, layer)?;
    if let (Some(extras), Some(asset)) =
        (extras, json.get_mut("asset").and_then(Value::as_object_mut))
    {
        let held = asset.entry("extras").or_insert_with(|| json!({}));
        if !held.is_object() {
            *held = json!({ "original": held.take() });
        }
        held["uvsegnet"] = extras.clone();
    }
    gltf::join(&json, &bin)
}
