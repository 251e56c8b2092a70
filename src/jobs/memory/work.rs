//! What workers do.

use async_trait::async_trait;
use jiff::Timestamp;
use uuid::Uuid;

use super::MemoryQueue;
use crate::contract::JobError;
use crate::jobs::states::{Command, Ending, Gone, Standing};
use crate::jobs::{
    Claim, Handover, JobState, Lease, NewEvent, QueueError, Tick, TickAnswer, Work, Worker,
};

#[async_trait]
impl Work for MemoryQueue {
    async fn register(&self, worker: &Worker) -> Result<(), QueueError> {
        self.write(|store, _| {
            let known = store.workers.entry(worker.id.clone()).or_insert_with(|| worker.clone());
            (known.draining, known.last_seen) = (worker.draining, Timestamp::now());
            store.changed = true;
        });
        Ok(())
    }

    async fn leave(&self, worker: &str) -> Result<(), QueueError> {
        self.gone(worker);
        Ok(())
    }

    async fn claim(&self, worker: &Worker) -> Result<Option<Claim>, QueueError> {
        self.write(|store, policy| {
            store.take_back(Gone::Lapsed, policy);
            let Some(id) = store.waiting().first().copied() else { return Ok(None) };
            let token = Uuid::now_v7().simple().to_string();
            let claimed = store.obey(id, Command::Claim { worker, token: &token }, policy);
            claimed.transpose()?;
            Ok(store.job(id).map(|job| Claim { lease: Lease { job: id, token }, job }))
        })
    }

    async fn tick(&self, lease: &Lease, tick: Tick) -> Result<TickAnswer, QueueError> {
        match self.obey(lease, Command::Tick(&lease.token, tick)) {
            Ok(standing) if standing.cancel_requested => Ok(TickAnswer::Cancel),
            Ok(_) => Ok(TickAnswer::Continue),
            Err(QueueError::LeaseLost) => Ok(TickAnswer::LeaseLost),
            Err(error) => Err(error),
        }
    }

    async fn finish(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError> {
        self.obey(lease, Command::End(&lease.token, Ending::Succeeded, handover)).map(|_| ())
    }

    async fn fail(
        &self,
        lease: &Lease,
        error: JobError,
        handover: Handover,
    ) -> Result<JobState, QueueError> {
        let ending = Ending::Failed(error);
        let standing = self.obey(lease, Command::End(&lease.token, ending, handover))?;
        Ok(standing.state)
    }

    async fn canceled(&self, lease: &Lease, handover: Handover) -> Result<(), QueueError> {
        self.obey(lease, Command::End(&lease.token, Ending::Canceled, handover)).map(|_| ())
    }

    async fn release(&self, lease: &Lease, events: Vec<NewEvent>) -> Result<(), QueueError> {
        self.obey(lease, Command::Release(&lease.token, events)).map(|_| ())
    }
}

impl MemoryQueue {
    /// Do to the job of a lease what its holder says. A job that is gone is as lost as a lease.
    fn obey(&self, lease: &Lease, command: Command<'_>) -> Result<Standing, QueueError> {
        self.write(|store, policy| {
            let done = store.obey(lease.job, command, policy).ok_or(QueueError::LeaseLost)?;
            Ok(done?.0.standing)
        })
    }
}
