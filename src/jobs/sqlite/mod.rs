//! The queue in one SQLite file, for one host: a writer pool of exactly one connection, so that
//! writes of this process queue up here and not in busy waits, and a pool of readers.

mod client;
mod disk;
mod events;
mod leases;
mod rows;
mod schema;
mod upkeep;
mod watch;
mod write;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use async_trait::async_trait;
use jiff::Timestamp;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteJournalMode, SqlitePool, SqlitePoolOptions, SqliteSynchronous,
};
use sqlx::{Sqlite, Transaction};

use crate::contract::JobError;

use super::states::Ending;
use super::{
    CancelOutcome, Changes, Claim, Deleted, Event, Handover, Job, JobId, JobState, Keep, Lease,
    ListFilter, NewEvent, NewJob, Page, Policy, QueueError, Stats, Submit, Swept, Tick, TickAnswer,
    Work, Worker,
};

/// How long a write waits for another process's write.
const BUSY: Duration = Duration::from_secs(20);

/// Connections that read.
const READERS: u32 = 4;

/// The queue in a SQLite file. Cheap to clone.
#[derive(Debug, Clone)]
pub struct SqliteQueue {
    writer: SqlitePool,
    reader: SqlitePool,
    file: PathBuf,
    policy: Policy,
}

impl SqliteQueue {
    /// Make the file if need be and bring its schema up to date; one process at a time. Only a
    /// server does this.
    pub async fn migrate(file: &Path) -> Result<(), QueueError> {
        schema::migrate(file).await
    }

    /// Open the queue. Waits up to `patience` for a server to bring the schema to exactly the
    /// version that this program knows, and refuses after that.
    pub async fn open(file: &Path, policy: Policy, patience: Duration) -> Result<Self, QueueError> {
        disk::refuse_network(file)?;
        schema::wait(file, patience).await?;
        let options = connect_options(file);
        let writer = SqlitePoolOptions::new().max_connections(1).min_connections(1);
        let reader = SqlitePoolOptions::new().max_connections(READERS);
        Ok(Self {
            writer: writer.connect_with(options.clone()).await?,
            reader: reader.connect_with(options.pragma("query_only", "ON")).await?,
            file: file.to_path_buf(),
            policy,
        })
    }

    /// Watch for commits.
    pub fn changes(&self) -> Changes {
        watch::watch(&self.file, connect_options(&self.file).pragma("query_only", "ON"))
    }

    /// A transaction that holds the write lock from its first statement, so that what it reads
    /// stays true until it commits.
    async fn begin(&self) -> Result<Transaction<'static, Sqlite>, QueueError> {
        Ok(self.writer.begin_with("BEGIN IMMEDIATE").await?)
    }

    /// A transaction that only reads: all its statements see the same state.
    async fn snapshot(&self) -> Result<Transaction<'static, Sqlite>, QueueError> {
        Ok(self.reader.begin().await?)
    }
}

fn connect_options(file: &Path) -> SqliteConnectOptions {
    SqliteConnectOptions::new()
        .filename(file)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(BUSY)
}

impl From<sqlx::Error> for QueueError {
    fn from(error: sqlx::Error) -> Self {
        // SQLITE_FULL: <https://sqlite.org/rescode.html#full>.
        let code = error.as_database_error().and_then(|error| error.code());
        if code.as_deref() == Some("13") {
            return QueueError::StorageFull;
        }
        QueueError::Database(Box::new(error))
    }
}

/// Now, to the microsecond, as times are stored.
fn now() -> Timestamp {
    Timestamp::from_microsecond(Timestamp::now().as_microsecond()).unwrap_or_default()
}

/// A time as it is stored; none is 0.
fn since_epoch(time: Option<Timestamp>) -> i64 {
    time.map_or(0, |time| time.as_microsecond())
}

/// The time so long ago, as it is stored.
fn ago(duration: Duration) -> i64 {
    now().checked_sub(duration).unwrap_or(Timestamp::MIN).as_microsecond()
}

#[async_trait]
impl Submit for SqliteQueue {
    async fn submit(&self, job: NewJob, limit: u64) -> Result<Job, QueueError> {
        client::submit(self, job, limit).await
    }

    async fn get(&self, id: JobId) -> Result<Option<Job>, QueueError> {
        rows::job(&mut *self.snapshot().await?, id).await
    }

    async fn list(&self, filter: &ListFilter) -> Result<Page, QueueError> {
        client::list(self, filter).await
    }

    async fn request_cancel(&self, id: JobId) -> Result<CancelOutcome, QueueError> {
        client::request_cancel(self, id).await
    }

    async fn delete(&self, id: JobId) -> Result<Deleted, QueueError> {
        client::delete(self, id).await
    }

    async fn events_after(
        &self,
        id: JobId,
        after: u64,
        limit: u32,
    ) -> Result<Vec<Event>, QueueError> {
        events::of_job(self, id, after, limit).await
    }

    async fn all_events_after(&self, after: i64, limit: u32) -> Result<Vec<Event>, QueueError> {
        events::of_all(self, after, limit).await
    }

    async fn last_event_id(&self) -> Result<i64, QueueError> {
        events::last_id(self).await
    }

    async fn stats(&self) -> Result<Stats, QueueError> {
        upkeep::stats(self).await
    }
}

#[async_trait]
impl Work for SqliteQueue {
    async fn register(&self, worker: &Worker) -> Result<(), QueueError> {
        upkeep::register(self, worker).await
    }

    async fn leave(&self, worker: &str) -> Result<(), QueueError> {
        upkeep::worker_gone(self, worker).await.map(|_| ())
    }

    async fn claim(&self, worker: &Worker) -> Result<Option<Claim>, QueueError> {
        leases::claim(self, worker).await
    }

    async fn tick(&self, lease: &Lease, tick: Tick) -> Result<TickAnswer, QueueError> {
        leases::tick(self, lease, tick).await
    }

    async fn finish(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError> {
        leases::end(self, lease, Ending::Succeeded, handover).await.map(|_| ())
    }

    async fn fail(
        &self,
        lease: &Lease,
        error: JobError,
        handover: Handover,
    ) -> Result<JobState, QueueError> {
        leases::end(self, lease, Ending::Failed(error), handover).await
    }

    async fn canceled(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError> {
        leases::end(self, lease, Ending::Canceled, handover).await.map(|_| ())
    }

    async fn release(&self, lease: &Lease, events: Vec<NewEvent>) -> Result<(), QueueError> {
        leases::release(self, lease, events).await
    }
}

#[async_trait]
impl Keep for SqliteQueue {
    async fn worker_gone(&self, worker: &str) -> Result<Swept, QueueError> {
        upkeep::worker_gone(self, worker).await
    }

    async fn sweep(&self) -> Result<Swept, QueueError> {
        upkeep::sweep(self).await
    }

    async fn workers_on(&self, host: &str) -> Result<Vec<Worker>, QueueError> {
        upkeep::workers_on(self, host).await
    }

    async fn expire(&self) -> Result<Vec<String>, QueueError> {
        upkeep::expire(self).await
    }

    async fn named(&self, blobs: &[String]) -> Result<BTreeSet<String>, QueueError> {
        upkeep::named(self, blobs).await
    }
}
