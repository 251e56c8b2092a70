//! glTF 2.0, binary or as JSON: the checked reader, and the writer that leaves all it does not change.

pub(in crate::mesh) mod accessor;
pub(in crate::mesh) mod binary;
mod buffers;
mod container;
mod extensions;
mod fresh;
mod hierarchy;
mod json;
mod read;
mod references;
mod rewrite;
mod textures;
pub(in crate::mesh) mod triangles;
pub(in crate::mesh) mod view;

#[cfg(test)]
pub(in crate::mesh) mod fixture;

pub(in crate::mesh) use container::join;
pub(in crate::mesh) use fresh::fresh;
pub(in crate::mesh) use rewrite::rewrite;

use crate::contract::{Limits, Warning, WarningCode};
use crate::mesh::import::ImportError;
use crate::mesh::scene::Scene;

/// Read a GLB file.
pub(super) fn read_glb(bytes: &[u8], limits: &Limits) -> Result<Scene, ImportError> {
    let chunks = container::split(bytes)?;
    let mut scene = read_json(chunks.json, chunks.bin, limits)?;
    if chunks.passed_over {
        let message = "what stands in the GLB behind its known chunks was left out";
        scene.warnings.push(Warning::new(WarningCode::PassedOver, message));
    }
    Ok(scene)
}

/// Read the JSON of a document, with the binary chunk beside it if there is one.
pub(super) fn read_json(
    text: &[u8],
    bin: Option<&[u8]>,
    limits: &Limits,
) -> Result<Scene, ImportError> {
    let mut json = json::parse(text, limits)?;
    extensions::check_required(&json)?;
    let buffers = buffers::decode(&mut json, bin)?;
    read::read(json, buffers, limits)
}
