//! What each kind of event has to say. The same shapes stand in the rows, in the streams and in the
//! OpenAPI document.

use serde::{Deserialize, Serialize};
use utoipa::openapi::schema::AnyOfBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::{EventKind, JobProgress, JobState, MetricsSummary};
use crate::contract::{ErrorCode, JobError, Stage, WarningCode};

/// `event_data! { "What happened." Kind(Data) … }` makes the sum of what events have to say: one line
/// a kind.
macro_rules! event_data {
    ($($about:literal $kind:ident($data:ident),)*) => {
        /// The particulars of an event. Its kind stands beside it, so it is written without a tag.
        #[derive(Debug, Clone, PartialEq, Serialize)]
        #[serde(untagged)]
        pub enum EventData {
            $(#[doc = $about] $kind($data),)*
        }

        impl EventData {
            /// What kind of event this is.
            pub fn kind(&self) -> EventKind {
                match self { $(EventData::$kind(_) => EventKind::$kind,)* }
            }

            /// Read what was written for an event of this kind.
            pub fn read(kind: EventKind, json: &str) -> Result<Self, serde_json::Error> {
                match kind {
                    $(EventKind::$kind => serde_json::from_str(json).map(EventData::$kind),)*
                }
            }
        }

        // Not derived, for that says "one of": the data of `warning` are among those of `retrying`.
        impl PartialSchema for EventData {
            fn schema() -> RefOr<Schema> {
                AnyOfBuilder::new()
                    $(.item(Ref::from_schema_name($data::name())))*
                    .description(Some("What an event has to say, by its kind."))
                    .into()
            }
        }

        impl ToSchema for EventData {
            fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
                $(
                    schemas.push(($data::name().into(), $data::schema()));
                    $data::schemas(schemas);
                )*
            }
        }
    };
}

event_data! {
    "A stage begins." Stage(StageEvent),
    "A stage goes on, at most twice a second." Progress(JobProgress),
    "All charts of a part are final." PartCompleted(PartCompletedEvent),
    "Something the user should know." Warning(WarningEvent),
    "The attempt is over but not the job." Retrying(RetryingEvent),
    "The job is over: the artifacts are there." Succeeded(SucceededEvent),
    "The job is over: it failed." Failed(FailedEvent),
    "The job is over: somebody asked for that." Canceled(CanceledEvent),
}

/// Data of `stage`: a stage begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct StageEvent {
    /// The attempt that runs.
    pub attempt: u32,
    /// The stage.
    pub stage: Stage,
}

/// Data of `part_completed`: all charts of a part are final.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PartCompletedEvent {
    /// The part.
    pub part: u32,
    /// Its name.
    pub name: String,
    /// How many charts it has.
    pub charts: u32,
    /// Its symmetric Dirichlet energy, 1 is isometric; null where it has none.
    #[schema(required)]
    pub symmetric_dirichlet: Option<f64>,
}

/// Data of `warning`: something the user should know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WarningEvent {
    /// Its kind, of the table of warnings.
    pub code: WarningCode,
    /// A sentence.
    pub message: String,
}

/// Data of `retrying`: the attempt is over but not the job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RetryingEvent {
    /// The attempt that ended.
    pub attempt: u32,
    /// After this many attempts that ended in a crash the job fails.
    pub max_attempts: u32,
    /// Why it ended; `draining` where the worker shut down, which spends no attempt.
    pub code: ErrorCode,
    /// Why, in a sentence.
    pub message: String,
}

/// Data of `succeeded`: the job is over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SucceededEvent {
    /// Always `succeeded`.
    pub state: JobState,
    /// The attempt that ended.
    pub attempt: u32,
    /// The result at a glance.
    #[schema(required)]
    pub metrics: Option<MetricsSummary>,
    /// Names of the files that it made.
    pub artifacts: Vec<String>,
}

/// Data of `failed`: the job is over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FailedEvent {
    /// Always `failed`.
    pub state: JobState,
    /// The attempt that ended.
    pub attempt: u32,
    /// Why.
    pub error: JobError,
}

/// Data of `canceled`: the job is over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CanceledEvent {
    /// Always `canceled`.
    pub state: JobState,
    /// The attempt that ended; 0 where none had begun.
    pub attempt: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the rows of released versions hold: these lines may be added to, never changed.
    #[test]
    fn every_kind_is_written_and_read_as_ever() {
        let progress = JobProgress {
            stage: Stage::Train,
            fraction: 0.25,
            parts_done: 1,
            parts_total: 4,
            eta_s: None,
        };
        let part = |symmetric_dirichlet| {
            EventData::PartCompleted(PartCompletedEvent {
                part: 2,
                name: "leg".into(),
                charts: 3,
                symmetric_dirichlet,
            })
        };
        let error = JobError::new(ErrorCode::InvalidMesh, "no faces");
        let lines = [
            (
                EventData::Stage(StageEvent { attempt: 1, stage: Stage::Pack }),
                r#"{"attempt":1,"stage":"pack"}"#,
            ),
            (
                EventData::Progress(progress),
                r#"{"stage":"train","fraction":0.25,"parts_done":1,"parts_total":4,"eta_s":null}"#,
            ),
            (part(Some(1.5)), r#"{"part":2,"name":"leg","charts":3,"symmetric_dirichlet":1.5}"#),
            (part(None), r#"{"part":2,"name":"leg","charts":3,"symmetric_dirichlet":null}"#),
            (
                EventData::Warning(WarningEvent {
                    code: WarningCode::Degraded,
                    message: "y".into(),
                }),
                r#"{"code":"degraded","message":"y"}"#,
            ),
            (
                EventData::Retrying(RetryingEvent {
                    attempt: 1,
                    max_attempts: 3,
                    code: ErrorCode::Draining,
                    message: "gone".into(),
                }),
                r#"{"attempt":1,"max_attempts":3,"code":"draining","message":"gone"}"#,
            ),
            (
                EventData::Succeeded(SucceededEvent {
                    state: JobState::Succeeded,
                    attempt: 2,
                    metrics: None,
                    artifacts: vec!["model.glb".into()],
                }),
                r#"{"state":"succeeded","attempt":2,"metrics":null,"artifacts":["model.glb"]}"#,
            ),
            (
                EventData::Failed(FailedEvent { state: JobState::Failed, attempt: 3, error }),
                r#"{"state":"failed","attempt":3,"error":{"code":"invalid_mesh","message":"no faces"}}"#,
            ),
            (
                EventData::Canceled(CanceledEvent { state: JobState::Canceled, attempt: 0 }),
                r#"{"state":"canceled","attempt":0}"#,
            ),
        ];
        for (data, json) in lines {
            assert_eq!(serde_json::to_string(&data).unwrap(), json);
            assert_eq!(EventData::read(data.kind(), json).unwrap(), data);
        }
        assert!(EventData::read(EventKind::Failed, r#"{"state":"failed"}"#).is_err());
    }
}
