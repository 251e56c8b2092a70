//! What happens to a job, one row each: the source of every event stream.

use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{EventData, JobId};

/// Kinds of event, in SSE the `event:` field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A stage begins.
    Stage,
    /// A stage goes on, at most twice a second.
    Progress,
    /// All charts of a part are final.
    PartCompleted,
    /// Something the user should know.
    Warning,
    /// The attempt is over but not the job.
    Retrying,
    /// The job is over: the artifacts are there.
    Succeeded,
    /// The job is over: it failed.
    Failed,
    /// The job is over: somebody asked for that.
    Canceled,
}

impl EventKind {
    /// Every kind.
    pub const ALL: [EventKind; 8] = [
        EventKind::Stage,
        EventKind::Progress,
        EventKind::PartCompleted,
        EventKind::Warning,
        EventKind::Retrying,
        EventKind::Succeeded,
        EventKind::Failed,
        EventKind::Canceled,
    ];

    /// The kind as it is written in streams and in the database.
    pub fn as_str(self) -> &'static str {
        match self {
            EventKind::Stage => "stage",
            EventKind::Progress => "progress",
            EventKind::PartCompleted => "part_completed",
            EventKind::Warning => "warning",
            EventKind::Retrying => "retrying",
            EventKind::Succeeded => "succeeded",
            EventKind::Failed => "failed",
            EventKind::Canceled => "canceled",
        }
    }

    /// Whether no event of the job follows.
    pub fn is_terminal(self) -> bool {
        matches!(self, EventKind::Succeeded | EventKind::Failed | EventKind::Canceled)
    }
}

impl FromStr for EventKind {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = EventKind::ALL.into_iter().find(|kind| kind.as_str() == text);
        found.ok_or_else(|| format!("unknown kind of event {text:?}"))
    }
}

/// An event that is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct NewEvent {
    /// What happened.
    pub data: EventData,
    /// When.
    pub at: Timestamp,
}

impl NewEvent {
    /// An event of this moment.
    pub fn now(data: EventData) -> Self {
        Self { data, at: Timestamp::now() }
    }

    /// What kind of event it is.
    pub fn kind(&self) -> EventKind {
        self.data.kind()
    }
}

/// An event that was written. Rows never change and are only deleted with their job.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Grows over all jobs, in the order of commits: the id in `/v1/events`.
    pub event_id: i64,
    /// Whose event it is.
    pub job_id: JobId,
    /// 1, 2, 3, … within the job: the id in the job's own stream.
    pub seq: u64,
    /// What happened.
    pub data: EventData,
    /// When.
    pub at: Timestamp,
}

impl Event {
    /// What kind of event it is.
    pub fn kind(&self) -> EventKind {
        self.data.kind()
    }
}
