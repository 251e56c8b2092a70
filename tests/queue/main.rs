//! What every queue promises, checked on every store: order, leases, attempts, events, retention,
//! and the blobs that rows name. What is about SQLite alone stands in `sqlite`.

mod clients;
mod history;
mod leases;
mod lifecycle;
mod sqlite;
mod storage;
mod stores;

use jiff::Timestamp;
use uvsegnet::contract::{ErrorCode, JobError, MeshKind, UnwrapOptions};
use uvsegnet::jobs::{
    Claim, EventData, EventKind, Job, JobId, NewEvent, NewJob, Queue, StoredArtifact, WarningEvent,
    Worker,
};

const LIMIT: u64 = 1000;

fn new_job() -> NewJob {
    let id = JobId::new();
    NewJob {
        id,
        kind: MeshKind::Glb,
        upload: format!("uploads/{id}"),
        labels: None,
        options: UnwrapOptions { steps: 7, ..UnwrapOptions::default() },
        tag: String::new(),
        priority: 0,
    }
}

fn worker(id: &str) -> Worker {
    Worker {
        id: id.into(),
        pid: 1,
        host: "here".into(),
        device: "cpu".into(),
        engine: "1.2.3".into(),
        draining: false,
        last_seen: Timestamp::now(),
    }
}

async fn submit(queue: &dyn Queue) -> JobId {
    queue.submit(new_job(), LIMIT).await.unwrap().id
}

async fn claim(queue: &dyn Queue) -> Claim {
    queue.claim(&worker("w")).await.unwrap().expect("a job waits")
}

async fn get(queue: &dyn Queue, id: JobId) -> Job {
    queue.get(id).await.unwrap().expect("the job is there")
}

async fn kinds(queue: &dyn Queue, id: JobId) -> Vec<EventKind> {
    let events = queue.events_after(id, 0, 1000).await.unwrap();
    let seqs: Vec<u64> = events.iter().map(|event| event.seq).collect();
    assert_eq!(seqs, (1..=seqs.len() as u64).collect::<Vec<_>>(), "no gap and no repetition");
    events.iter().map(|event| event.kind()).collect()
}

fn warning() -> NewEvent {
    NewEvent::now(EventData::Warning(WarningEvent { code: "x".into(), message: "y".into() }))
}

fn artifact(name: &str, blob: &str) -> StoredArtifact {
    StoredArtifact {
        name: name.into(),
        media_type: "text/plain".into(),
        bytes: 3,
        sha256: "ab".repeat(32),
        blob: blob.into(),
    }
}

fn error(code: ErrorCode) -> JobError {
    JobError::new(code, "because")
}
