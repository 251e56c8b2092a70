//! Workers that come and go, leases that lapse, blobs whose time is over.

use std::collections::BTreeSet;
use std::time::Duration;

use sqlx::Row;
use sqlx::sqlite::SqliteRow;

use super::transitions::{Gone, take_back};
use super::{QueueError, SqliteQueue, Stats, Swept, Worker, micros, now_us, rows};
use crate::jobs::WORKER_ALIVE;

/// A worker not seen for this long is forgotten.
const FORGOTTEN: Duration = Duration::from_secs(600);

pub async fn register(queue: &SqliteQueue, worker: &Worker) -> Result<(), QueueError> {
    sqlx::query(
        "INSERT INTO workers (id, pid, host, device, engine, draining, last_seen)
         VALUES (?, ?, ?, ?, ?, ?, ?)
         ON CONFLICT (id) DO UPDATE SET draining = excluded.draining,
             last_seen = excluded.last_seen",
    )
    .bind(&worker.id)
    .bind(worker.pid)
    .bind(&worker.host)
    .bind(&worker.device)
    .bind(&worker.engine)
    .bind(worker.draining)
    .bind(now_us())
    .execute(&queue.writer)
    .await?;
    Ok(())
}

pub async fn worker_gone(queue: &SqliteQueue, worker: &str) -> Result<Swept, QueueError> {
    let mut tx = queue.begin().await?;
    let swept = take_back(&mut tx, &queue.config, Gone::Worker(worker)).await?;
    sqlx::query("DELETE FROM workers WHERE id = ?").bind(worker).execute(&mut *tx).await?;
    tx.commit().await?;
    Ok(swept)
}

pub async fn sweep(queue: &SqliteQueue) -> Result<Swept, QueueError> {
    let forgotten = now_us().saturating_sub(micros(FORGOTTEN));
    let anything: bool = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'running' AND lease_until < ?)
             OR EXISTS (SELECT 1 FROM workers WHERE last_seen < ?)",
    )
    .bind(now_us())
    .bind(forgotten)
    .fetch_one(&queue.reader)
    .await?;
    if !anything {
        return Ok(Swept::default());
    }
    let mut tx = queue.begin().await?;
    let swept = take_back(&mut tx, &queue.config, Gone::Lapsed).await?;
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
    let alive = now_us().saturating_sub(micros(WORKER_ALIVE));
    let workers = sqlx::query("SELECT * FROM workers WHERE last_seen >= ? ORDER BY id")
        .bind(alive)
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
        draining: row.try_get("draining")?,
        last_seen: rows::time(row.try_get("last_seen")?).unwrap_or_default(),
    })
}

pub async fn expire(queue: &SqliteQueue) -> Result<Vec<String>, QueueError> {
    let now = now_us();
    let due: Vec<String> = sqlx::query_scalar(
        "SELECT id FROM jobs WHERE expires_at > 0 AND expired = 0 AND expires_at <= ?",
    )
    .bind(now)
    .fetch_all(&queue.reader)
    .await?;
    if due.is_empty() {
        return Ok(Vec::new());
    }
    let due = rows::json(&due)?;
    let mut tx = queue.begin().await?;
    let blobs = sqlx::query_scalar(
        "DELETE FROM blobs WHERE job_id IN (SELECT value FROM json_each(?)) RETURNING name",
    )
    .bind(&due)
    .fetch_all(&mut *tx)
    .await?;
    sqlx::query(
        "UPDATE jobs SET expired = 1, revision = revision + 1
         WHERE id IN (SELECT value FROM json_each(?))",
    )
    .bind(&due)
    .execute(&mut *tx)
    .await?;
    tx.commit().await?;
    Ok(blobs)
}

pub async fn named(queue: &SqliteQueue, blobs: &[String]) -> Result<BTreeSet<String>, QueueError> {
    let names: Vec<String> =
        sqlx::query_scalar("SELECT name FROM blobs WHERE name IN (SELECT value FROM json_each(?))")
            .bind(rows::json(&blobs)?)
            .fetch_all(&queue.reader)
            .await?;
    Ok(names.into_iter().collect())
}
