//! How a job stands: what of its row changes while it goes its way. What its client gave does not,
//! and stands in a [`NewJob`].

use jiff::Timestamp;

use crate::contract::JobError;
use crate::jobs::{Job, JobProgress, JobState, MetricsSummary, NewJob, StoredArtifact, Versions};

/// How a job stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Where it stands.
    pub state: JobState,
    /// Attempts that were begun, the running one included.
    pub attempt: u32,
    /// After this many attempts that ended in a crash the job fails.
    pub max_attempts: u32,
    /// Whether somebody asked a running job to stop.
    pub cancel_requested: bool,
    /// Who runs it; `Some` as long as it is running.
    pub held: Option<Held>,
    /// How far it is, or came.
    pub progress: Option<JobProgress>,
    /// Versions of what ran it last.
    pub versions: Versions,
    /// Device that it ran on last.
    pub device: Option<String>,
    /// Figures of a job that succeeded.
    pub metrics: Option<MetricsSummary>,
    /// Why a job failed.
    pub error: Option<JobError>,
    /// When it was queued.
    pub created_at: Timestamp,
    /// When its latest attempt began.
    pub started_at: Option<Timestamp>,
    /// When it was over.
    pub finished_at: Option<Timestamp>,
    /// When its files go.
    pub expires_at: Option<Timestamp>,
    /// Whether they may be gone.
    pub expired: bool,
    /// Number of its latest event.
    pub last_seq: u64,
    /// Grows with every change that a reader can see.
    pub revision: u64,
}

/// A lease.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Held {
    /// The worker that holds it.
    pub worker: String,
    /// Known to nobody but its holder.
    pub token: String,
    /// When it lapses.
    pub until: Timestamp,
}

impl Standing {
    /// A job that waits for its first attempt.
    pub fn waiting(max_attempts: u32, now: Timestamp) -> Self {
        Self {
            state: JobState::Queued,
            attempt: 0,
            max_attempts,
            cancel_requested: false,
            held: None,
            progress: None,
            versions: Versions::default(),
            device: None,
            metrics: None,
            error: None,
            created_at: now,
            started_at: None,
            finished_at: None,
            expires_at: None,
            expired: false,
            last_seq: 0,
            revision: 1,
        }
    }

    /// The job as readers see it, at this moment and from this place in the queue.
    pub fn job(
        self,
        given: NewJob,
        artifacts: Vec<StoredArtifact>,
        queue_position: u64,
        now: Timestamp,
    ) -> Job {
        Job {
            id: given.id,
            state: self.state,
            tag: given.tag,
            priority: given.priority,
            attempt: self.attempt,
            max_attempts: self.max_attempts,
            queue_position,
            cancel_requested: self.cancel_requested,
            progress: self.progress,
            options: given.options,
            versions: self.versions,
            device: self.device,
            metrics: self.metrics,
            error: self.error,
            artifacts,
            inputs: given.inputs,
            created_at: self.created_at,
            started_at: self.started_at,
            finished_at: self.finished_at,
            expires_at: self.expires_at,
            expired: self.expired || self.expires_at.is_some_and(|at| at <= now),
            last_seq: self.last_seq,
            revision: self.revision,
        }
    }
}

#[cfg(test)]
mod tests {
    use jiff::SignedDuration;

    use super::*;
    use crate::contract::UnwrapOptions;
    use crate::jobs::{Inputs, JobId};

    #[test]
    fn a_reader_sees_that_files_are_gone_when_their_time_is_over_or_they_were_deleted() {
        let now = Timestamp::UNIX_EPOCH;
        let seen = |expired, expires_at| {
            let standing = Standing { expired, expires_at, ..Standing::waiting(2, now) };
            let given = NewJob {
                id: JobId::new(),
                inputs: Inputs::default(),
                options: UnwrapOptions::default(),
                tag: "x".into(),
                priority: 3,
            };
            let job = standing.job(given, Vec::new(), 7, now);
            assert_eq!((job.tag.as_str(), job.priority, job.queue_position), ("x", 3, 7));
            job.expired
        };
        let second = SignedDuration::from_secs(1);
        let times = [None, Some(now + second), Some(now), Some(now - second)];
        assert_eq!(times.map(|at| seen(false, at)), [false, false, true, true]);
        assert_eq!(times.map(|at| seen(true, at)), [true; 4]);
    }
}
