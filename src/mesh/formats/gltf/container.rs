//! The GLB container (glTF 2.0 specification, section 4.4): a header of 12 bytes, then chunks;
//! taken apart and put together.

use serde_json::Value;

use crate::mesh::export::ExportError;
use crate::mesh::import::ImportError;

const HEADER: u64 = 12;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The chunks of a GLB file.
pub(super) struct Chunks<'a> {
    /// The JSON text.
    pub json: &'a [u8],
    /// The binary chunk.
    pub bin: Option<&'a [u8]>,
    /// Whether chunks of unknown types or bytes behind the end were passed over.
    pub passed_over: bool,
}

/// Take a GLB file apart.
pub(super) fn split(bytes: &[u8]) -> Result<Chunks<'_>, ImportError> {
    let word = |at: u64| u32_at(bytes, at);
    let (Some(magic), Some(version), Some(length)) = (word(0), word(4), word(8)) else {
        return Err(ImportError::invalid(format!(
            "the GLB header needs 12 bytes and the file has {}: it is truncated, take a whole copy",
            bytes.len()
        )));
    };
    if magic.to_le_bytes() != *b"glTF" {
        return Err(ImportError::invalid("the file does not start with the GLB magic \"glTF\""));
    }
    if version != 2 {
        return Err(ImportError::invalid(format!(
            "the GLB header says version {version} and only version 2 is read: export it as glTF 2.0"
        )));
    }
    let (length, held) = (u64::from(length), bytes.len() as u64);
    if length > held || length < HEADER {
        return Err(ImportError::invalid(format!(
            "the GLB header says {length} bytes and the file has {held}: it is truncated, take a whole copy"
        )));
    }
    let (mut json, mut bin, mut passed_over) = (None, None, length < held);
    let (mut at, mut number) = (HEADER, 0u32);
    while at < length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(truncated(number, at));
        };
        let (start, end) = (at + 8, at + 8 + u64::from(size));
        if end > length {
            return Err(truncated(number, at));
        }
        let chunk = bytes.get(start as usize..end as usize).ok_or_else(|| truncated(number, at))?;
        match (number, kind) {
            (0, JSON) => json = Some(chunk),
            (1, BIN) => bin = Some(chunk),
            (0, _) => {
                return Err(ImportError::invalid("the first chunk of the GLB file is not JSON"));
            }
            (_, JSON | BIN) => {
                return Err(ImportError::invalid(format!(
                    "chunk {number} of the GLB file is out of order: JSON stands first, BIN second, each once"
                )));
            }
            _ => passed_over = true,
        }
        number += 1;
        at = end;
    }
    let json = json.ok_or_else(|| ImportError::invalid("the GLB file has no JSON chunk"))?;
    Ok(Chunks { json, bin, passed_over })
}

fn truncated(number: u32, at: u64) -> ImportError {
    ImportError::invalid(format!(
        "chunk {number} of the GLB file, at byte {at}, runs past the end: it is truncated, take a whole copy"
    ))
}

fn u32_at(bytes: &[u8], at: u64) -> Option<u32> {
    let at = usize::try_from(at).ok()?;
    let word = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(word.try_into().ok()?))
}

/// A document and its binary chunk as one file.
pub(in crate::mesh) fn join(json: &Value, bin: &[u8]) -> Result<Vec<u8>, ExportError> {
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
