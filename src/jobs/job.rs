//! What a job is: its id, its states, its row as every reader sees it.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::contract::{JobError, Stage, UnwrapOptions};

use super::{Inputs, MetricsSummary};

/// `job_` and a UUID of version 7 in 32 lower-case hexadecimal digits: ids sort by age.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, ToSchema)]
#[schema(value_type = String, pattern = "^job_[0-9a-f]{32}$")]
#[schema(example = "job_0190163d8694739baea5966c26f8ad91")]
pub struct JobId(Uuid);

/// This is no job id.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a job id is \"job_\" and 32 hexadecimal digits, as in job_0190163d8694739baea5966c26f8ad91"
)]
pub struct JobIdError;

impl JobId {
    /// A new id, greater than every id that this process made before.
    pub fn new() -> Self {
        Self(Uuid::now_v7())
    }
}

impl Default for JobId {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "job_{}", self.0.simple())
    }
}

impl FromStr for JobId {
    type Err = JobIdError;

    fn from_str(text: &str) -> Result<Self, JobIdError> {
        let digits = text.strip_prefix("job_").ok_or(JobIdError)?;
        let hex = |b: u8| b.is_ascii_digit() || (b'a'..=b'f').contains(&b);
        if digits.len() != 32 || !digits.bytes().all(hex) {
            return Err(JobIdError);
        }
        Uuid::try_parse(digits).map(Self).map_err(|_| JobIdError)
    }
}

impl Serialize for JobId {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for JobId {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

/// Where a job stands. The last three are final.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// Waits for a worker.
    Queued,
    /// A worker holds its lease.
    Running,
    /// Over: the artifacts are there.
    Succeeded,
    /// Over: `error` says why.
    Failed,
    /// Over: somebody asked for that.
    Canceled,
}

impl JobState {
    /// Every state.
    pub const ALL: [JobState; 5] = [
        JobState::Queued,
        JobState::Running,
        JobState::Succeeded,
        JobState::Failed,
        JobState::Canceled,
    ];

    /// The state as it is written in JSON and in the database.
    pub fn as_str(self) -> &'static str {
        match self {
            JobState::Queued => "queued",
            JobState::Running => "running",
            JobState::Succeeded => "succeeded",
            JobState::Failed => "failed",
            JobState::Canceled => "canceled",
        }
    }

    /// Whether nothing can happen to the job any more.
    pub fn is_terminal(self) -> bool {
        matches!(self, JobState::Succeeded | JobState::Failed | JobState::Canceled)
    }
}

impl FromStr for JobState {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        JobState::ALL.into_iter().find(|state| state.as_str() == text).ok_or_else(|| {
            format!(
                "unknown state {text:?}: expected queued, running, succeeded, failed or canceled"
            )
        })
    }
}

/// How far a running job is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobProgress {
    /// The stage it is in.
    pub stage: Stage,
    /// Share of the job's work that is done, 0 to 1, weighted by the work that its size lets expect of each
    /// stage. It never falls within an attempt.
    pub fraction: f64,
    /// Parts of which every chart has its map.
    pub parts_done: u32,
    /// Parts in all; 0 until they are known.
    pub parts_total: u32,
    /// Seconds until the job is done, at its pace so far; null until there is a pace.
    #[schema(required)]
    pub eta_s: Option<f64>,
}

/// What the result is a function of, next to input and options.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub struct Versions {
    /// Version of the program that ran (or last tried) the job; empty before the first attempt.
    pub engine: String,
    /// `sha256:…` of the segmentation weights of the worker that ran the job; null before the first attempt.
    /// Whether they were asked, metrics.json says.
    #[schema(required)]
    pub weights: Option<String>,
}

/// A file that a job made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredArtifact {
    /// Its name, as in `model.glb`.
    pub name: String,
    /// Its media type, as in `model/gltf-binary`.
    pub media_type: String,
    /// Its length.
    pub bytes: u64,
    /// SHA-256 of its content, in 64 lower-case hexadecimal digits: a strong ETag.
    pub sha256: String,
    /// Name of the blob that holds it.
    pub blob: String,
}

/// A job that is to be queued. Its blobs are in place already.
#[derive(Debug, Clone)]
pub struct NewJob {
    /// A fresh id.
    pub id: JobId,
    /// The files, a mesh among them.
    pub inputs: Inputs,
    /// What to do.
    pub options: UnwrapOptions,
    /// A word of the client's, to find the job again; may be empty.
    pub tag: String,
    /// Higher is claimed first; 0 for everybody so far.
    pub priority: i32,
}

/// A job as every reader sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Its id.
    pub id: JobId,
    /// Where it stands.
    pub state: JobState,
    /// A word of the client's; may be empty.
    pub tag: String,
    /// Higher is claimed first.
    pub priority: i32,
    /// Attempts that were begun, the running one included; 0 before the first.
    pub attempt: u32,
    /// After this many attempts that ended in a crash the job fails.
    pub max_attempts: u32,
    /// Jobs that will be claimed before this one; 0 when it is next or does not wait.
    pub queue_position: u64,
    /// Whether somebody asked a running job to stop.
    pub cancel_requested: bool,
    /// How far it is; `None` before the first stage.
    pub progress: Option<JobProgress>,
    /// What to do.
    pub options: UnwrapOptions,
    /// Versions of what ran it.
    pub versions: Versions,
    /// Device of the worker that ran it; `None` before the first attempt.
    pub device: Option<String>,
    /// Figures of a job that succeeded; the whole is the artifact `metrics.json`.
    pub metrics: Option<MetricsSummary>,
    /// Why a job failed.
    pub error: Option<JobError>,
    /// What it made, in a fixed order. The rows stay after expiry; the blobs do not.
    pub artifacts: Vec<StoredArtifact>,
    /// What it was given. The rows stay after expiry; the blobs do not.
    pub inputs: Inputs,
    /// When it was queued.
    pub created_at: Timestamp,
    /// When its latest attempt began.
    pub started_at: Option<Timestamp>,
    /// When it was over.
    pub finished_at: Option<Timestamp>,
    /// When its inputs and artifacts go; `None` until it is over.
    pub expires_at: Option<Timestamp>,
    /// Whether inputs and artifacts are gone, or may be at any moment.
    pub expired: bool,
    /// Sequence number of its latest event; 0 before the first.
    pub last_seq: u64,
    /// Grows with every change of the row: with the id, an ETag of the job.
    pub revision: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_round_trip_and_sort_by_age() {
        let (a, b) = (JobId::new(), JobId::new());
        assert!(a < b && a.to_string() < b.to_string());
        assert_eq!(a.to_string().parse(), Ok(a));
        for wrong in
            ["", "job_", "0190163d8694739baea5966c26f8ad91", "job_0190163D8694739BAEA5966C26F8AD91"]
        {
            assert_eq!(wrong.parse::<JobId>(), Err(JobIdError));
        }
    }

    #[test]
    fn states_are_written_as_in_json() {
        for state in JobState::ALL {
            assert_eq!(serde_json::to_value(state).unwrap(), state.as_str());
            assert_eq!(state.as_str().parse(), Ok(state));
        }
    }
}
