//! `Prefer: wait=N` (RFC 7240, section 4.3): how long an answer may be held back.

use std::time::Duration;

use axum::http::{HeaderMap, HeaderName};

/// The longest wait that is granted, in seconds. A longer wish is cut to it.
pub const MOST_SECONDS: u64 = 60;

/// The header.
pub const PREFER: HeaderName = HeaderName::from_static("prefer");

/// How long the client would wait; zero where it does not say or says it wrongly (a preference
/// that cannot be read is ignored, as the RFC asks).
pub fn wait(headers: &HeaderMap) -> Duration {
    let values = headers.get_all(PREFER);
    let preferences = values.iter().filter_map(|v| v.to_str().ok()).flat_map(|v| v.split(','));
    let mut seconds = preferences.filter_map(|preference| {
        let (name, value) = preference.split(';').next()?.split_once('=')?;
        let wait = name.trim().eq_ignore_ascii_case("wait");
        wait.then(|| value.trim().trim_matches('"').parse::<u64>().ok()).flatten()
    });
    Duration::from_secs(seconds.next().unwrap_or(0).min(MOST_SECONDS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wait_is_read_and_cut() {
        for (value, seconds) in [
            ("wait=5", 5),
            ("respond-async, wait=10", 10),
            ("WAIT = \"7\"; x=1", 7),
            ("wait=1000", MOST_SECONDS),
            ("wait=-1", 0),
            ("wait", 0),
            ("return=minimal", 0),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(PREFER, value.parse().unwrap());
            assert_eq!(wait(&headers), Duration::from_secs(seconds), "{value}");
        }
        assert_eq!(wait(&HeaderMap::new()), Duration::ZERO);
    }
}
