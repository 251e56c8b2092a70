//! Reading meshes: any bytes in, a scene or a sentence about what is wrong with them out. Nothing
//! here panics, opens another file, or allocates what the file only declares.

pub(in crate::mesh) mod accessor;
mod buffers;
mod error;
pub(in crate::mesh) mod extensions;
mod glb;
mod gltf;
mod hierarchy;
mod json;
mod labels;
pub mod obj;
mod obj_reader;
pub(in crate::mesh) mod textures;
pub(in crate::mesh) mod triangles;
pub(in crate::mesh) mod view;

#[cfg(test)]
pub(in crate::mesh) mod fixture;
#[cfg(test)]
mod obj_tests;
#[cfg(test)]
mod tests;

pub use error::ImportError;
pub use labels::parse_labels;

use super::scene::{Document, Scene};
use crate::contract::{Limits, MeshKind};

/// Read a mesh file of the given kind.
///
/// Faces come in face order: the default scene depth-first, each mesh at its first use, primitives
/// in order, triangles in index order, strips and fans expanded; OBJ in file order, polygons as
/// fans. Points and lines stay in the document and are not read.
pub fn import(bytes: &[u8], kind: MeshKind, limits: &Limits) -> Result<Scene, ImportError> {
    if bytes.len() as u64 > limits.upload_bytes {
        return Err(ImportError::TooLarge(format!(
            "the file has {} bytes and the limit is {}",
            bytes.len(),
            limits.upload_bytes
        )));
    }
    let scene = match kind {
        MeshKind::Glb => {
            let chunks = glb::split(bytes)?;
            let mut scene = import_gltf(chunks.json, chunks.bin, limits)?;
            if chunks.passed_over {
                let message = "what stands in the GLB behind its known chunks was left out";
                scene.warnings.push(("passed_over".to_owned(), message.to_owned()));
            }
            scene
        }
        MeshKind::Gltf => import_gltf(bytes, None, limits)?,
        MeshKind::Obj => {
            let (document, warnings) = obj_reader::read(bytes, limits)?;
            let primitives = document.primitives();
            Scene { document: Document::Obj(document), primitives, labels: None, warnings }
        }
    };
    if scene.face_count() == 0 {
        return Err(ImportError::invalid(
            "the file shows no triangles: there is nothing to unwrap; check that the default scene \
             holds a mesh",
        ));
    }
    Ok(scene)
}

fn import_gltf(text: &[u8], bin: Option<&[u8]>, limits: &Limits) -> Result<Scene, ImportError> {
    let mut json = json::parse(text, limits)?;
    extensions::check_required(&json)?;
    let buffers = buffers::decode(&mut json, bin)?;
    let shown = gltf::read(&json, &buffers, limits)?;
    Ok(Scene {
        document: Document::Gltf { json, buffers },
        primitives: shown.primitives,
        labels: shown.labels,
        warnings: shown.warnings,
    })
}
