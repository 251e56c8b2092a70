//! Where blobs are kept, as it is written: a path, or a URL.

use std::path::PathBuf;

use super::BlobError;

/// The directory that a path or a `file:` URL (RFC 8089) names.
pub(super) fn directory(place: &str) -> Result<PathBuf, BlobError> {
    let refuse = |why| Err(BlobError::Place { place: place.to_owned(), why });
    let Some((scheme, rest)) = place.split_once("://") else { return Ok(place.into()) };
    if !scheme.eq_ignore_ascii_case("file") {
        return refuse("so far only directories are supported: a path, or a URL as file:///PATH");
    }
    let path = rest.strip_prefix("localhost").unwrap_or(rest);
    if !path.starts_with('/') {
        return refuse("a file URL names a place on this host and begins with file:///");
    }
    match decoded(path) {
        Some(path) => Ok(path.into()),
        None => refuse("a % in a URL is followed by two hexadecimal digits, as in %20"),
    }
}

/// Undo the percent-encoding (RFC 3986, section 2.1).
fn decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || char::from(rest.next()?).to_digit(16);
        let (high, low) = (digit()?, digit()?);
        bytes.push(u8::try_from(high * 16 + low).ok()?);
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_file_urls_name_directories() {
        for (place, path) in [
            ("blobs", "blobs"),
            ("/var/lib/a b%20c", "/var/lib/a b%20c"),
            ("file:///var/lib/a%20b%C3%A9", "/var/lib/a bé"),
            ("file://localhost/var", "/var"),
        ] {
            assert_eq!(directory(place).unwrap(), PathBuf::from(path), "{place}");
        }
    }

    #[test]
    fn what_is_not_supported_is_refused_with_a_sentence() {
        for (place, why) in [
            ("s3://bucket/prefix", "only directories"),
            ("file://elsewhere/var", "on this host"),
            ("file:///var/%2", "hexadecimal"),
            ("file:///var/%zz", "hexadecimal"),
            ("file:///var/%ff", "hexadecimal"),
        ] {
            let refused = directory(place).unwrap_err().to_string();
            assert!(refused.contains(place) && refused.contains(why), "{refused}");
        }
    }
}
