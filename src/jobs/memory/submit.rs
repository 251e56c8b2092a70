//! What clients do.

use async_trait::async_trait;
use jiff::Timestamp;

use super::MemoryQueue;
use crate::jobs::states::{self, Command, Refusal};
use crate::jobs::worker::WORKER_ALIVE;
use crate::jobs::{
    CancelOutcome, Deleted, Event, Job, JobId, JobState, ListFilter, NewJob, Page, QueueError,
    Stats, Submit,
};

#[async_trait]
impl Submit for MemoryQueue {
    async fn submit(&self, job: NewJob, limit: u64) -> Result<Job, QueueError> {
        self.write(|store, policy| {
            let id = job.id;
            let waiting = store.waiting().len() as u64;
            let standing = states::submit(waiting, limit, policy, Timestamp::now())?;
            store.insert(job, standing);
            store.job(id).ok_or_else(|| vanished(id))
        })
    }

    async fn get(&self, id: JobId) -> Result<Option<Job>, QueueError> {
        Ok(self.read().job(id))
    }

    async fn list(&self, filter: &ListFilter) -> Result<Page, QueueError> {
        let after = filter.after()?;
        let store = self.read();
        let found = store.jobs.iter().rev().filter(|(id, row)| {
            after.is_none_or(|after| **id < after)
                && filter.state.is_none_or(|state| row.standing.state == state)
                && filter.tag.as_ref().is_none_or(|tag| row.given.tag == *tag)
        });
        let found = found.take(filter.page() as usize + 1);
        Ok(Page::of(filter, found.filter_map(|(id, _)| store.job(*id)).collect()))
    }

    async fn request_cancel(&self, id: JobId) -> Result<CancelOutcome, QueueError> {
        self.write(|store, policy| {
            let Some(done) = store.obey(id, Command::RequestCancel, policy) else {
                return Ok(CancelOutcome::NotFound);
            };
            done?;
            let job = store.job(id).ok_or_else(|| vanished(id))?;
            Ok(match job.state.is_terminal() {
                true => CancelOutcome::Over(job),
                false => CancelOutcome::Requested(job),
            })
        })
    }

    async fn delete(&self, id: JobId) -> Result<Deleted, QueueError> {
        self.write(|store, policy| match store.obey(id, Command::Delete, policy) {
            None => Ok(Deleted::NotFound),
            Some(Err(Refusal::NotOver)) => Ok(Deleted::NotTerminal),
            Some(done) => Ok(Deleted::Deleted { blobs: done?.1 }),
        })
    }

    async fn events_after(
        &self,
        id: JobId,
        after: u64,
        limit: u32,
    ) -> Result<Vec<Event>, QueueError> {
        let store = self.read();
        let later = store.events.iter().filter(|event| event.job_id == id && event.seq > after);
        Ok(later.take(limit as usize).cloned().collect())
    }

    async fn all_events_after(&self, after: i64, limit: u32) -> Result<Vec<Event>, QueueError> {
        let store = self.read();
        let later = store.events.iter().filter(|event| event.event_id > after);
        Ok(later.take(limit as usize).cloned().collect())
    }

    async fn last_event_id(&self) -> Result<i64, QueueError> {
        Ok(self.read().last_event_id)
    }

    async fn stats(&self) -> Result<Stats, QueueError> {
        let store = self.read();
        let count =
            |state| store.jobs.values().filter(|row| row.standing.state == state).count() as u64;
        let since = Timestamp::now().checked_sub(WORKER_ALIVE).unwrap_or(Timestamp::MIN);
        let alive = store.workers.values().filter(|worker| worker.last_seen >= since);
        Ok(Stats {
            queued: count(JobState::Queued),
            running: count(JobState::Running),
            workers: alive.cloned().collect(),
        })
    }
}

/// A row that this very transaction wrote is not there.
fn vanished(id: JobId) -> QueueError {
    QueueError::Row { what: format!("job {id}"), why: "it vanished within a transaction".into() }
}
