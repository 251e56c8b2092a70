//! What workers do to jobs: claim, tick, end, hand back.

use uuid::Uuid;

use super::{
    Claim, Handover, Job, JobState, Lease, NewEvent, QueueError, SqliteQueue, Tick, TickAnswer,
    Worker, now, rows, upkeep, write,
};
use crate::jobs::states::{Command, Ending, Gone, Standing, apply};

pub async fn claim(queue: &SqliteQueue, worker: &Worker) -> Result<Option<Claim>, QueueError> {
    // An idle worker asks often: only a look that finds something takes the write lock.
    let anything: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'queued')
             OR EXISTS (SELECT 1 FROM jobs WHERE state = 'running' AND lease_until < ?)",
    )
    .bind(now().as_microsecond())
    .fetch_one(&queue.reader)
    .await?;
    if !anything {
        return Ok(None);
    }
    let mut tx = queue.begin().await?;
    upkeep::take_back(&mut tx, &queue.policy, Gone::Lapsed).await?;
    // Told which index: left alone, SQLite sorts all that wait.
    let next = sqlx::query(
        "SELECT * FROM jobs INDEXED BY jobs_waiting WHERE state = 'queued'
         ORDER BY priority DESC, id LIMIT 1",
    );
    let Some(row) = next.fetch_optional(&mut *tx).await? else {
        tx.commit().await?;
        return Ok(None);
    };
    let (job, before) = (rows::read(&row, "id")?, rows::standing_of(&row)?);
    let token = Uuid::now_v7().simple().to_string();
    let command = Command::Claim { worker, token: &token };
    let change = apply(&before, command, &queue.policy, now())?;
    write::change(&mut tx, job, &before, &change).await?;
    let claimed: Option<Job> = rows::job(&mut tx, job).await?;
    tx.commit().await?;
    Ok(claimed.map(|job| Claim { lease: Lease { job: job.id, token }, job }))
}

pub async fn tick(
    queue: &SqliteQueue,
    lease: &Lease,
    tick: Tick,
) -> Result<TickAnswer, QueueError> {
    let only_asks = tick.events.is_empty() && tick.progress.is_none() && !tick.extend;
    let command = Command::Tick(&lease.token, tick);
    let standing = match only_asks {
        true => ask(queue, lease, command).await,
        false => obey(queue, lease, command).await,
    };
    match standing {
        Ok(standing) if standing.cancel_requested => Ok(TickAnswer::Cancel),
        Ok(_) => Ok(TickAnswer::Continue),
        Err(QueueError::LeaseLost) => Ok(TickAnswer::LeaseLost),
        Err(error) => Err(error),
    }
}

/// What a command that changes nothing finds, without the write lock.
async fn ask(
    queue: &SqliteQueue,
    lease: &Lease,
    command: Command<'_>,
) -> Result<Standing, QueueError> {
    let standing = rows::standing(&mut *queue.reader.acquire().await?, lease.job).await?;
    let standing = standing.ok_or(QueueError::LeaseLost)?;
    Ok(apply(&standing, command, &queue.policy, now())?.standing)
}

pub async fn end(
    queue: &SqliteQueue,
    lease: &Lease,
    ending: Ending,
    handover: Handover,
) -> Result<JobState, QueueError> {
    let standing = obey(queue, lease, Command::End(&lease.token, ending, handover)).await?;
    Ok(standing.state)
}

pub async fn release(
    queue: &SqliteQueue,
    lease: &Lease,
    events: Vec<NewEvent>,
) -> Result<(), QueueError> {
    obey(queue, lease, Command::Release(&lease.token, events)).await.map(|_| ())
}

/// Do to the job of a lease what its holder says. A job that is gone is as lost as a lease.
async fn obey(
    queue: &SqliteQueue,
    lease: &Lease,
    command: Command<'_>,
) -> Result<Standing, QueueError> {
    let mut tx = queue.begin().await?;
    let before = rows::standing(&mut tx, lease.job).await?.ok_or(QueueError::LeaseLost)?;
    let change = apply(&before, command, &queue.policy, now())?;
    write::change(&mut tx, lease.job, &before, &change).await?;
    tx.commit().await?;
    Ok(change.standing)
}
