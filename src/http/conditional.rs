//! Entity tags and byte ranges: RFC 9110, sections 8.8.3, 13 and 14
//! (<https://www.rfc-editor.org/rfc/rfc9110>).

use axum::http::{HeaderMap, HeaderValue, header};
use sha2::{Digest, Sha256};

/// A strong entity tag: the SHA-256 of the bytes, in quotes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ETag(String);

impl ETag {
    /// The tag of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        let hex: String = Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
        Self::of_sha256(&hex)
    }

    /// The tag of bytes whose SHA-256 is known, in hexadecimal digits.
    pub fn of_sha256(hex: &str) -> Self {
        Self(format!("\"{hex}\""))
    }

    /// As the value of the header `ETag`.
    pub fn value(&self) -> HeaderValue {
        HeaderValue::from_str(&self.0).unwrap_or(HeaderValue::from_static("\"\""))
    }

    /// Whether `If-None-Match` names this tag, so that the client has these bytes already. Weak
    /// comparison, as the RFC asks.
    pub fn is_known(&self, headers: &HeaderMap) -> bool {
        let values = headers.get_all(header::IF_NONE_MATCH);
        let tags = values.iter().filter_map(|v| v.to_str().ok()).flat_map(|v| v.split(','));
        tags.map(str::trim).any(|tag| tag == "*" || tag.trim_start_matches("W/") == self.0)
    }

    /// Whether a range of these bytes may be sent: `If-Range` is absent or names this very tag.
    pub fn allows_range(&self, headers: &HeaderMap) -> bool {
        headers.get(header::IF_RANGE).is_none_or(|v| v.as_bytes() == self.0.as_bytes())
    }
}

/// What the header `Range` asks of a body of known length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Range {
    /// All of it: there is no range, or one that we do not take (another unit, several ranges, bad
    /// syntax), which the RFC lets a server ignore.
    Whole,
    /// These bytes: a range that is not empty and lies inside the body.
    Part(std::ops::Range<u64>),
    /// Bytes that are not there: 416.
    Outside,
}

impl Range {
    /// Read the header for a body of `length` bytes.
    pub fn of(headers: &HeaderMap, length: u64) -> Self {
        let text = headers.get(header::RANGE).and_then(|v| v.to_str().ok()).unwrap_or_default();
        Self::parse(text, length).unwrap_or(Self::Whole)
    }

    fn parse(text: &str, length: u64) -> Option<Self> {
        let (unit, range) = text.split_once('=')?;
        let (first, last) = range.trim().split_once('-')?;
        if !unit.trim().eq_ignore_ascii_case("bytes") {
            return None;
        }
        // Digits that do not fit 64 bits still are a position: one past every end.
        let number = |s: &str| {
            let digits = !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
            digits.then(|| s.parse().unwrap_or(u64::MAX))
        };
        let range = if first.is_empty() {
            length.saturating_sub(number(last)?)..length
        } else {
            let start = number(first)?;
            let last = if last.is_empty() { u64::MAX } else { number(last)? };
            if last < start {
                return None;
            }
            start..last.saturating_add(1).min(length)
        };
        Some(if range.start < range.end { Self::Part(range) } else { Self::Outside })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ranges_as_the_rfc_has_them() {
        for (text, want) in [
            ("bytes=0-0", Range::Part(0..1)),
            ("bytes=2-5", Range::Part(2..6)),
            ("bytes=7-", Range::Part(7..10)),
            ("bytes=-3", Range::Part(7..10)),
            ("bytes=-30", Range::Part(0..10)),
            ("bytes=8-99999999999999999999999", Range::Part(8..10)),
            ("bytes=10-", Range::Outside),
            ("bytes=99999999999999999999999-", Range::Outside),
            ("bytes=-0", Range::Outside),
            ("bytes=5-2", Range::Whole),
            ("bytes=-", Range::Whole),
            ("bytes=0-1,3-4", Range::Whole),
            ("lines=0-1", Range::Whole),
            ("bytes=+1-2", Range::Whole),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(header::RANGE, text.parse().unwrap());
            assert_eq!(Range::of(&headers, 10), want, "{text}");
        }
        assert_eq!(Range::of(&HeaderMap::new(), 10), Range::Whole);
    }

    #[test]
    fn tags_match_weakly_for_none_match_and_strongly_for_range() {
        let tag = ETag::of(b"abc");
        let with = |name, value: String| {
            HeaderMap::from_iter([(name, HeaderValue::from_str(&value).unwrap())])
        };
        assert!(tag.is_known(&with(header::IF_NONE_MATCH, format!("\"x\", W/{}", tag.0))));
        assert!(tag.is_known(&with(header::IF_NONE_MATCH, "*".into())));
        assert!(!tag.is_known(&with(header::IF_NONE_MATCH, "\"x\"".into())));
        assert!(!tag.is_known(&HeaderMap::new()));
        assert!(tag.allows_range(&with(header::IF_RANGE, tag.0.clone())));
        assert!(!tag.allows_range(&with(header::IF_RANGE, format!("W/{}", tag.0))));
        assert!(tag.allows_range(&HeaderMap::new()));
    }

    proptest! {
        /// No header makes a range that is empty or leaves the body.
        #[test]
        fn parts_lie_inside(text in "bytes=[0-9]{0,21}-[0-9]{0,21}", length in 0u64..1000) {
            let headers = HeaderMap::from_iter([(header::RANGE, HeaderValue::from_str(&text).unwrap())]);
            if let Range::Part(range) = Range::of(&headers, length) {
                prop_assert!(range.start < range.end && range.end <= length);
            }
        }
    }
}
