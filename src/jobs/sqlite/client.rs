//! What clients do to jobs: submit, list, cancel, delete.

use super::{
    CancelOutcome, Deleted, Job, JobId, ListFilter, NewJob, Page, QueueError, SqliteQueue, now,
    rows, write,
};
use crate::jobs::states::{self, Command, Refusal, apply};

pub async fn submit(queue: &SqliteQueue, job: NewJob, limit: u64) -> Result<Job, QueueError> {
    let mut tx = queue.begin().await?;
    let waiting: i64 = sqlx::query_scalar("SELECT count(*) FROM jobs WHERE state = 'queued'")
        .fetch_one(&mut *tx)
        .await?;
    let standing = states::submit(waiting.unsigned_abs(), limit, &queue.policy, now())?;
    write::insert(&mut tx, &job, &standing).await?;
    let stored = rows::job(&mut tx, job.id).await?.ok_or_else(|| missing(job.id))?;
    tx.commit().await?;
    Ok(stored)
}

pub async fn list(queue: &SqliteQueue, filter: &ListFilter) -> Result<Page, QueueError> {
    let mut query = rows::select();
    query.push("TRUE");
    if let Some(state) = filter.state {
        query.push(" AND state = ").push_bind(state.as_str());
    }
    if let Some(tag) = &filter.tag {
        query.push(" AND tag = ").push_bind(tag.clone());
    }
    if let Some(after) = filter.after()? {
        query.push(" AND id < ").push_bind(after.to_string());
    }
    // One more than asked for tells whether there is another page.
    query.push(" ORDER BY id DESC LIMIT ").push_bind(filter.page() + 1);
    let jobs = rows::jobs(&mut *queue.snapshot().await?, query).await?;
    Ok(Page::of(filter, jobs))
}

pub async fn request_cancel(queue: &SqliteQueue, id: JobId) -> Result<CancelOutcome, QueueError> {
    let mut tx = queue.begin().await?;
    let before = rows::standing(&mut tx, id).await?;
    let Some(before) = before else { return Ok(CancelOutcome::NotFound) };
    let change = apply(&before, Command::RequestCancel, &queue.policy, now())?;
    write::change(&mut tx, id, &before, &change).await?;
    let job = rows::job(&mut tx, id).await?.ok_or_else(|| missing(id))?;
    tx.commit().await?;
    Ok(match job.state.is_terminal() {
        true => CancelOutcome::Over(job),
        false => CancelOutcome::Requested(job),
    })
}

pub async fn delete(queue: &SqliteQueue, id: JobId) -> Result<Deleted, QueueError> {
    let mut tx = queue.begin().await?;
    let before = rows::standing(&mut tx, id).await?;
    let Some(before) = before else { return Ok(Deleted::NotFound) };
    let change = match apply(&before, Command::Delete, &queue.policy, now()) {
        Err(Refusal::NotOver) => return Ok(Deleted::NotTerminal),
        change => change?,
    };
    let blobs = write::change(&mut tx, id, &before, &change).await?;
    tx.commit().await?;
    Ok(Deleted::Deleted { blobs })
}

/// A row that this very transaction wrote or read is not there.
fn missing(id: JobId) -> QueueError {
    QueueError::Row { what: format!("job {id}"), why: "it vanished within a transaction".into() }
}
