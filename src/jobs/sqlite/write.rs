//! What a transition says is to be written, written: always within a transaction that holds the
//! write lock and read the row before.

use sqlx::QueryBuilder;
use sqlx::sqlite::SqliteConnection;

use super::{JobId, NewJob, QueueError, events, rows, since_epoch};
use crate::jobs::states::{Change, Standing};
use crate::jobs::{StoredArtifact, StoredInput};

/// A new job and the blobs that it names.
pub async fn insert(
    connection: &mut SqliteConnection,
    job: &NewJob,
    standing: &Standing,
) -> Result<(), QueueError> {
    sqlx::query(
        "INSERT INTO jobs (id, state, priority, tag, options, max_attempts, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id.to_string())
    .bind(standing.state.as_str())
    .bind(job.priority)
    .bind(&job.tag)
    .bind(rows::json(&job.options)?)
    .bind(standing.max_attempts)
    .bind(standing.created_at.as_microsecond())
    .execute(&mut *connection)
    .await?;
    for (input, position) in job.inputs.iter().zip(0i64..) {
        take(connection, job.id, input, position).await?;
    }
    Ok(())
}

async fn take(
    connection: &mut SqliteConnection,
    id: JobId,
    input: &StoredInput,
    position: i64,
) -> Result<(), QueueError> {
    sqlx::query(
        "INSERT INTO job_inputs (job_id, position, role, name, kind, sha256, bytes, blob)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(id.to_string())
    .bind(position)
    .bind(input.role.as_str())
    .bind(&input.name)
    .bind(rows::kind_word(input.kind)?)
    .bind(&input.sha256)
    .bind(i64::try_from(input.bytes).unwrap_or(i64::MAX))
    .bind(&input.blob)
    .execute(&mut *connection)
    .await?;
    name(connection, id, &input.blob).await
}

/// A change of a job that stood as in `before`. Returns the blobs that may go.
pub async fn change(
    connection: &mut SqliteConnection,
    id: JobId,
    before: &Standing,
    change: &Change,
) -> Result<Vec<String>, QueueError> {
    if change.standing != *before {
        standing(connection, id, before, &change.standing).await?;
    }
    events::append(connection, id, change).await?;
    for (artifact, position) in change.effects.artifacts.iter().zip(0i64..) {
        store(connection, id, artifact, position).await?;
    }
    let mut gone = Vec::new();
    if change.effects.blobs_may_go {
        gone = sqlx::query_scalar("SELECT name FROM blobs WHERE job_id = ? ORDER BY name")
            .bind(id.to_string())
            .fetch_all(&mut *connection)
            .await?;
        sqlx::query("DELETE FROM blobs WHERE job_id = ?")
            .bind(id.to_string())
            .execute(&mut *connection)
            .await?;
    }
    if change.effects.row_goes {
        sqlx::query("DELETE FROM jobs WHERE id = ?")
            .bind(id.to_string())
            .execute(connection)
            .await?;
    }
    Ok(gone)
}

/// Only columns whose value is another are written, so that no index is touched in vain and what was
/// stored as JSON stays as it was.
async fn standing(
    connection: &mut SqliteConnection,
    id: JobId,
    before: &Standing,
    after: &Standing,
) -> Result<(), QueueError> {
    let mut query = QueryBuilder::new("UPDATE jobs SET ");
    let mut set = query.separated(", ");
    // `set!(field: "column" = value)` writes the column where the field differs.
    macro_rules! set {
        ($field:ident: $($column:literal = $value:expr),+) => {
            if before.$field != after.$field {
                $(set.push(concat!($column, " = ")).push_bind_unseparated($value);)+
            }
        };
    }
    let held = after.held.as_ref();
    let word = |word: Option<&String>| word.cloned().unwrap_or_default();
    set!(state: "state" = after.state.as_str());
    set!(attempt: "attempt" = after.attempt);
    set!(cancel_requested: "cancel_requested" = after.cancel_requested);
    set!(held: "worker" = word(held.map(|held| &held.worker)),
        "lease" = word(held.map(|held| &held.token)),
        "lease_until" = since_epoch(held.map(|held| held.until)));
    set!(progress: "progress" = rows::json(&after.progress)?);
    set!(versions: "engine" = after.versions.engine.clone(),
        "weights" = word(after.versions.weights.as_ref()));
    set!(device: "device" = word(after.device.as_ref()));
    set!(metrics: "metrics" = rows::json(&after.metrics)?);
    set!(error: "error" = rows::json(&after.error)?);
    set!(started_at: "started_at" = since_epoch(after.started_at));
    set!(finished_at: "finished_at" = since_epoch(after.finished_at));
    set!(expires_at: "expires_at" = since_epoch(after.expires_at));
    set!(expired: "expired" = after.expired);
    set!(last_seq: "last_seq" = after.last_seq as i64);
    set!(revision: "revision" = after.revision as i64);
    query.push(" WHERE id = ").push_bind(id.to_string());
    query.build().execute(connection).await?;
    Ok(())
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
    name(connection, id, &artifact.blob).await
}

/// Name a blob, so that it is no orphan.
async fn name(connection: &mut SqliteConnection, id: JobId, blob: &str) -> Result<(), QueueError> {
    sqlx::query("INSERT INTO blobs (name, job_id) VALUES (?, ?)")
        .bind(blob)
        .bind(id.to_string())
        .execute(connection)
        .await?;
    Ok(())
}
