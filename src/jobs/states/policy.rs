//! The rules that a queue keeps to: how long things last, and what is tried again.

use std::time::Duration;

use jiff::Timestamp;

use crate::contract::ErrorCode;

/// What a queue is to keep to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Policy {
    /// How long a lease lasts without being extended.
    pub lease: Duration,
    /// Attempts a job gets.
    pub max_attempts: u32,
    /// How long inputs and artifacts are kept once a job is over.
    pub retention: Duration,
}

impl Default for Policy {
    /// The usual values: leases of 30 s, 3 attempts, 7 days.
    fn default() -> Self {
        Self {
            lease: Duration::from_secs(30),
            max_attempts: 3,
            retention: Duration::from_secs(7 * 24 * 3600),
        }
    }
}

impl Policy {
    /// When a lease lapses that begins now.
    pub(super) fn lapses(&self, now: Timestamp) -> Timestamp {
        after(now, self.lease)
    }

    /// When the files of a job go that is over now.
    pub(super) fn expires(&self, now: Timestamp) -> Timestamp {
        after(now, self.retention)
    }
}

/// Whether another attempt may go better: the machine failed and not the input.
pub(super) fn is_transient(code: ErrorCode) -> bool {
    matches!(code, ErrorCode::DeviceLost | ErrorCode::WorkerCrashed)
}

/// The end of time where that would be beyond it.
fn after(now: Timestamp, duration: Duration) -> Timestamp {
    now.checked_add(duration).unwrap_or(Timestamp::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_retention_of_ages_ends_with_time() {
        let policy = Policy { retention: Duration::MAX, ..Policy::default() };
        assert_eq!(policy.expires(Timestamp::UNIX_EPOCH), Timestamp::MAX);
        let lapses = policy.lapses(Timestamp::UNIX_EPOCH);
        assert_eq!(lapses.as_second(), 30);
    }
}
