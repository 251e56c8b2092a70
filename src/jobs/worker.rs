//! A worker process, as it registered itself.

use std::time::Duration;

use jiff::Timestamp;
use serde::Serialize;
use utoipa::ToSchema;

/// A worker not seen for this long is not counted as alive.
pub const WORKER_ALIVE: Duration = Duration::from_secs(15);

/// A worker not seen for this long is forgotten.
pub(super) const WORKER_FORGOTTEN: Duration = Duration::from_secs(600);

/// A worker that registered itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Worker {
    /// Its id.
    pub id: String,
    /// Its process.
    pub pid: u32,
    /// The host it runs on.
    pub host: String,
    /// Name of the device it computes on.
    pub device: String,
    /// Version of the program it runs.
    pub engine: String,
    /// `sha256:…` of its segmentation weights; null where it has none or does not tell.
    #[schema(required)]
    pub weights: Option<String>,
    /// Threads that its pipeline computes with; 0 where it does not tell.
    pub threads: u32,
    /// Whether it takes no more jobs.
    pub draining: bool,
    /// When it was last seen alive.
    #[schema(value_type = String, format = DateTime)]
    pub last_seen: Timestamp,
}
