//! The queue as the API and the workers see it. Every method is one transaction: it happens whole
//! or not at all, and what it returned survives a power loss.

use std::collections::BTreeSet;
use std::time::Duration;

use async_trait::async_trait;
use jiff::Timestamp;
use serde::Serialize;
use utoipa::ToSchema;

use crate::contract::JobError;

use super::{
    Event, Job, JobId, JobProgress, JobState, MetricsSummary, NewEvent, NewJob, StoredArtifact,
};

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

/// The right to write to a running job. Whoever holds the job's latest token holds the lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    /// The job.
    pub job: JobId,
    /// Drawn at the claim; no other claim has it.
    pub token: String,
}

/// A job that a worker took.
#[derive(Debug, Clone)]
pub struct Claim {
    /// The job, already `running`.
    pub job: Job,
    /// The right to write to it.
    pub lease: Lease,
}

/// What a worker tells twice a second while it runs a job.
#[derive(Debug, Clone, Default)]
pub struct Tick {
    /// Events not yet written, oldest first.
    pub events: Vec<NewEvent>,
    /// How far the job is, if that changed.
    pub progress: Option<JobProgress>,
    /// Whether the lease is to run anew for its full length.
    pub extend: bool,
}

/// What a tick answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TickAnswer {
    /// Go on.
    Continue,
    /// Somebody asked for the job to stop.
    Cancel,
    /// Somebody else may hold the job by now: stop, and write nothing.
    LeaseLost,
}

/// What a worker hands in with the end of an attempt: last events, the files it wrote.
#[derive(Debug, Clone, Default)]
pub struct Handover {
    /// Events not yet written, oldest first.
    pub events: Vec<NewEvent>,
    /// How far the job came.
    pub progress: Option<JobProgress>,
    /// Files whose blobs are in place.
    pub artifacts: Vec<StoredArtifact>,
    /// Figures of the result.
    pub metrics: Option<MetricsSummary>,
}

/// Which jobs to list, newest first.
#[derive(Debug, Clone, Default)]
pub struct ListFilter {
    /// Only jobs in this state.
    pub state: Option<JobState>,
    /// Only jobs with exactly this tag.
    pub tag: Option<String>,
    /// At most this many, 1 to 100; 0 means 20.
    pub limit: u32,
    /// Where the page before ended: its [`Page::next_cursor`].
    pub cursor: Option<String>,
}

/// One page of a list.
#[derive(Debug, Clone)]
pub struct Page {
    /// The jobs, newest first.
    pub jobs: Vec<Job>,
    /// Where the next page begins; `None` on the last.
    pub next_cursor: Option<String>,
}

/// What a request to cancel met.
#[derive(Debug, Clone)]
pub enum CancelOutcome {
    /// There is no such job.
    NotFound,
    /// The job runs and was told to stop (now or before).
    Requested(Job),
    /// The job is over: it waited and is canceled now, or it was over before.
    Over(Job),
}

/// What a request to delete met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Deleted {
    /// There is no such job.
    NotFound,
    /// The job is not over.
    NotTerminal,
    /// The rows are gone. Nothing names these blobs any more: delete them.
    Deleted {
        /// Names of blobs.
        blobs: Vec<String>,
    },
}

/// What a sweep did to jobs whose worker is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Swept {
    /// Jobs that wait again.
    pub requeued: u64,
    /// Jobs that failed, for it was their last attempt.
    pub failed: u64,
    /// Jobs that were canceled, for somebody had asked for that.
    pub canceled: u64,
}

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
    /// Whether it takes no more jobs.
    pub draining: bool,
    /// When it was last seen alive.
    #[schema(value_type = String, format = DateTime)]
    pub last_seen: Timestamp,
}

/// How busy the service is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Stats {
    /// Jobs that wait.
    pub queued: u64,
    /// Jobs that run.
    pub running: u64,
    /// Workers seen within [`WORKER_ALIVE`], by id.
    pub workers: Vec<Worker>,
}

