//! The queue as a worker needs it: it takes jobs under a lease, tells how they go, and ends them.

use async_trait::async_trait;

use super::{
    Job, JobId, JobProgress, JobState, MetricsSummary, NewEvent, QueueError, StoredArtifact, Worker,
};
use crate::contract::JobError;

/// What workers may do. Every method is one transaction. Every write to a job asks for the lease's
/// token, so a worker that was paused past its lease changes nothing.
#[async_trait]
pub trait Work: Send + Sync + 'static {
    /// Say that a worker is alive; call it at the start and every few seconds.
    async fn register(&self, worker: &Worker) -> Result<(), QueueError>;

    /// Say that a worker leaves: as [`Keep::worker_gone`](super::Keep::worker_gone), by itself.
    async fn leave(&self, worker: &str) -> Result<(), QueueError>;

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
