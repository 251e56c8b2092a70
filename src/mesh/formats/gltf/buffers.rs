//! The bytes behind a glTF document's buffers: the GLB's binary chunk or data URIs (RFC 2397).
//! Nothing outside the file is ever opened.

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use bytes::Bytes;
use serde_json::Value;

use crate::mesh::import::ImportError;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Decode every buffer. The URIs of the buffers are taken out of the document: from here on their
/// bytes stand in the result.
pub(super) fn decode(json: &mut Value, bin: Option<&[u8]>) -> Result<Vec<Bytes>, ImportError> {
    refuse_external_images(json)?;
    let list = match json.get_mut("buffers") {
        None => return Ok(Vec::new()),
        Some(Value::Array(list)) => list,
        Some(_) => return Err(ImportError::invalid("`buffers` must be an array")),
    };
    let bytes = |(i, buffer)| decode_one(i, buffer, bin).map(Bytes::from);
    list.iter_mut().enumerate().map(bytes).collect()
}

fn decode_one(i: usize, buffer: &mut Value, bin: Option<&[u8]>) -> Result<Vec<u8>, ImportError> {
    let Some(object) = buffer.as_object_mut() else {
        return Err(ImportError::invalid(format!("buffers[{i}] must be an object")));
    };
    let declared = object.get("byteLength").and_then(Value::as_u64).ok_or_else(|| {
        ImportError::invalid(format!("buffers[{i}].byteLength must be a whole number of bytes"))
    })?;
    let mut bytes = match object.shift_remove("uri") {
        Some(Value::String(uri)) => data_uri(&uri, &format!("buffers[{i}]"))?,
        Some(_) => {
            return Err(ImportError::invalid(format!("buffers[{i}].uri must be a string")));
        }
        None => match bin {
            // A chunk may be padded; what is behind byteLength is no part of the buffer.
            Some(bin) if i == 0 => {
                let most = usize::try_from(declared).unwrap_or(usize::MAX).min(bin.len());
                bin[..most].to_vec()
            }
            _ => {
                return Err(ImportError::invalid(format!(
                    "buffers[{i}] has neither a data URI nor the binary chunk of a GLB behind it"
                )));
            }
        },
    };
    if (bytes.len() as u64) < declared {
        return Err(ImportError::invalid(format!(
            "buffers[{i}] declares {declared} bytes and has {}: the file is truncated",
            bytes.len()
        )));
    }
    bytes.truncate(usize::try_from(declared).unwrap_or(usize::MAX));
    Ok(bytes)
}

/// Images are not needed to unwrap, but a result that points at files it left behind is no result.
fn refuse_external_images(json: &Value) -> Result<(), ImportError> {
    let images = json.get("images").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    for (i, image) in images.iter().enumerate() {
        match image.get("uri") {
            Some(Value::String(uri)) if !is_data_uri(uri) => {
                return Err(external(&format!("images[{i}]"), uri));
            }
            _ => {}
        }
    }
    Ok(())
}

fn is_data_uri(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

fn external(place: &str, uri: &str) -> ImportError {
    let shown: String = uri.chars().take(80).collect();
    ImportError::ExternalUri(format!(
        "{place} refers to the file {shown:?} beside it: pack everything into one GLB, or \
         embed it as a data URI"
    ))
}

/// The bytes of a data URI. `place` names it in errors.
fn data_uri(uri: &str, place: &str) -> Result<Vec<u8>, ImportError> {
    if !is_data_uri(uri) {
        return Err(external(place, uri));
    }
    let wrong = |why: String| ImportError::invalid(format!("the data URI of {place} {why}"));
    let (head, data) = uri.split_once(',').ok_or_else(|| wrong("has no comma".into()))?;
    let raw = percent_decode(data.as_bytes())
        .ok_or_else(|| wrong("has a % that no two hexadecimal digits follow".into()))?;
    if !head.to_ascii_lowercase().ends_with(";base64") {
        return Ok(raw);
    }
    BASE64.decode(&raw).map_err(|error| wrong(format!("is no base64: {error}")))
}

fn percent_decode(text: &[u8]) -> Option<Vec<u8>> {
    if !text.contains(&b'%') {
        return Some(text.to_vec());
    }
    let hex = |byte: Option<&u8>| char::from(*byte?).to_digit(16);
    let (mut out, mut at) = (Vec::with_capacity(text.len()), 0);
    while let Some(&byte) = text.get(at) {
        if byte == b'%' {
            out.push((hex(text.get(at + 1))? * 16 + hex(text.get(at + 2))?) as u8);
            at += 3;
        } else {
            out.push(byte);
            at += 1;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::ErrorCode;
    use serde_json::json;

    fn one(uri: &str) -> Result<Vec<u8>, ImportError> {
        data_uri(uri, "buffers[0]")
    }

    #[test]
    fn data_uris_decode_with_or_without_padding_and_percent() {
        assert_eq!(one("data:application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(one("data:;base64,AAECAw==").unwrap(), [0, 1, 2, 3]);
        assert_eq!(one("DATA:;base64,AAECAw").unwrap(), [0, 1, 2, 3]);
        assert_eq!(one("data:;base64,AAECAw%3D%3d").unwrap(), [0, 1, 2, 3]);
        assert_eq!(one("data:,a%FFb").unwrap(), [b'a', 0xFF, b'b']);
    }

    #[test]
    fn broken_uris_are_told_and_never_panic() {
        for uri in ["data:", "data:;base64,%", "data:;base64,%F", "data:;base64,*", "data:,%é0"] {
            assert_eq!(one(uri).unwrap_err().code(), ErrorCode::InvalidMesh, "{uri}");
        }
        for uri in
            ["%FF", "", "é", "chair.bin", "https://example.org/a.bin", "/etc/passwd", "dataé:"]
        {
            assert_eq!(one(uri).unwrap_err().code(), ErrorCode::ExternalUriForbidden, "{uri}");
        }
    }

    #[test]
    fn a_buffer_must_hold_what_it_declares() {
        let mut json =
            json!({"buffers": [{"byteLength": 4}, {"byteLength": 2, "uri": "data:,abc"}]});
        assert_eq!(decode(&mut json, Some(b"12345678")).unwrap(), [&b"1234"[..], b"ab"]);
        assert!(json["buffers"][1].get("uri").is_none());
        let mut json = json!({"buffers": [{"byteLength": 1u64 << 62}]});
        assert!(decode(&mut json, Some(b"1234")).is_err());
        let mut json = json!({"images": [{"uri": "wood.png"}]});
        assert_eq!(decode(&mut json, None).unwrap_err().code(), ErrorCode::ExternalUriForbidden);
    }
}
