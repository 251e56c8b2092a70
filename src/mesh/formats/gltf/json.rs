//! The JSON of a glTF document: parsed whole, with the order of its keys, under a limit that does
//! not count embedded data.

use serde_json::Value;

use crate::contract::Limits;
use crate::mesh::import::ImportError;

/// Parse the JSON text of a document.
pub(super) fn parse(text: &[u8], limits: &Limits) -> Result<Value, ImportError> {
    let size = bytes_without_data(text);
    if size > limits.json_bytes {
        return Err(ImportError::TooLarge(format!(
            "the JSON of the file has {size} bytes, without embedded data, and the limit is {}",
            limits.json_bytes
        )));
    }
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let json: Value = serde_json::from_slice(text)
        .map_err(|error| ImportError::invalid(format!("the JSON cannot be read: {error}")))?;
    if !json.is_object() {
        return Err(ImportError::invalid("the JSON must be an object"));
    }
    match json.pointer("/asset/version").and_then(Value::as_str) {
        Some(version) if version.starts_with("2.") => Ok(json),
        Some(version) => Err(ImportError::invalid(format!(
            "asset.version is {version:?} and only 2.x is read: export it as glTF 2.0"
        ))),
        None => Err(ImportError::invalid("asset.version is missing: it must be \"2.0\"")),
    }
}

/// Bytes of the text that are no data URI: those cost what they weigh, while any other few bytes
/// may become a value.
fn bytes_without_data(text: &[u8]) -> u64 {
    let (mut at, mut data) = (0, 0u64);
    while let Some(open) = text[at..].iter().position(|&b| b == b'"').map(|i| at + i + 1) {
        let mut end = open;
        while let Some(i) = text[end..].iter().position(|&b| b == b'"' || b == b'\\') {
            end += i;
            if text[end] == b'"' {
                break;
            }
            end = (end + 2).min(text.len());
        }
        if text[end.min(text.len())..].first() != Some(&b'"') {
            break;
        }
        if text[open..end].starts_with(b"data:") {
            data += (end - open) as u64;
        }
        at = end + 1;
    }
    text.len() as u64 - data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn embedded_data_does_not_count() {
        assert_eq!(bytes_without_data(br#"{"uri":"data:;base64,AAAA"}"#), 10);
        assert_eq!(bytes_without_data(br#"{"a\"data:":"data:x"}"#), 15);
        assert_eq!(bytes_without_data(br#"{"a":"no data:"}"#), 16);
        assert_eq!(bytes_without_data(br#"{"a":"data:"#), 11);
        assert_eq!(bytes_without_data(br#"{"a\"#), 4);
        assert_eq!(bytes_without_data(b""), 0);
    }

    #[test]
    fn only_gltf_2_is_read() {
        let limits = Limits { json_bytes: 64, ..Limits::default() };
        assert!(parse(br#"{"asset":{"version":"2.0"}}"#, &limits).is_ok());
        for text in ["{}", "[]", "{", "", r#"{"asset":{"version":"1.0"}}"#, r#"{"asset":2}"#] {
            assert!(matches!(parse(text.as_bytes(), &limits), Err(ImportError::Invalid(_))));
        }
        assert!(matches!(parse(&[b' '; 65], &limits), Err(ImportError::TooLarge(_))));
        let deep = "[".repeat(60);
        assert!(parse(deep.as_bytes(), &limits).is_err());
    }
}
