//! The queue as the API needs it: jobs come in, are looked at, canceled and deleted, and their events
//! are read.

use async_trait::async_trait;

use super::{Event, Job, JobId, JobState, NewJob, QueueError, Worker};

/// What clients may do. Every method is one transaction: it happens whole or not at all, and what it
/// returned survives whatever the store promises to survive.
#[async_trait]
pub trait Submit: Send + Sync + 'static {
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

impl ListFilter {
    /// Jobs on a page if nobody says how many, and at most.
    const PAGE: (u32, u32) = (20, 100);

    /// How many jobs a page has at most.
    pub fn page(&self) -> u32 {
        if self.limit == 0 { Self::PAGE.0 } else { self.limit.min(Self::PAGE.1) }
    }

    /// The job that the page before ended with. Ids sort by age, so its id says where the next page
    /// begins.
    pub fn after(&self) -> Result<Option<JobId>, QueueError> {
        let cursor = self.cursor.as_ref().map(|cursor| cursor.parse());
        cursor.transpose().map_err(|_| QueueError::Cursor)
    }
}

/// One page of a list.
#[derive(Debug, Clone)]
pub struct Page {
    /// The jobs, newest first.
    pub jobs: Vec<Job>,
    /// Where the next page begins; `None` on the last.
    pub next_cursor: Option<String>,
}

impl Page {
    /// The page of a filter, from the jobs that it finds and one more if there are more.
    pub fn of(filter: &ListFilter, mut jobs: Vec<Job>) -> Self {
        let most = filter.page() as usize;
        let more = jobs.len() > most;
        jobs.truncate(most);
        let next_cursor = jobs.last().filter(|_| more).map(|job| job.id.to_string());
        Self { jobs, next_cursor }
    }
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
