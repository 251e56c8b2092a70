//! The two ways in which a job leaves `running` (or `queued`): it is over, or it waits again.

use jiff::Timestamp;

use super::{Change, Policy};
use crate::contract::{ErrorCode, JobError};
use crate::jobs::{
    CanceledEvent, EventData, FailedEvent, JobState, MetricsSummary, NewEvent, RetryingEvent,
    StoredArtifact, SucceededEvent,
};

/// How a job is over.
pub(super) enum Over {
    Succeeded(Option<MetricsSummary>, Vec<StoredArtifact>),
    Failed(JobError, Vec<StoredArtifact>),
    Canceled,
}

/// End a job: its state, its files, its last event.
pub(super) fn over(change: &mut Change, over: Over, policy: &Policy, now: Timestamp) {
    let standing = &mut change.standing;
    let attempt = standing.attempt;
    let data = match over {
        Over::Succeeded(metrics, artifacts) => {
            standing.state = JobState::Succeeded;
            standing.metrics = metrics.clone();
            let names = artifacts.iter().map(|artifact| artifact.name.clone()).collect();
            change.effects.artifacts = artifacts;
            EventData::Succeeded(SucceededEvent {
                state: JobState::Succeeded,
                attempt,
                metrics,
                artifacts: names,
            })
        }
        Over::Failed(error, artifacts) => {
            standing.state = JobState::Failed;
            standing.error = Some(error.clone());
            change.effects.artifacts = artifacts;
            EventData::Failed(FailedEvent { state: JobState::Failed, attempt, error })
        }
        Over::Canceled => {
            standing.state = JobState::Canceled;
            EventData::Canceled(CanceledEvent { state: JobState::Canceled, attempt })
        }
    };
    standing.held = None;
    standing.finished_at = Some(now);
    standing.expires_at = Some(policy.expires(now));
    change.tell(vec![NewEvent { data, at: now }]);
}

/// Why a job waits again.
pub(super) enum Again {
    /// Its attempt is spent.
    After(JobError),
    /// Its worker shut down: the attempt does not count.
    Draining,
}

/// Let a job wait again. It keeps its id and so its age: it is first among its priority.
pub(super) fn requeue(change: &mut Change, again: Again, now: Timestamp) {
    let standing = &mut change.standing;
    let (attempt, max_attempts) = (standing.attempt, standing.max_attempts);
    let (code, message) = match again {
        Again::After(error) => (error.code, error.message),
        Again::Draining => {
            standing.attempt = attempt.saturating_sub(1);
            (ErrorCode::Draining, "the worker shut down in the middle".to_owned())
        }
    };
    standing.state = JobState::Queued;
    standing.held = None;
    standing.progress = None;
    standing.started_at = None;
    let data = EventData::Retrying(RetryingEvent { attempt, max_attempts, code, message });
    change.tell(vec![NewEvent { data, at: now }]);
}
