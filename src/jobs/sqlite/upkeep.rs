//! Workers that come and go, leases that lapse, blobs whose time is over.

use std::collections::BTreeSet;

use sqlx::sqlite::{SqliteConnection, SqliteRow};
use sqlx::{QueryBuilder, Row};

use super::{JobId, QueueError, SqliteQueue, Stats, Swept, Worker, ago, now, rows, write};
use crate::jobs::states::{Command, Gone, Policy, Standing, apply};
use crate::jobs::worker::{WORKER_ALIVE, WORKER_FORGOTTEN};

pub async fn register(queue: &SqliteQueue, worker: &Worker) -> Result<(), QueueError> {
    sqlx::query(
        "INSERT INTO workers (id, pid, host, device, engine, weights, threads, draining, last_seen)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)
         ON CONFLICT (id) DO UPDATE SET draining = excluded.draining,
             last_seen = excluded.last_seen",
    )
    .bind(&worker.id)
    .bind(worker.pid)
    .bind(&worker.host)
    .bind(&worker.device)
    .bind(&worker.engine)
    .bind(worker.weights.as_deref().unwrap_or_default())
    .bind(worker.threads)
    .bind(worker.draining)
    .bind(now().as_microsecond())
    .execute(&queue.writer)
    .await?;
    Ok(())
}

pub async fn worker_gone(queue: &SqliteQueue, worker: &str) -> Result<Swept, QueueError> {
    let mut tx = queue.begin().await?;
    let swept = take_back(&mut tx, &queue.policy, Gone::Worker(worker)).await?;
    sqlx::query("DELETE FROM workers WHERE id = ?").bind(worker).execute(&mut *tx).await?;
    tx.commit().await?;
    Ok(swept)
}

/// How the jobs of these rows stand. One that cannot be read must not hold up the others.
fn readable(rows: &[SqliteRow]) -> impl Iterator<Item = (JobId, Standing)> {
    rows.iter().filter_map(|row| {
        let read = rows::read(row, "id").and_then(|id| Ok((id, rows::standing_of(row)?)));
        read.inspect_err(|error| tracing::error!(%error, "a job is passed over")).ok()
    })
}

/// Take back the jobs of workers that are gone.
pub async fn take_back(
    connection: &mut SqliteConnection,
    policy: &Policy,
    gone: Gone<'_>,
) -> Result<Swept, QueueError> {
    let mut query = QueryBuilder::new("SELECT * FROM jobs WHERE state = 'running' AND ");
    match gone {
        Gone::Worker(worker) => query.push("worker = ").push_bind(worker.to_owned()),
        Gone::Lapsed => query.push("lease_until < ").push_bind(now().as_microsecond()),
    };
    let mut swept = Swept::default();
    for (id, before) in readable(&query.build().fetch_all(&mut *connection).await?) {
        if let Ok(change) = apply(&before, Command::TakeBack(gone), policy, now()) {
            write::change(connection, id, &before, &change).await?;
            swept += change.effects.swept;
        }
    }
    Ok(swept)
}

pub async fn sweep(queue: &SqliteQueue) -> Result<Swept, QueueError> {
    let forgotten = ago(WORKER_FORGOTTEN);
    let anything: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'running' AND lease_until < ?)
             OR EXISTS (SELECT 1 FROM workers WHERE last_seen < ?)",
    )
    .bind(now().as_microsecond())
    .bind(forgotten)
    .fetch_one(&queue.reader)
    .await?;
    if !anything {
        return Ok(Swept::default());
    }
    let mut tx = queue.begin().await?;
    let swept = take_back(&mut tx, &queue.policy, Gone::Lapsed).await?;
    sqlx::query("DELETE FROM workers WHERE last_seen < ?")
        .bind(forgotten)
        .execute(&mut *tx)
        .await?;
    tx.commit().await?;
    Ok(swept)
}

pub async fn stats(queue: &SqliteQueue) -> Result<Stats, QueueError> {
    let mut tx = queue.snapshot().await?;
    let count = |row: &SqliteRow, column| -> Result<u64, sqlx::Error> {
        Ok(row.try_get::<i64, _>(column)?.unsigned_abs())
    };
    let counts = sqlx::query(
        "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued') AS queued,
                (SELECT count(*) FROM jobs WHERE state = 'running') AS running",
    )
    .fetch_one(&mut *tx)
    .await?;
    let workers = sqlx::query("SELECT * FROM workers WHERE last_seen >= ? ORDER BY id")
        .bind(ago(WORKER_ALIVE))
        .fetch_all(&mut *tx)
        .await?;
    Ok(Stats {
        queued: count(&counts, "queued")?,
        running: count(&counts, "running")?,
        workers: workers.iter().map(worker_of).collect::<Result<_, _>>()?,
    })
}

pub async fn workers_on(queue: &SqliteQueue, host: &str) -> Result<Vec<Worker>, QueueError> {
    let workers = sqlx::query("SELECT * FROM workers WHERE host = ? ORDER BY id")
        .bind(host)
        .fetch_all(&queue.reader)
        .await?;
    workers.iter().map(worker_of).collect()
}

fn worker_of(row: &SqliteRow) -> Result<Worker, QueueError> {
    Ok(Worker {
        id: row.try_get("id")?,
        pid: row.try_get("pid")?,
        host: row.try_get("host")?,
        device: row.try_get("device")?,
        engine: row.try_get("engine")?,
        weights: rows::word(row, "weights")?,
        threads: row.try_get("threads")?,
        draining: row.try_get("draining")?,
        last_seen: rows::time(row.try_get("last_seen")?).unwrap_or_default(),
    })
}

pub async fn expire(queue: &SqliteQueue) -> Result<Vec<String>, QueueError> {
    const DUE: &str = "FROM jobs WHERE expires_at > 0 AND expired = 0 AND expires_at <= ";
    let mut query = QueryBuilder::new("SELECT EXISTS (SELECT 1 ");
    query.push(DUE).push_bind(now().as_microsecond()).push(")");
    let anything: bool = query.build_query_scalar().fetch_one(&queue.reader).await?;
    let mut gone = Vec::new();
    if !anything {
        return Ok(gone);
    }
    let mut tx = queue.begin().await?;
    let mut query = QueryBuilder::new("SELECT * ");
    query.push(DUE).push_bind(now().as_microsecond());
    for (id, before) in readable(&query.build().fetch_all(&mut *tx).await?) {
        if let Ok(change) = apply(&before, Command::Expire, &queue.policy, now()) {
            gone.extend(write::change(&mut tx, id, &before, &change).await?);
        }
    }
    tx.commit().await?;
    Ok(gone)
}

pub async fn named(queue: &SqliteQueue, blobs: &[String]) -> Result<BTreeSet<String>, QueueError> {
    let names: Vec<String> =
        sqlx::query_scalar("SELECT name FROM blobs WHERE name IN (SELECT value FROM json_each(?))")
            .bind(rows::json(&blobs)?)
            .fetch_all(&queue.reader)
            .await?;
    Ok(names.into_iter().collect())
}
