//! Rows of `jobs` and `artifacts` as values.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use jiff::Timestamp;
use serde::de::DeserializeOwned;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{QueryBuilder, Row, Sqlite};

use super::{Job, JobId, NewJob, QueueError, now};
use crate::contract::MeshKind;
use crate::jobs::states::{Held, Standing};
use crate::jobs::{Inputs, StoredArtifact, StoredInput, Versions};

/// What every read of jobs begins with.
const SELECT: &str = "
    SELECT jobs.*, CASE state WHEN 'queued' THEN (
        SELECT count(*) FROM jobs AS ahead
        WHERE ahead.state = 'queued' AND (ahead.priority > jobs.priority
            OR (ahead.priority = jobs.priority AND ahead.id < jobs.id))
    ) ELSE 0 END AS queue_position
    FROM jobs WHERE ";

/// A query of jobs, to be continued with a condition.
pub fn select() -> QueryBuilder<Sqlite> {
    QueryBuilder::new(SELECT)
}

/// One job.
pub async fn job(connection: &mut SqliteConnection, id: JobId) -> Result<Option<Job>, QueueError> {
    let mut query = select();
    query.push("id = ").push_bind(id.to_string());
    Ok(jobs(connection, query).await?.pop())
}

/// The jobs that `query` (from [`select`]) finds, in its order, with their files.
pub async fn jobs(
    connection: &mut SqliteConnection,
    mut query: QueryBuilder<Sqlite>,
) -> Result<Vec<Job>, QueueError> {
    let rows = query.build().fetch_all(&mut *connection).await?;
    let mut jobs: Vec<Job> = rows.iter().map(job_of).collect::<Result<_, _>>()?;
    let ids: Vec<String> = jobs.iter().map(|job| job.id.to_string()).collect();
    let mut inputs = of_jobs(connection, "job_inputs", &ids, input_of).await?;
    let mut artifacts = of_jobs(connection, "artifacts", &ids, artifact_of).await?;
    for job in &mut jobs {
        job.inputs = inputs.remove(&job.id).unwrap_or_default().into_iter().collect();
        job.artifacts = artifacts.remove(&job.id).unwrap_or_default();
    }
    Ok(jobs)
}

/// The rows that belong to these jobs, by job, in their order.
async fn of_jobs<T>(
    connection: &mut SqliteConnection,
    table: &str,
    ids: &[String],
    value: fn(&SqliteRow) -> Result<T, QueueError>,
) -> Result<BTreeMap<JobId, Vec<T>>, QueueError> {
    let mut query = QueryBuilder::new("SELECT * FROM ");
    query.push(table).push(" WHERE job_id IN (SELECT value FROM json_each(");
    query.push_bind(json(&ids)?).push(")) ORDER BY job_id, position");
    let mut found: BTreeMap<JobId, Vec<T>> = BTreeMap::new();
    for row in &query.build().fetch_all(connection).await? {
        found.entry(read(row, "job_id")?).or_default().push(value(row)?);
    }
    Ok(found)
}

/// How a job stands.
pub async fn standing(
    connection: &mut SqliteConnection,
    id: JobId,
) -> Result<Option<Standing>, QueueError> {
    let row = sqlx::query("SELECT * FROM jobs WHERE id = ?").bind(id.to_string());
    row.fetch_optional(connection).await?.as_ref().map(standing_of).transpose()
}

/// How the job of a row stands.
pub fn standing_of(row: &SqliteRow) -> Result<Standing, QueueError> {
    let held = match word(row, "lease")? {
        Some(token) => Some(Held {
            worker: row.try_get("worker")?,
            token,
            until: time(row.try_get("lease_until")?).unwrap_or_default(),
        }),
        None => None,
    };
    Ok(Standing {
        state: read(row, "state")?,
        attempt: row.try_get("attempt")?,
        max_attempts: row.try_get("max_attempts")?,
        cancel_requested: row.try_get("cancel_requested")?,
        held,
        progress: from_json(row, "progress")?,
        versions: Versions { engine: row.try_get("engine")?, weights: word(row, "weights")? },
        device: word(row, "device")?,
        metrics: from_json(row, "metrics")?,
        error: from_json(row, "error")?,
        created_at: time(row.try_get("created_at")?).unwrap_or_default(),
        started_at: time(row.try_get("started_at")?),
        finished_at: time(row.try_get("finished_at")?),
        expires_at: time(row.try_get("expires_at")?),
        expired: row.try_get("expired")?,
        last_seq: row.try_get::<i64, _>("last_seq")?.unsigned_abs(),
        revision: row.try_get::<i64, _>("revision")?.unsigned_abs(),
    })
}

