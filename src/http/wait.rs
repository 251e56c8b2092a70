//! Waiting for a job to change: the long poll behind `Prefer: wait`.

use std::time::Duration;

use tokio::time::Instant;

use super::AppState;
use crate::jobs::{Job, JobId, QueueError};

/// Look at a job until `enough`, or until `patience` is over or the service closes. The last look is
/// returned; `None` where there is no such job (any more).
pub async fn until(
    state: &AppState,
    id: JobId,
    patience: Duration,
    enough: impl Fn(&Job) -> bool,
) -> Result<Option<Job>, QueueError> {
    let mut changes = state.changes.clone();
    let end = Instant::now() + patience;
    loop {
        let Some(job) = state.queue.get(id).await? else { return Ok(None) };
        let left = end.saturating_duration_since(Instant::now());
        if enough(&job) || left.is_zero() || state.closing.is_cancelled() {
            return Ok(Some(job));
        }
        tokio::select! {
            () = changes.changed_within(left) => {}
            () = state.closing.cancelled() => {}
        }
    }
}
