//! Reading meshes: any bytes in, a scene or a sentence about what is wrong with them out. Nothing
//! here panics, opens another file, or allocates what the file only declares.

mod error;
mod labels;

#[cfg(test)]
mod tests;

pub use error::ImportError;
pub use labels::parse_labels;

use super::formats;
use super::scene::Scene;
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
    let scene = formats::read(bytes, kind, limits)?;
    if scene.face_count() == 0 {
        return Err(ImportError::invalid(
            "the file shows no triangles: there is nothing to unwrap; check that the default scene \
             holds a mesh",
        ));
    }
    Ok(scene)
}