impl Stats {
    /// How many workers can take a job.
    pub fn workers_ready(&self) -> usize {
        self.workers.iter().filter(|worker| !worker.draining).count()
    }
}

/// The queue. Cheap to share: `Arc<dyn Queue>`.
#[async_trait]
pub trait Queue: Send + Sync + 'static {
    /// Queue a job, unless `limit` jobs wait already ([`QueueError::Full`]).
    async fn submit(&self, job: NewJob, limit: u64) -> Result<Job, QueueError>;

    /// A job, or `None` where there is none with this id.
    async fn get(&self, id: JobId) -> Result<Option<Job>, QueueError>;

    /// A page of jobs, newest first. Jobs that come or go between two pages shift nothing.
    async fn list(&self, filter: &ListFilter) -> Result<Page, QueueError>;

    /// Ask a job to stop. One that waits is `canceled` at once. Idempotent.
    async fn request_cancel(&self, id: JobId) -> Result<CancelOutcome, QueueError>;

    /// Forget a job that is over, with its events.
    async fn delete(&self, id: JobId) -> Result<Deleted, QueueError>;

    /// Events of a job with `seq > after`, oldest first, at most `limit`.
    async fn events_after(
        &self,
        id: JobId,
        after: u64,
        limit: u32,
    ) -> Result<Vec<Event>, QueueError>;

    /// Events of all jobs with `event_id > after`, oldest first, at most `limit`.
    async fn all_events_after(&self, after: i64, limit: u32) -> Result<Vec<Event>, QueueError>;

    /// The greatest `event_id` so far; 0 before the first.
    async fn last_event_id(&self) -> Result<i64, QueueError>;

    /// Queue length and workers, in one look: for `/readyz` and `/v1/info`.
    async fn stats(&self) -> Result<Stats, QueueError>;

    /// Say that a worker is alive; call it at the start and every few seconds.
    async fn register(&self, worker: &Worker) -> Result<(), QueueError>;

    /// Say that a worker is gone: forget it, and take its jobs back as after a crash.
    async fn worker_gone(&self, worker: &str) -> Result<Swept, QueueError>;

    /// Take the next job: by priority, then by age. `None` where none waits. Takes lapsed leases
    /// back first. The attempt is counted here.
    async fn claim(&self, worker: &Worker) -> Result<Option<Claim>, QueueError>;

    /// Write what happened and learn whether to go on.
    async fn tick(&self, lease: &Lease, tick: Tick) -> Result<TickAnswer, QueueError>;

    /// The job succeeded.
    async fn finish(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError>;

    /// The attempt failed. An error of the machine (`device_lost`, `worker_crashed`) sends the job back
    /// while attempts are left (`Ok(JobState::Queued)`); any other ends it (`Ok(JobState::Failed)`).
    async fn fail(
        &self,
        lease: &Lease,
        error: JobError,
        handover: Handover,
    ) -> Result<JobState, QueueError>;

    /// The job stopped because somebody asked for that.
    async fn canceled(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError>;

    /// The worker shuts down: hand the job back without spending an attempt. A job that somebody
    /// asked to cancel is `canceled` instead.
    async fn release(&self, lease: &Lease, events: Vec<NewEvent>) -> Result<(), QueueError>;

    /// Take lapsed leases back. A crash counts as an attempt; after the last one the job fails with
    /// `worker_crashed`.
    async fn sweep(&self) -> Result<Swept, QueueError>;

    /// Workers that registered on `host`, seen lately or not: whoever can tell that one of them is
    /// dead says so with [`Queue::worker_gone`].
    async fn workers_on(&self, host: &str) -> Result<Vec<Worker>, QueueError>;

    /// Mark jobs whose retention is over as expired and return the blobs that may go.
    async fn expire(&self) -> Result<Vec<String>, QueueError>;

    /// Which of these blobs are named by a job that has not expired.
    async fn named(&self, blobs: &[String]) -> Result<BTreeSet<String>, QueueError>;
}

/// A worker not seen for this long is not counted as alive.
pub const WORKER_ALIVE: Duration = Duration::from_secs(15);
