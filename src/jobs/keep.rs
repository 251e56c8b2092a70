//! The queue as whoever keeps house needs it: workers die, leases lapse, files expire.

use std::collections::BTreeSet;
use std::ops::AddAssign;

use async_trait::async_trait;

use super::{QueueError, Worker};

/// What housekeeping and supervision may do. Every method is one transaction.
#[async_trait]
pub trait Keep: Send + Sync + 'static {
    /// Take lapsed leases back. A crash counts as an attempt; after the last one the job fails with
    /// `worker_crashed`.
    async fn sweep(&self) -> Result<Swept, QueueError>;

    /// Say that a worker is gone: forget it, and take its jobs back as after a crash.
    async fn worker_gone(&self, worker: &str) -> Result<Swept, QueueError>;

    /// Workers that registered on `host`, seen lately or not: whoever can tell that one of them is
    /// dead says so with [`Keep::worker_gone`].
    async fn workers_on(&self, host: &str) -> Result<Vec<Worker>, QueueError>;

    /// Mark jobs whose retention is over as expired and return the blobs that may go.
    async fn expire(&self) -> Result<Vec<String>, QueueError>;

    /// Which of these blobs are named by a job that has not expired.
    async fn named(&self, blobs: &[String]) -> Result<BTreeSet<String>, QueueError>;
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

impl AddAssign for Swept {
    fn add_assign(&mut self, more: Swept) {
        self.requeued += more.requeued;
        self.failed += more.failed;
        self.canceled += more.canceled;
    }
}
