//! One folder a format, and the two matches that lead to them: from the kind of a file to what reads it,
//! and from the document behind a scene to what writes it. A format more is a folder and an arm here, and
//! a row in `contract::format`.

pub(in crate::mesh) mod gltf;
pub(in crate::mesh) mod obj;

#[cfg(test)]
mod tests;

use serde_json::Value;

use super::export::{ExportError, Layer};
use super::import::ImportError;
use super::scene::{Document, Scene};
use crate::contract::{Limits, MeshKind};

/// Read a file of this kind.
pub(super) fn read(bytes: &[u8], kind: MeshKind, limits: &Limits) -> Result<Scene, ImportError> {
    match kind {
        MeshKind::Glb => gltf::read_glb(bytes, limits),
        MeshKind::Gltf => gltf::read_json(bytes, None, limits),
        MeshKind::Obj => obj::read(bytes, limits),
    }
}

/// A scene with a layer as a glTF document and its binary chunk.
pub(super) fn write(scene: &Scene, layer: Layer) -> Result<(Value, Vec<u8>), ExportError> {
    match &scene.source {
        Some(Document::Gltf { json, buffers }) => {
            gltf::rewrite(json, buffers, &scene.primitives, layer)
        }
        None => gltf::fresh(scene, layer),
    }
}
