//! What every handler is given.

use std::sync::Arc;

use axum::http::{HeaderValue, header};
use tokio_util::sync::CancellationToken;

use super::Problem;
use crate::contract::{ErrorCode, Limits};
use crate::jobs::{BlobError, Blobs, Changes, Job, JobId, QueueError, Submit};

/// The queue, the blobs, and the rules. Cheap to clone.
#[derive(Clone)]
pub struct AppState {
    /// Jobs and their events.
    pub queue: Arc<dyn Submit>,
    /// Uploads and artifacts.
    pub blobs: Blobs,
    /// Tells when a job may have changed.
    pub changes: Changes,
    /// What the service accepts.
    pub limits: Limits,
    /// Set when the service is to finish what it has begun and to take nothing new.
    pub draining: CancellationToken,
    /// Set when that is done: streams and waits end, and nobody is let in any more.
    pub closing: CancellationToken,
}

impl AppState {
    /// Refuse while the service drains.
    pub(super) fn takes_new_work(&self) -> Result<(), Problem> {
        if !self.draining.is_cancelled() {
            return Ok(());
        }
        let detail = "The service finishes what it has begun and then goes; try again in a moment";
        let problem = Problem::new(ErrorCode::Draining, detail);
        Err(problem.with_header(header::RETRY_AFTER, RETRY_AFTER))
    }

    /// The job that an address names.
    pub(super) async fn job(&self, id: &str) -> Result<Job, Problem> {
        let unknown = || Problem::not_found(format_args!("The job {id:?}"));
        let parsed: JobId = id.parse().map_err(|_| unknown())?;
        self.queue.get(parsed).await?.ok_or_else(unknown)
    }
}

/// Seconds after which a client may try again when the queue is full or the service goes.
const RETRY_AFTER: HeaderValue = HeaderValue::from_static("5");

impl From<QueueError> for Problem {
    fn from(error: QueueError) -> Self {
        match error {
            QueueError::Full { limit } => {
                let detail =
                    format!("{limit} jobs wait already, which is the limit; try again later");
                Self::new(ErrorCode::QueueQuotaExceeded, detail)
                    .with_header(header::RETRY_AFTER, RETRY_AFTER)
            }
            QueueError::Cursor => Self::malformed(
                "cursor: this is not the next_cursor of a page of this list; leave it away to start anew",
            ),
            QueueError::StorageFull => Self::new(ErrorCode::StorageFull, error.to_string()),
            error => Self::internal(error),
        }
    }
}

impl From<BlobError> for Problem {
    fn from(error: BlobError) -> Self {
        match error {
            BlobError::StorageFull => Self::new(ErrorCode::StorageFull, error.to_string()),
            error => Self::internal(error),
        }
    }
}
