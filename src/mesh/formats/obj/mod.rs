//! Wavefront OBJ: the checked reader; it is written as a fresh glTF document.

mod document;
mod read;
mod write;

#[cfg(test)]
mod tests;

pub use document::{ABSENT, ObjCorner, ObjDocument, ObjRun};
pub(super) use write::document as write;

use crate::contract::Limits;
use crate::mesh::import::ImportError;
use crate::mesh::scene::{Document, Scene};

/// Read an OBJ file.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Scene, ImportError> {
    let (document, warnings) = read::read(bytes, limits)?;
    let primitives = document.primitives();
    Ok(Scene { document: Document::Obj(document), primitives, labels: None, warnings })
}
