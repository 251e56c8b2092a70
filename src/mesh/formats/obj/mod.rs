//! Wavefront OBJ: the checked reader. A result is written as a fresh glTF document.

mod document;
mod read;

#[cfg(test)]
mod tests;

use crate::contract::Limits;
use crate::mesh::import::ImportError;
use crate::mesh::scene::Scene;

/// Read an OBJ file.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Scene, ImportError> {
    let (document, warnings) = read::read(bytes, limits)?;
    Ok(Scene { warnings, ..document.into_scene() })
}
