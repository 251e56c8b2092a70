//! Rows of `job_events`: written by whoever changes a job, in the same transaction.

use jiff::Timestamp;
use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{AssertSqlSafe, Row};

use super::rows::{self, read, time};
use super::{Event, JobId, QueueError, SqliteQueue};
use crate::jobs::EventData;
use crate::jobs::states::Change;

const SELECT: &str = "SELECT event_id, job_id, seq, kind, data, at FROM job_events";

/// Write the events of a change, the last of which has the job's latest number.
pub async fn append(
    connection: &mut SqliteConnection,
    id: JobId,
    change: &Change,
) -> Result<(), QueueError> {
    let first = change.standing.last_seq + 1 - change.events.len() as u64;
    for (event, seq) in change.events.iter().zip(first..) {
        sqlx::query("INSERT INTO job_events (job_id, seq, kind, data, at) VALUES (?, ?, ?, ?, ?)")
            .bind(id.to_string())
            .bind(seq as i64)
            .bind(event.kind().as_str())
            .bind(rows::json(&event.data)?)
            .bind(event.at.as_microsecond())
            .execute(&mut *connection)
            .await?;
    }
    Ok(())
}

/// Events of one job.
pub async fn of_job(
    queue: &SqliteQueue,
    id: JobId,
    after: u64,
    limit: u32,
) -> Result<Vec<Event>, QueueError> {
    let sql = format!("{SELECT} WHERE job_id = ? AND seq > ? ORDER BY seq LIMIT ?");
    let rows = sqlx::query(AssertSqlSafe(sql))
        .bind(id.to_string())
        .bind(i64::try_from(after).unwrap_or(i64::MAX))
        .bind(limit)
        .fetch_all(&queue.reader)
        .await?;
    rows.iter().map(event).collect()
}

/// Events of all jobs.
pub async fn of_all(queue: &SqliteQueue, after: i64, limit: u32) -> Result<Vec<Event>, QueueError> {
    let sql = format!("{SELECT} WHERE event_id > ? ORDER BY event_id LIMIT ?");
    let rows =
        sqlx::query(AssertSqlSafe(sql)).bind(after).bind(limit).fetch_all(&queue.reader).await?;
    rows.iter().map(event).collect()
}

/// The greatest `event_id` that was ever given, deleted rows included.
pub async fn last_id(queue: &SqliteQueue) -> Result<i64, QueueError> {
    let last = sqlx::query_scalar("SELECT seq FROM sqlite_sequence WHERE name = 'job_events'")
        .fetch_optional(&queue.reader)
        .await?;
    Ok(last.unwrap_or(0))
}

fn event(row: &SqliteRow) -> Result<Event, QueueError> {
    let event_id: i64 = row.try_get("event_id")?;
    let bad = |why: String| QueueError::Row { what: format!("event {event_id}"), why };
    let kind: String = row.try_get("kind")?;
    let json: String = row.try_get("data")?;
    let data = EventData::read(kind.parse().map_err(bad)?, &json);
    let at: Option<Timestamp> = time(row.try_get("at")?);
    Ok(Event {
        event_id,
        job_id: read(row, "job_id")?,
        seq: row.try_get::<i64, _>("seq")?.unsigned_abs(),
        data: data.map_err(|error| bad(error.to_string()))?,
        at: at.unwrap_or_default(),
    })
}
