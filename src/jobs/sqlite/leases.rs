//! What workers do to jobs: claim, tick, end, hand back. Every write asks for the lease's token, so
//! a worker that was paused past its lease changes nothing.

use sqlx::Row;
use sqlx::sqlite::SqliteConnection;
use uuid::Uuid;

use super::transitions::{Again, Gone, Over, over, requeue, take_back};
use super::{
    Claim, Handover, JobState, Lease, NewEvent, QueueError, SqliteQueue, Tick, TickAnswer, Worker,
    events, micros, now_us, rows,
};
use crate::contract::{ErrorCode, JobError};
use crate::jobs::JobProgress;

pub async fn claim(queue: &SqliteQueue, worker: &Worker) -> Result<Option<Claim>, QueueError> {
    // An idle worker asks often: only a look that finds something takes the write lock.
    let anything: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'queued')
             OR EXISTS (SELECT 1 FROM jobs WHERE state = 'running' AND lease_until < ?)",
    )
    .bind(now_us())
    .fetch_one(&queue.reader)
    .await?;
    if !anything {
        return Ok(None);
    }
    let mut tx = queue.begin().await?;
    take_back(&mut tx, &queue.config, Gone::Lapsed).await?;
    let token = Uuid::now_v7().simple().to_string();
    let now = now_us();
    // `RETURNING` is drained, or the statement would not end.
    let claimed = sqlx::query(
        "UPDATE jobs SET state = 'running', attempt = attempt + 1, worker = ?, lease = ?,
             lease_until = ?, started_at = ?, engine = ?, device = ?, progress = 'null',
             revision = revision + 1
         WHERE id = (SELECT id FROM jobs WHERE state = 'queued'
                     ORDER BY priority DESC, id LIMIT 1)
         RETURNING id",
    )
    .bind(&worker.id)
    .bind(&token)
    .bind(now.saturating_add(micros(queue.config.lease)))
    .bind(now)
    .bind(&worker.engine)
    .bind(&worker.device)
    .fetch_all(&mut *tx)
    .await?;
    let job = match claimed.first() {
        Some(row) => rows::job(&mut tx, rows::read(row, "id")?).await?,
        None => None,
    };
    tx.commit().await?;
    Ok(job.map(|job| Claim { lease: Lease { job: job.id, token }, job }))
}

pub async fn tick(
    queue: &SqliteQueue,
    lease: &Lease,
    tick: Tick,
) -> Result<TickAnswer, QueueError> {
    if tick.events.is_empty() && tick.progress.is_none() && !tick.extend {
        let held = held(&mut *queue.reader.acquire().await?, lease).await;
        return answer(held);
    }
    let mut tx = queue.begin().await?;
    let held = held(&mut tx, lease).await;
    if held.is_ok() {
        write(&mut tx, lease, &tick.events, &tick.progress).await?;
        if tick.extend {
            sqlx::query("UPDATE jobs SET lease_until = ? WHERE id = ?")
                .bind(now_us().saturating_add(micros(queue.config.lease)))
                .bind(lease.job.to_string())
                .execute(&mut *tx)
                .await?;
        }
        tx.commit().await?;
    }
    answer(held)
}

fn answer(held: Result<Held, QueueError>) -> Result<TickAnswer, QueueError> {
    match held {
        Ok(held) if held.cancel_requested => Ok(TickAnswer::Cancel),
        Ok(_) => Ok(TickAnswer::Continue),
        Err(QueueError::LeaseLost) => Ok(TickAnswer::LeaseLost),
        Err(error) => Err(error),
    }
}

/// How an attempt ended.
pub enum Ending {
    Succeeded,
    Failed(JobError),
    Canceled,
}

/// End an attempt; says what the job is now.
pub async fn end(
    queue: &SqliteQueue,
    lease: &Lease,
    ending: Ending,
    handover: Handover,
) -> Result<JobState, QueueError> {
    let mut tx = queue.begin().await?;
    let held = held(&mut tx, lease).await?;
    write(&mut tx, lease, &handover.events, &handover.progress).await?;
    let end = match ending {
        Ending::Succeeded => Over::Succeeded(handover.metrics, handover.artifacts),
        Ending::Canceled => Over::Canceled,
        Ending::Failed(error) if is_transient(error.code) && held.cancel_requested => {
            tracing::info!(%error, "not tried again, for it is to be canceled");
            Over::Canceled
        }
        Ending::Failed(error) if is_transient(error.code) && held.attempts_left => {
            requeue(&mut tx, lease.job, Again::After(error)).await?;
            tx.commit().await?;
            return Ok(JobState::Queued);
        }
        Ending::Failed(error) => Over::Failed(error, handover.artifacts),
    };
    let state = end.state();
    over(&mut tx, &queue.config, lease.job, end).await?;
    tx.commit().await?;
    Ok(state)
}

pub async fn release(
    queue: &SqliteQueue,
    lease: &Lease,
    events: &[NewEvent],
) -> Result<(), QueueError> {
    let mut tx = queue.begin().await?;
    let held = held(&mut tx, lease).await?;
    write(&mut tx, lease, events, &None).await?;
    match held.cancel_requested {
        true => over(&mut tx, &queue.config, lease.job, Over::Canceled).await?,
        false => requeue(&mut tx, lease.job, Again::Draining).await?,
    }
    Ok(tx.commit().await?)
}

/// Whether another attempt may go better: the machine failed and not the input.
fn is_transient(code: ErrorCode) -> bool {
    matches!(code, ErrorCode::DeviceLost | ErrorCode::WorkerCrashed)
}

struct Held {
    cancel_requested: bool,
    attempts_left: bool,
}

/// The job behind a lease that is still held.
async fn held(connection: &mut SqliteConnection, lease: &Lease) -> Result<Held, QueueError> {
    let row = sqlx::query(
        "SELECT cancel_requested, attempt < max_attempts AS attempts_left FROM jobs
         WHERE id = ? AND lease = ? AND state = 'running'",
    )
    .bind(lease.job.to_string())
    .bind(&lease.token)
    .fetch_optional(connection)
    .await?;
    let row = row.ok_or(QueueError::LeaseLost)?;
    Ok(Held {
        cancel_requested: row.try_get("cancel_requested")?,
        attempts_left: row.try_get("attempts_left")?,
    })
}

async fn write(
    connection: &mut SqliteConnection,
    lease: &Lease,
    events: &[NewEvent],
    progress: &Option<JobProgress>,
) -> Result<(), QueueError> {
    if progress.is_some() {
        sqlx::query("UPDATE jobs SET progress = ?, revision = revision + 1 WHERE id = ?")
            .bind(rows::json(progress)?)
            .bind(lease.job.to_string())
            .execute(&mut *connection)
            .await?;
    }
    events::append(connection, lease.job, events).await
}
