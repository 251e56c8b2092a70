//! The queue as a whole, and what can go wrong with it.

use super::{Keep, Submit, Work};

/// What the API, the workers and the housekeeping need together: a store implements the three, and
/// each of them is given its own. Cheap to share: `Arc<dyn Queue>`.
pub trait Queue: Submit + Work + Keep {}

impl<T: Submit + Work + Keep> Queue for T {}

/// What can go wrong between us and the database.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// As many jobs wait as may.
    #[error("{limit} jobs wait already, which is the limit")]
    Full {
        /// The limit.
        limit: u64,
    },
    /// The lease lapsed or the job is over: whoever held it may not write any more.
    #[error("the lease on this job is lost")]
    LeaseLost,
    /// The database has another schema than this program.
    #[error("{0}")]
    Schema(String),
    /// A page cursor that this queue did not make.
    #[error("this cursor was not made by this list")]
    Cursor,
    /// The disk is full.
    #[error("no room is left to store this")]
    StorageFull,
    /// A row that this program cannot read.
    #[error("row of {what}: {why}")]
    Row {
        /// Which row.
        what: String,
        /// What is wrong with it.
        why: String,
    },
    /// Anything else.
    #[error("database: {0}")]
    Database(#[source] Box<dyn std::error::Error + Send + Sync>),
}
