//! What clients do to jobs: submit, list, cancel, delete.

use super::transitions::{Over, over};
use super::{
    CancelOutcome, Deleted, Job, JobId, JobState, ListFilter, NewJob, Page, QueueError,
    SqliteQueue, now_us, rows,
};

/// Jobs on a page if nobody says how many, and at most.
const PAGE: (u32, u32) = (20, 100);

pub async fn submit(queue: &SqliteQueue, job: NewJob, limit: u64) -> Result<Job, QueueError> {
    let mut tx = queue.begin().await?;
    let waiting: i64 = sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state = 'queued'")
        .fetch_one(&mut *tx)
        .await?;
    if waiting.unsigned_abs() >= limit {
        return Err(QueueError::Full { limit });
    }
    let kind = rows::json(&job.kind)?;
    sqlx::query(
        "INSERT INTO jobs (id, state, priority, tag, kind, upload, labels, options, max_attempts,
                           created_at)
         VALUES (?, 'queued', ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id.to_string())
    .bind(job.priority)
    .bind(&job.tag)
    .bind(kind.trim_matches('"'))
    .bind(&job.upload)
    .bind(job.labels.as_deref().unwrap_or_default())
    .bind(rows::json(&job.options)?)
    .bind(queue.config.max_attempts)
    .bind(now_us())
    .execute(&mut *tx)
    .await?;
    for blob in std::iter::once(&job.upload).chain(&job.labels) {
        sqlx::query("INSERT INTO blobs (name, job_id) VALUES (?, ?)")
            .bind(blob)
            .bind(job.id.to_string())
            .execute(&mut *tx)
            .await?;
    }
    let stored = rows::job(&mut tx, job.id).await?.ok_or_else(|| missing(job.id))?;
    tx.commit().await?;
    Ok(stored)
}

/// Ids sort by age, so the id of a page's last job says where the next page begins.
pub async fn list(queue: &SqliteQueue, filter: &ListFilter) -> Result<Page, QueueError> {
    let limit = if filter.limit == 0 { PAGE.0 } else { filter.limit.min(PAGE.1) };
    let mut query = rows::select();
    query.push("TRUE");
    if let Some(state) = filter.state {
        query.push(" AND state = ").push_bind(state.as_str());
    }
    if let Some(tag) = &filter.tag {
        query.push(" AND tag = ").push_bind(tag.clone());
    }
    if let Some(cursor) = &filter.cursor {
        let before: JobId = cursor.parse().map_err(|_| QueueError::Cursor)?;
        query.push(" AND id < ").push_bind(before.to_string());
    }
    // One more than asked for tells whether there is another page.
    query.push(" ORDER BY id DESC LIMIT ").push_bind(limit + 1);
    let mut jobs = rows::jobs(&mut *queue.snapshot().await?, query).await?;
    let more = jobs.len() > limit as usize;
    jobs.truncate(limit as usize);
    let next_cursor = jobs.last().filter(|_| more).map(|job| job.id.to_string());
    Ok(Page { jobs, next_cursor })
}

pub async fn request_cancel(queue: &SqliteQueue, id: JobId) -> Result<CancelOutcome, QueueError> {
    let mut tx = queue.begin().await?;
    let Some(job) = rows::job(&mut tx, id).await? else { return Ok(CancelOutcome::NotFound) };
    match job.state {
        state if state.is_terminal() => return Ok(CancelOutcome::Over(job)),
        JobState::Queued => over(&mut tx, &queue.config, id, Over::Canceled).await?,
        _ if job.cancel_requested => return Ok(CancelOutcome::Requested(job)),
        _ => {
            sqlx::query(
                "UPDATE jobs SET cancel_requested = 1, revision = revision + 1 WHERE id = ?",
            )
            .bind(id.to_string())
            .execute(&mut *tx)
            .await?;
        }
    }
    let job = rows::job(&mut tx, id).await?.ok_or_else(|| missing(id))?;
    tx.commit().await?;
    Ok(match job.state.is_terminal() {
        true => CancelOutcome::Over(job),
        false => CancelOutcome::Requested(job),
    })
}

pub async fn delete(queue: &SqliteQueue, id: JobId) -> Result<Deleted, QueueError> {
    let mut tx = queue.begin().await?;
    let Some(job) = rows::job(&mut tx, id).await? else { return Ok(Deleted::NotFound) };
    if !job.state.is_terminal() {
        return Ok(Deleted::NotTerminal);
    }
    let blobs = sqlx::query_scalar("SELECT name FROM blobs WHERE job_id = ? ORDER BY name")
        .bind(id.to_string())
        .fetch_all(&mut *tx)
        .await?;
    sqlx::query("DELETE FROM jobs WHERE id = ?").bind(id.to_string()).execute(&mut *tx).await?;
    tx.commit().await?;
    Ok(Deleted::Deleted { blobs })
}

/// A row that this very transaction wrote or read is not there.
fn missing(id: JobId) -> QueueError {
    QueueError::Row { what: format!("job {id}"), why: "it vanished within a transaction".into() }
}
