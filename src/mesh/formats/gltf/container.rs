//! The GLB container (glTF 2.0 specification, section 4.4).

use serde_json::Value;

use crate::mesh::export::ExportError;

/// A document and its binary chunk as one file.
pub(in crate::mesh) fn glb(json: &Value, bin: &[u8]) -> Result<Vec<u8>, ExportError> {
    let text = json.to_string();
    let text_size = text.len().next_multiple_of(4);
    let bin_size = bin.len().next_multiple_of(4);
    let total = 12 + 8 + text_size as u64 + 8 + bin_size as u64;
    let length = u32::try_from(total).map_err(|_| ExportError::TooLarge(total))?;
    let mut out = Vec::with_capacity(total as usize);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length.to_le_bytes());
    out.extend_from_slice(&(text_size as u32).to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(text.as_bytes());
    out.resize(20 + text_size, b' ');
    out.extend_from_slice(&(bin_size as u32).to_le_bytes());
    out.extend_from_slice(b"BIN\0");
    out.extend_from_slice(bin);
    out.resize(total as usize, 0);
    Ok(out)
}
