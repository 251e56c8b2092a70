//! The JSON of jobs, artifacts and events, as clients see it.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::{JobError, UnwrapOptions};
use crate::jobs::{
    Event, EventData, EventKind, Job, JobId, JobProgress, JobState, MetricsSummary, StoredArtifact,
    Versions,
};

/// A job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Job)]
pub struct JobBody {
    /// Its name in every address.
    pub id: JobId,
    /// Where it stands.
    pub state: JobState,
    /// The client's own word for it; may be empty.
    pub tag: String,
    /// Attempts that were begun; 0 before the first.
    pub attempt: u32,
    /// After this many attempts that ended in a crash the job fails.
    pub max_attempts: u32,
    /// Jobs that will run before this one; 0 when it is next or does not wait.
    pub queue_position: u64,
    /// Whether it runs and was asked to stop.
    pub cancel_requested: bool,
    /// How far it is; null before the first stage.
    #[schema(required)]
    pub progress: Option<JobProgress>,
    /// What it does, defaults filled in.
    pub options: UnwrapOptions,
    /// What ran it.
    pub versions: Versions,
    /// Device that ran it; null before the first attempt.
    #[schema(required)]
    pub device: Option<String>,
    /// The result at a glance; null until it succeeds.
    #[schema(required)]
    pub metrics: Option<MetricsSummary>,
    /// Why it failed; null otherwise.
    #[schema(required)]
    pub error: Option<JobError>,
    /// What it made; empty until it is over.
    pub artifacts: Vec<ArtifactBody>,
    /// When it was queued.
    #[schema(value_type = String, format = DateTime)]
    pub created_at: Timestamp,
    /// When its latest attempt began.
    #[schema(required, value_type = Option<String>, format = DateTime)]
    pub started_at: Option<Timestamp>,
    /// When it was over.
    #[schema(required, value_type = Option<String>, format = DateTime)]
    pub finished_at: Option<Timestamp>,
}

impl JobBody {
    /// Where a job is found.
    pub fn url(id: JobId) -> String {
        format!("/v1/jobs/{id}")
    }
}

impl From<Job> for JobBody {
    fn from(job: Job) -> Self {
        let artifacts = job.artifacts.iter().map(|a| ArtifactBody::of(&job, a)).collect();
        Self {
            id: job.id,
            state: job.state,
            tag: job.tag,
            attempt: job.attempt,
            max_attempts: job.max_attempts,
            queue_position: job.queue_position,
            cancel_requested: job.cancel_requested,
            progress: job.progress,
            options: job.options,
            versions: job.versions,
            device: job.device,
            metrics: job.metrics,
            error: job.error,
            artifacts,
            created_at: job.created_at,
            started_at: job.started_at,
            finished_at: job.finished_at,
        }
    }
}

/// A file that a job made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Artifact)]
pub struct ArtifactBody {
    /// Its name.
    #[schema(example = "model.glb")]
    pub name: String,
    /// Its media type.
    #[schema(example = "model/gltf-binary")]
    pub media_type: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its bytes, in hexadecimal digits; in quotes it is the ETag.
    pub sha256: String,
    /// Where to get it.
    #[schema(example = "/v1/jobs/job_0190163d8694739baea5966c26f8ad91/artifacts/model.glb")]
    pub url: String,
    /// When it goes; null until the job is over.
    #[schema(required, value_type = Option<String>, format = DateTime)]
    pub expires_at: Option<Timestamp>,
}

impl ArtifactBody {
    /// One of the artifacts of `job`.
    pub fn of(job: &Job, artifact: &StoredArtifact) -> Self {
        Self {
            name: artifact.name.clone(),
            media_type: artifact.media_type.clone(),
            bytes: artifact.bytes,
            sha256: artifact.sha256.clone(),
            url: format!("{}/artifacts/{}", JobBody::url(job.id), artifact.name),
            expires_at: job.expires_at,
        }
    }
}

/// A page of jobs, newest first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobList {
    /// The jobs.
    pub data: Vec<JobBody>,
    /// The `cursor` of the next page; null on the last.
    #[schema(required)]
    pub next_cursor: Option<String>,
}

/// The files that a job made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ArtifactList {
    /// The files.
    pub data: Vec<ArtifactBody>,
}

/// An event, with the names that a server-sent event has.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = Event)]
pub struct EventBody {
    /// 1, 2, 3, … within the job.
    pub id: u64,
    /// What happened.
    pub event: EventKind,
    /// The particulars.
    pub data: EventDataBody,
}

/// The data of an event in every form: whose it is and when it was, then what it has of its own.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = EventFields)]
pub struct EventDataBody {
    /// The job.
    pub job_id: JobId,
    /// When it happened.
    #[schema(value_type = String, format = DateTime)]
    pub at: Timestamp,
    /// What an event of this kind has to say.
    #[serde(flatten)]
    pub own: EventData,
}

impl From<Event> for EventDataBody {
    fn from(event: Event) -> Self {
        Self { job_id: event.job_id, at: event.at, own: event.data }
    }
}

impl From<Event> for EventBody {
    fn from(event: Event) -> Self {
        Self { id: event.seq, event: event.kind(), data: event.into() }
    }
}

/// Events of a job, oldest first.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct EventList {
    /// The events.
    pub data: Vec<EventBody>,
    /// The `after` that goes on from here.
    pub next_after: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Stage;
    use crate::jobs::StageEvent;

    #[test]
    fn an_event_says_whose_it_is_and_then_its_own() {
        let id = JobId::new();
        let event = Event {
            event_id: 9,
            job_id: id,
            seq: 4,
            data: EventData::Stage(StageEvent { attempt: 1, stage: Stage::Pack }),
            at: "2026-01-02T03:04:05.678Z".parse().unwrap(),
        };
        let data = format!(
            r#"{{"job_id":"{id}","at":"2026-01-02T03:04:05.678Z","attempt":1,"stage":"pack"}}"#
        );
        let json = serde_json::to_string(&EventBody::from(event)).unwrap();
        assert_eq!(json, format!(r#"{{"id":4,"event":"stage","data":{data}}}"#));
    }
}