/// What its client gave.
fn given(row: &SqliteRow) -> Result<NewJob, QueueError> {
    Ok(NewJob {
        id: read(row, "id")?,
        inputs: Inputs::default(),
        options: from_json(row, "options")?,
        tag: row.try_get("tag")?,
        priority: row.try_get("priority")?,
    })
}

fn job_of(row: &SqliteRow) -> Result<Job, QueueError> {
    let queue_position = row.try_get::<i64, _>("queue_position")?.unsigned_abs();
    Ok(standing_of(row)?.job(given(row)?, Vec::new(), queue_position, now()))
}

fn input_of(row: &SqliteRow) -> Result<StoredInput, QueueError> {
    Ok(StoredInput {
        role: read(row, "role")?,
        name: row.try_get("name")?,
        kind: mesh_kind(row)?,
        sha256: row.try_get("sha256")?,
        bytes: row.try_get::<i64, _>("bytes")?.unsigned_abs(),
        blob: row.try_get("blob")?,
    })
}

fn artifact_of(row: &SqliteRow) -> Result<StoredArtifact, QueueError> {
    Ok(StoredArtifact {
        name: row.try_get("name")?,
        media_type: row.try_get("media_type")?,
        bytes: row.try_get::<i64, _>("bytes")?.unsigned_abs(),
        sha256: row.try_get("sha256")?,
        blob: row.try_get("blob")?,
    })
}

/// A time as it is stored; 0 is none.
pub fn time(micros: i64) -> Option<Timestamp> {
    if micros == 0 { None } else { Timestamp::from_microsecond(micros).ok() }
}

/// JSON as it is stored.
pub fn json(value: &impl serde::Serialize) -> Result<String, QueueError> {
    serde_json::to_string(value).map_err(|error| QueueError::Database(Box::new(error)))
}

/// A column whose text is read by `FromStr`.
pub fn read<T: FromStr<Err: Display>>(row: &SqliteRow, column: &str) -> Result<T, QueueError> {
    let text: String = row.try_get(column)?;
    text.parse().map_err(|error: T::Err| bad(row, column, &error))
}

fn from_json<T: DeserializeOwned>(row: &SqliteRow, column: &str) -> Result<T, QueueError> {
    let text: String = row.try_get(column)?;
    serde_json::from_str(&text).map_err(|error| bad(row, column, &error))
}

/// A kind of mesh is stored as its JSON word, without the quotes; none is empty.
pub fn kind_word(kind: Option<MeshKind>) -> Result<String, QueueError> {
    let word = kind.map(|kind| json(&kind)).transpose()?;
    Ok(word.unwrap_or_default().trim_matches('"').to_owned())
}

fn mesh_kind(row: &SqliteRow) -> Result<Option<MeshKind>, QueueError> {
    let kind = word(row, "kind")?.map(|word| serde_json::from_value(word.into()));
    kind.transpose().map_err(|error| bad(row, "kind", &error))
}

/// A text that may be empty, which means none.
pub fn word(row: &SqliteRow, column: &str) -> Result<Option<String>, QueueError> {
    let text: String = row.try_get(column)?;
    Ok(if text.is_empty() { None } else { Some(text) })
}

fn bad(row: &SqliteRow, column: &str, error: &dyn Display) -> QueueError {
    let id: Result<String, _> = row.try_get("id").or_else(|_| row.try_get("job_id"));
    QueueError::Row {
        what: format!("job {}", id.unwrap_or_default()),
        why: format!("{column}: {error}"),
    }
}
