//! Where jobs are kept: the only place that knows which database and which host stand behind the
//! traits. Servers and workers take what they need from here.

use std::sync::Arc;
use std::time::Duration;

use super::{
    BlobError, Blobs, Changes, LockFiles, Policy, Presence, Queue, QueueError, SqliteQueue,
};
use crate::config::DataDir;

/// How long a server waits for the schema that it brought up to date itself.
const AT_ONCE: Duration = Duration::from_secs(5);

/// What to do about the schema of the database.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Schema {
    /// Bring it up to date: what a server does, and nobody else.
    Migrate,
    /// Wait so long until a server has done so.
    Await(Duration),
}

/// Everything that a server or a worker holds of the jobs.
#[derive(Clone)]
pub struct Kept {
    /// The queue.
    pub queue: Arc<dyn Queue>,
    /// Tells of commits.
    pub changes: Changes,
    /// Which workers of this host live.
    pub presence: Arc<dyn Presence>,
    /// Inputs and artifacts.
    pub blobs: Blobs,
}

/// Why jobs cannot be kept there.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The queue cannot be used.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// The blobs cannot be used.
    #[error(transparent)]
    Blobs(#[from] BlobError),
}

/// Open what is kept in this place.
pub async fn open(data: &DataDir, policy: Policy, schema: Schema) -> Result<Kept, OpenError> {
    let database = data.database();
    let patience = match schema {
        Schema::Migrate => {
            SqliteQueue::migrate(&database).await?;
            AT_ONCE
        }
        Schema::Await(patience) => patience,
    };
    let queue = SqliteQueue::open(&database, policy, patience).await?;
    let blobs = match &data.blobs {
        Some(place) => Blobs::open(place).await?,
        None => Blobs::local(&data.root.join("blobs")).await?,
    };
    Ok(Kept {
        changes: queue.changes(),
        queue: Arc::new(queue),
        presence: Arc::new(LockFiles::new(data.workers())),
        blobs,
    })
}
