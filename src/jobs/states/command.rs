//! The commands: who may give them in which state, and what each does.

use jiff::Timestamp;

use super::endings::{Again, Over, over, requeue};
use super::policy::is_transient;
use super::{Change, Held, Policy, Refusal, Standing};
use crate::contract::{ErrorCode, JobError};
use crate::jobs::{
    Handover, JobProgress, JobState, NewEvent, StoredArtifact, Swept, Tick, Versions, Worker,
};

/// Something that is to happen to a job.
#[derive(Debug, Clone)]
pub enum Command<'a> {
    /// A worker takes it; the token is drawn for this claim alone.
    Claim {
        /// The worker.
        worker: &'a Worker,
        /// The token of the lease.
        token: &'a str,
    },
    /// A client asks it to stop.
    RequestCancel,
    /// The worker that holds this token tells how it goes, and may extend its lease.
    Tick(&'a str, Tick),
    /// The worker that holds this token ends the attempt.
    End(&'a str, Ending, Handover),
    /// The worker that holds this token shuts down.
    Release(&'a str, Vec<NewEvent>),
    /// Whoever ran it may be gone.
    TakeBack(Gone<'a>),
    /// Its time may be over.
    Expire,
    /// A client wants it forgotten.
    Delete,
}

/// How an attempt ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// With a result.
    Succeeded,
    /// With an error.
    Failed(JobError),
    /// It was told to stop, and did.
    Canceled,
}

/// Which workers are gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gone<'a> {
    /// This one.
    Worker(&'a str),
    /// Any whose lease has lapsed.
    Lapsed,
}

impl Command<'_> {
    pub(super) fn apply(
        self,
        before: &Standing,
        policy: &Policy,
        now: Timestamp,
    ) -> Result<Change, Refusal> {
        let mut change = Change::none(before);
        match self {
            Command::Claim { worker, token } => {
                claim(&mut change.standing, worker, token, policy, now)?
            }
            Command::RequestCancel => match before.state {
                JobState::Queued => over(&mut change, Over::Canceled, policy, now),
                JobState::Running => change.standing.cancel_requested = true,
                JobState::Succeeded | JobState::Failed | JobState::Canceled => {}
            },
            Command::Tick(token, tick) => {
                let mut held = holder(before, token)?.clone();
                report(&mut change, tick.events, tick.progress);
                if tick.extend {
                    held.until = policy.lapses(now);
                    change.standing.held = Some(held);
                }
            }
            Command::End(token, ending, handover) => {
                holder(before, token)?;
                report(&mut change, handover.events, handover.progress);
                match ending {
                    Ending::Succeeded => {
                        let end = Over::Succeeded(handover.metrics, handover.artifacts);
                        over(&mut change, end, policy, now);
                    }
                    Ending::Canceled => over(&mut change, Over::Canceled, policy, now),
                    Ending::Failed(error) if is_transient(error.code) => {
                        lost(&mut change, error, handover.artifacts, policy, now);
                    }
                    Ending::Failed(error) => {
                        over(&mut change, Over::Failed(error, handover.artifacts), policy, now);
                    }
                }
            }
            Command::Release(token, events) => {
                holder(before, token)?;
                report(&mut change, events, None);
                match before.cancel_requested {
                    true => over(&mut change, Over::Canceled, policy, now),
                    false => requeue(&mut change, Again::Draining, now),
                }
            }
            Command::TakeBack(gone) => take_back(&mut change, gone, policy, now)?,
            Command::Expire => {
                let due = before.expires_at.is_some_and(|at| at <= now);
                if !before.state.is_terminal() || before.expired || !due {
                    return Err(Refusal::NotDue);
                }
                change.standing.expired = true;
                change.effects.blobs_may_go = true;
            }
            Command::Delete => {
                if !before.state.is_terminal() {
                    return Err(Refusal::NotOver);
                }
                change.effects.blobs_may_go = true;
                change.effects.row_goes = true;
            }
        }
        Ok(change)
    }
}

/// The attempt is counted here.
fn claim(
    standing: &mut Standing,
    worker: &Worker,
    token: &str,
    policy: &Policy,
    now: Timestamp,
) -> Result<(), Refusal> {
    if standing.state != JobState::Queued {
        return Err(Refusal::NotWaiting);
    }
    standing.state = JobState::Running;
    standing.attempt += 1;
    standing.held = Some(Held {
        worker: worker.id.clone(),
        token: token.to_owned(),
        until: policy.lapses(now),
    });
    standing.progress = None;
    standing.versions = Versions { engine: worker.engine.clone(), weights: worker.weights.clone() };
    standing.device = Some(worker.device.clone());
    standing.started_at = Some(now);
    Ok(())
}

/// The lease of a running job, if this is its token.
fn holder<'a>(standing: &'a Standing, token: &str) -> Result<&'a Held, Refusal> {
    let running = standing.state == JobState::Running;
    let held = standing.held.as_ref().filter(|held| running && held.token == token);
    held.ok_or(Refusal::LeaseLost)
}

fn report(change: &mut Change, events: Vec<NewEvent>, progress: Option<JobProgress>) {
    change.tell(events);
    if progress.is_some() {
        change.standing.progress = progress;
    }
}

/// A crash counts as an attempt; what it wrote on the way goes with it.
fn take_back(
    change: &mut Change,
    gone: Gone<'_>,
    policy: &Policy,
    now: Timestamp,
) -> Result<(), Refusal> {
    let standing = &change.standing;
    let held = standing.held.as_ref().filter(|_| standing.state == JobState::Running);
    let how = match (gone, held) {
        (Gone::Worker(worker), Some(held)) if held.worker == worker => "the worker process died",
        (Gone::Lapsed, Some(held)) if held.until < now => "the worker was not heard of any more",
        _ => return Err(Refusal::NotLost),
    };
    let message = format!(
        "{how} while it ran the job (attempt {} of {})",
        standing.attempt, standing.max_attempts
    );
    lost(change, JobError::new(ErrorCode::WorkerCrashed, message), Vec::new(), policy, now);
    change.effects.swept = match change.standing.state {
        JobState::Canceled => Swept { canceled: 1, ..Swept::default() },
        JobState::Failed => Swept { failed: 1, ..Swept::default() },
        _ => Swept { requeued: 1, ..Swept::default() },
    };
    Ok(())
}

/// The machine failed: somebody may have wanted the job to stop anyway, else it is tried again while
/// attempts are left.
fn lost(
    change: &mut Change,
    error: JobError,
    artifacts: Vec<StoredArtifact>,
    policy: &Policy,
    now: Timestamp,
) {
    let standing = &change.standing;
    if standing.cancel_requested {
        over(change, Over::Canceled, policy, now);
    } else if standing.attempt < standing.max_attempts {
        requeue(change, Again::After(error), now);
    } else {
        over(change, Over::Failed(error, artifacts), policy, now);
    }
}
