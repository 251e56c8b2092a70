//! The ways in which a job leaves `running` or `queued`: it is over, or it waits again. Each is part
//! of a transaction that holds the write lock.

use serde_json::json;
use sqlx::Row;
use sqlx::sqlite::SqliteConnection;

use super::rows::{self, read};
use super::{JobId, JobState, NewEvent, QueueError, SqliteConfig, Swept, events, micros, now_us};
use crate::contract::{ErrorCode, JobError};
use crate::jobs::{EventKind, MetricsSummary, StoredArtifact};

/// How a job is over.
pub enum Over {
    Succeeded(Option<MetricsSummary>, Vec<StoredArtifact>),
    Failed(JobError, Vec<StoredArtifact>),
    Canceled,
}

impl Over {
    pub fn state(&self) -> JobState {
        match self {
            Over::Succeeded(..) => JobState::Succeeded,
            Over::Failed(..) => JobState::Failed,
            Over::Canceled => JobState::Canceled,
        }
    }
}

/// End a job: its state, its files, its last event.
pub async fn over(
    connection: &mut SqliteConnection,
    config: &SqliteConfig,
    id: JobId,
    over: Over,
) -> Result<(), QueueError> {
    let state = over.state();
    let attempt: u32 = sqlx::query_scalar("SELECT attempt FROM jobs WHERE id = ?")
        .bind(id.to_string())
        .fetch_one(&mut *connection)
        .await?;
    let (metrics, error, artifacts) = match over {
        Over::Succeeded(metrics, artifacts) => (metrics, None, artifacts),
        Over::Failed(error, artifacts) => (None, Some(error), artifacts),
        Over::Canceled => (None, None, Vec::new()),
    };
    let now = now_us();
    sqlx::query(
        "UPDATE jobs SET state = ?, metrics = ?, error = ?, finished_at = ?, expires_at = ?,
             worker = '', lease = '', lease_until = 0, revision = revision + 1
         WHERE id = ?",
    )
    .bind(state.as_str())
    .bind(rows::json(&metrics)?)
    .bind(rows::json(&error)?)
    .bind(now)
    .bind(now.saturating_add(micros(config.retention)))
    .bind(id.to_string())
    .execute(&mut *connection)
    .await?;
    for (artifact, position) in artifacts.iter().zip(0i64..) {
        store(connection, id, artifact, position).await?;
    }
    let names: Vec<&str> = artifacts.iter().map(|artifact| artifact.name.as_str()).collect();
    let (kind, data) = match state {
        JobState::Succeeded => (
            EventKind::Succeeded,
            json!({"state": state, "attempt": attempt, "metrics": metrics, "artifacts": names}),
        ),
        JobState::Failed => {
            (EventKind::Failed, json!({"state": state, "attempt": attempt, "error": error}))
        }
        _ => (EventKind::Canceled, json!({"state": state, "attempt": attempt})),
    };
    events::append(connection, id, &[NewEvent::now(kind, data)]).await
}

async fn store(
    connection: &mut SqliteConnection,
    id: JobId,
    artifact: &StoredArtifact,
    position: i64,
) -> Result<(), QueueError> {
    sqlx::query(
        "INSERT INTO artifacts (job_id, position, name, media_type, bytes, sha256, blob)
         VALUES (?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(id.to_string())
    .bind(position)
    .bind(&artifact.name)
    .bind(&artifact.media_type)
    .bind(i64::try_from(artifact.bytes).unwrap_or(i64::MAX))
    .bind(&artifact.sha256)
    .bind(&artifact.blob)
    .execute(&mut *connection)
    .await?;
    sqlx::query("INSERT INTO blobs (name, job_id) VALUES (?, ?)")
        .bind(&artifact.blob)
        .bind(id.to_string())
        .execute(connection)
        .await?;
    Ok(())
}

/// Why a job waits again.
pub enum Again {
    /// Its attempt is spent.
    After(JobError),
    /// Its worker shut down: the attempt does not count.
    Draining,
}

/// Let a job wait again. It keeps its id and so its age: it is first among its priority.
pub async fn requeue(
    connection: &mut SqliteConnection,
    id: JobId,
    again: Again,
) -> Result<(), QueueError> {
    let (attempt, max_attempts): (u32, u32) =
        sqlx::query_as("SELECT attempt, max_attempts FROM jobs WHERE id = ?")
            .bind(id.to_string())
            .fetch_one(&mut *connection)
            .await?;
    let (spent, code, message) = match again {
        Again::After(error) => (attempt, error.code.as_str(), error.message),
        Again::Draining => {
            (attempt.saturating_sub(1), "draining", "the worker shut down in the middle".into())
        }
    };
    sqlx::query(
        "UPDATE jobs SET state = 'queued', attempt = ?, progress = 'null', started_at = 0,
             worker = '', lease = '', lease_until = 0, revision = revision + 1
         WHERE id = ?",
    )
    .bind(spent)
    .bind(id.to_string())
    .execute(&mut *connection)
    .await?;
    let data = json!({
        "attempt": attempt, "max_attempts": max_attempts, "code": code, "message": message,
    });
    events::append(connection, id, &[NewEvent::now(EventKind::Retrying, data)]).await
}

/// Whose jobs to take back.
pub enum Gone<'a> {
    /// Of this worker.
    Worker(&'a str),
    /// Of any whose lease has lapsed.
    Lapsed,
}

/// Take back the jobs of workers that are gone. The crash counts as an attempt; a job that has none
/// left fails, one that somebody wanted to stop is canceled.
pub async fn take_back(
    connection: &mut SqliteConnection,
    config: &SqliteConfig,
    gone: Gone<'_>,
) -> Result<Swept, QueueError> {
    const COLUMNS: &str = "SELECT id, attempt, max_attempts, cancel_requested FROM jobs";
    let mut query = sqlx::QueryBuilder::new(COLUMNS);
    query.push(" WHERE state = 'running' AND ");
    let how = match gone {
        Gone::Worker(worker) => {
            query.push("worker = ").push_bind(worker.to_string());
            "the worker process died"
        }
        Gone::Lapsed => {
            query.push("lease_until < ").push_bind(now_us());
            "the worker was not heard of any more"
        }
    };
    let mut swept = Swept::default();
    for row in query.build().fetch_all(&mut *connection).await? {
        let id: JobId = read(&row, "id")?;
        let (attempt, most): (u32, u32) = (row.try_get("attempt")?, row.try_get("max_attempts")?);
        let message = format!("{how} while it ran the job (attempt {attempt} of {most})");
        let error = JobError::new(ErrorCode::WorkerCrashed, message);
        if row.try_get("cancel_requested")? {
            over(connection, config, id, Over::Canceled).await?;
            swept.canceled += 1;
        } else if attempt < most {
            requeue(connection, id, Again::After(error)).await?;
            swept.requeued += 1;
        } else {
            over(connection, config, id, Over::Failed(error, Vec::new())).await?;
            swept.failed += 1;
        }
    }
    Ok(swept)
}
