//! What housekeeping and supervision do.

use std::collections::BTreeSet;

use async_trait::async_trait;
use jiff::Timestamp;

use super::{MemoryQueue, Store};
use crate::jobs::states::{Command, Gone, Policy};
use crate::jobs::worker::WORKER_FORGOTTEN;
use crate::jobs::{Keep, QueueError, Swept, Worker};

#[async_trait]
impl Keep for MemoryQueue {
    async fn sweep(&self) -> Result<Swept, QueueError> {
        Ok(self.write(|store, policy| {
            let since = Timestamp::now().checked_sub(WORKER_FORGOTTEN).unwrap_or(Timestamp::MIN);
            let known = store.workers.len();
            store.workers.retain(|_, worker| worker.last_seen >= since);
            store.changed |= store.workers.len() < known;
            store.take_back(Gone::Lapsed, policy)
        }))
    }

    async fn worker_gone(&self, worker: &str) -> Result<Swept, QueueError> {
        Ok(self.gone(worker))
    }

    async fn workers_on(&self, host: &str) -> Result<Vec<Worker>, QueueError> {
        let store = self.read();
        Ok(store.workers.values().filter(|worker| worker.host == host).cloned().collect())
    }

    async fn expire(&self) -> Result<Vec<String>, QueueError> {
        Ok(self.write(|store, policy| {
            let mut gone = Vec::new();
            for id in store.ids() {
                if let Some(Ok((_, blobs))) = store.obey(id, Command::Expire, policy) {
                    gone.extend(blobs);
                }
            }
            gone
        }))
    }

    async fn named(&self, blobs: &[String]) -> Result<BTreeSet<String>, QueueError> {
        let store = self.read();
        Ok(blobs.iter().filter(|name| store.blobs.contains_key(*name)).cloned().collect())
    }
}

impl MemoryQueue {
    /// Forget a worker and take its jobs back.
    pub(super) fn gone(&self, worker: &str) -> Swept {
        self.write(|store, policy| {
            store.changed |= store.workers.remove(worker).is_some();
            store.take_back(Gone::Worker(worker), policy)
        })
    }
}

impl Store {
    /// Take back the jobs of workers that are gone.
    pub(super) fn take_back(&mut self, gone: Gone<'_>, policy: &Policy) -> Swept {
        let mut swept = Swept::default();
        for id in self.ids() {
            if let Some(Ok((change, _))) = self.obey(id, Command::TakeBack(gone), policy) {
                swept += change.effects.swept;
            }
        }
        swept
    }
}
