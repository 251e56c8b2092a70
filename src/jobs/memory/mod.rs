//! The queue in the memory of one process. It forgets everything when it is dropped, so it breaks
//! the promise that a job once taken is done whatever happens: it is for tests, and shows that no
//! rule of the queue lives in a database.

mod keep;
mod submit;
mod work;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};

use jiff::Timestamp;

use super::states::{self, Change, Command, Policy, Refusal, Standing};
use super::{Changes, Commits, Event, Job, JobId, JobState, NewJob, StoredArtifact, Worker};

/// The queue in memory. Cheap to clone: all clones are the same queue.
#[derive(Debug, Clone)]
pub struct MemoryQueue(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    store: Mutex<Store>,
    policy: Policy,
    commits: Commits,
    changes: Changes,
}

/// What a database would hold.
#[derive(Debug, Default)]
struct Store {
    jobs: BTreeMap<JobId, Row>,
    /// Of all jobs, in the order of commits.
    events: Vec<Event>,
    /// The greatest that was ever given.
    last_event_id: i64,
    /// Blobs that must be kept, and whose they are.
    blobs: BTreeMap<String, JobId>,
    workers: BTreeMap<String, Worker>,
    /// Whether this transaction changed anything: whoever only looked must wake nobody.
    changed: bool,
}

#[derive(Debug, Clone)]
struct Row {
    given: NewJob,
    standing: Standing,
    artifacts: Vec<StoredArtifact>,
}

impl MemoryQueue {
    /// An empty queue.
    pub fn new(policy: Policy) -> Self {
        let (commits, changes) = Changes::new();
        // As with a database that was just opened, the first wait ends at once.
        commits.tell();
        Self(Arc::new(Shared { store: Mutex::default(), policy, commits, changes }))
    }

    /// Notice commits.
    pub fn changes(&self) -> Changes {
        self.0.changes.clone()
    }

    /// A transaction that only reads.
    fn read(&self) -> MutexGuard<'_, Store> {
        // Nothing that writes can panic halfway.
        self.0.store.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// A transaction that may write, and is told if it did.
    fn write<T>(&self, transaction: impl FnOnce(&mut Store, &Policy) -> T) -> T {
        let mut store = self.read();
        let done = transaction(&mut store, &self.0.policy);
        if std::mem::take(&mut store.changed) {
            self.0.commits.tell();
        }
        done
    }
}

impl Store {
    /// A new job and the blobs that it names.
    fn insert(&mut self, given: NewJob, standing: Standing) {
        for blob in given.inputs.blobs() {
            self.blobs.insert(blob.to_owned(), given.id);
        }
        self.changed = true;
        self.jobs.insert(given.id, Row { given, standing, artifacts: Vec::new() });
    }

    /// Do to a job what a command says. Returns what changed and the blobs that may go; `None` where
    /// there is no such job.
    fn obey(
        &mut self,
        id: JobId,
        command: Command<'_>,
        policy: &Policy,
    ) -> Option<Result<(Change, Vec<String>), Refusal>> {
        let row = self.jobs.get_mut(&id)?;
        let change = match states::apply(&row.standing, command, policy, Timestamp::now()) {
            Ok(change) => change,
            Err(refusal) => return Some(Err(refusal)),
        };
        self.changed |= change.standing != row.standing || change.effects.row_goes;
        row.standing = change.standing.clone();
        row.artifacts.extend(change.effects.artifacts.iter().cloned());
        for artifact in &change.effects.artifacts {
            self.blobs.insert(artifact.blob.clone(), id);
        }
        let first = change.standing.last_seq + 1 - change.events.len() as u64;
        for (event, seq) in change.events.iter().zip(first..) {
            self.last_event_id += 1;
            self.events.push(Event {
                event_id: self.last_event_id,
                job_id: id,
                seq,
                data: event.data.clone(),
                at: event.at,
            });
        }
        let mut gone = Vec::new();
        if change.effects.blobs_may_go {
            gone.extend(self.blobs.extract_if(.., |_, owner| *owner == id).map(|(name, _)| name));
        }
        if change.effects.row_goes {
            self.jobs.remove(&id);
            self.events.retain(|event| event.job_id != id);
        }
        Some(Ok((change, gone)))
    }

    /// A job as readers see it.
    fn job(&self, id: JobId) -> Option<Job> {
        let Row { given, standing, artifacts } = self.jobs.get(&id)?.clone();
        let position = match standing.state {
            JobState::Queued => self.waiting().iter().take_while(|ahead| **ahead != id).count(),
            _ => 0,
        };
        Some(standing.job(given, artifacts, position as u64, Timestamp::now()))
    }

    /// Jobs that wait, by priority and then by age.
    fn waiting(&self) -> Vec<JobId> {
        let waits = |row: &&Row| row.standing.state == JobState::Queued;
        let mut waiting: Vec<&NewJob> =
            self.jobs.values().filter(waits).map(|row| &row.given).collect();
        waiting.sort_by_key(|job| (-i64::from(job.priority), job.id));
        waiting.into_iter().map(|job| job.id).collect()
    }

    /// Every job, to try a command on.
    fn ids(&self) -> Vec<JobId> {
        self.jobs.keys().copied().collect()
    }
}
