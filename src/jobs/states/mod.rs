//! What may happen to a job, and what then becomes of it: pure functions from how a job stands and
//! a command to how it stands after, the events that tell it, and what the store has to do besides.
//! Stores read the row, ask here, and write what they are told; they decide only which row.

mod command;
mod endings;
mod policy;
mod standing;

#[cfg(test)]
mod tests;

pub use command::{Command, Ending, Gone};
pub use policy::Policy;
pub use standing::{Held, Standing};

use jiff::Timestamp;

use super::{NewEvent, QueueError, StoredArtifact, Swept};

/// Why a command is not obeyed. Nothing changes then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Whoever asks does not hold the lease of a running job.
    #[error("the lease on this job is lost")]
    LeaseLost,
    /// Only a job that waits can be claimed.
    #[error("the job does not wait")]
    NotWaiting,
    /// Its worker is not known to be gone.
    #[error("the job is not lost")]
    NotLost,
    /// Only a job that is over can be deleted.
    #[error("the job is not over")]
    NotOver,
    /// Its files are kept for longer, or gone already.
    #[error("the job does not expire now")]
    NotDue,
}

impl From<Refusal> for QueueError {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::LeaseLost => QueueError::LeaseLost,
            // The others are answered by whoever asked, or are asked of the wrong row.
            other => QueueError::Database(Box::new(other)),
        }
    }
}

/// What a command that is obeyed changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// How the job stands from now on.
    pub standing: Standing,
    /// What is to be told, oldest first; the last has the number `standing.last_seq`.
    pub events: Vec<NewEvent>,
    /// What else is to be done.
    pub effects: Effects,
}

/// What a store has to do besides.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Effects {
    /// Files that are the job's from now on, in this order.
    pub artifacts: Vec<StoredArtifact>,
    /// The blobs that the job names are named no more, and may go.
    pub blobs_may_go: bool,
    /// The job itself goes, with all that is stored of it.
    pub row_goes: bool,
    /// How a job without a worker counts.
    pub swept: Swept,
}

impl Change {
    fn none(standing: &Standing) -> Self {
        Self { standing: standing.clone(), events: Vec::new(), effects: Effects::default() }
    }

    fn tell(&mut self, events: Vec<NewEvent>) {
        self.standing.last_seq += events.len() as u64;
        self.events.extend(events);
    }
}

/// How a new job stands, unless as many wait already as may.
pub fn submit(
    waiting: u64,
    limit: u64,
    policy: &Policy,
    now: Timestamp,
) -> Result<Standing, QueueError> {
    if waiting >= limit {
        return Err(QueueError::Full { limit });
    }
    Ok(Standing::waiting(policy.max_attempts, now))
}

/// What becomes of a job that stands like this, if anything may.
pub fn apply(
    standing: &Standing,
    command: Command<'_>,
    policy: &Policy,
    now: Timestamp,
) -> Result<Change, Refusal> {
    let mut change = command.apply(standing, policy, now)?;
    // That a lease runs on is nobody's news.
    let news = Standing { held: standing.held.clone(), ..change.standing.clone() } != *standing;
    if news || !change.events.is_empty() {
        change.standing.revision += 1;
    }
    Ok(change)
}
