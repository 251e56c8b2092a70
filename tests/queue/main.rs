//! What every queue promises, checked on every store: order, leases, attempts, events, retention,
//! and the blobs that rows name. What is about SQLite alone stands in `sqlite` and
//! `upgrade`.

mod clients;
mod history;
mod leases;
mod lifecycle;
mod sqlite;
mod storage;
mod stores;
mod upgrade;

use jiff::Timestamp;
use uvsegnet::contract::{ErrorCode, InputRole, JobError, MeshKind, UnwrapOptions, WarningCode};
use uvsegnet::jobs::{
    Claim, EventData, EventKind, Job, JobId, NewEvent, NewJob, Queue, StoredArtifact, StoredInput,
    WarningEvent, Worker,
};

const LIMIT: u64 = 1000;

fn new_job() -> NewJob {
    let id = JobId::new();
    NewJob {
        id,
        inputs: [input(InputRole::Mesh, &format!("uploads/{id}"))].into_iter().collect(),
        options: UnwrapOptions { steps: 7, ..UnwrapOptions::default() },
        tag: String::new(),
        priority: 0,
    }
}

fn input(role: InputRole, blob: &str) -> StoredInput {
    StoredInput {
        role,
        name: format!("{}.obj", role.as_str()),
        kind: (role == InputRole::Mesh).then_some(MeshKind::Obj),
        sha256: "cd".repeat(32),
        bytes: 7,
        blob: blob.into(),
    }
}

fn worker(id: &str) -> Worker {
    Worker {
        id: id.into(),
        pid: 1,
        host: "here".into(),
        device: "cpu".into(),
        engine: "1.2.3".into(),
        weights: Some("sha256:ab".into()),
        threads: 2,
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

/// The blob of a job's mesh.
fn mesh(job: &Job) -> String {
    job.inputs.mesh().expect("every job has a mesh").blob.clone()
}

async fn kinds(queue: &dyn Queue, id: JobId) -> Vec<EventKind> {
    let events = queue.events_after(id, 0, 1000).await.unwrap();
    let seqs: Vec<u64> = events.iter().map(|event| event.seq).collect();
    assert_eq!(seqs, (1..=seqs.len() as u64).collect::<Vec<_>>(), "no gap and no repetition");
    events.iter().map(|event| event.kind()).collect()
}

fn warning() -> NewEvent {
    NewEvent::now(EventData::Warning(WarningEvent {
        code: WarningCode::Degraded,
        message: "y".into(),
    }))
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
