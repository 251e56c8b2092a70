//! An upgrade: a database that version 0.1.0 made (schema 1, tests/fixtures/queue_0001) has 1,000
//! jobs in every state; brought up to date, it has lost none of them and goes on.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use flate2::read::GzDecoder;
use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool, SqlitePoolOptions, SqliteRow};
use sqlx::{AssertSqlSafe, Row};
use tempfile::TempDir;
use uvsegnet::contract::MeshKind;
use uvsegnet::jobs::{
    Handover, JobId, JobState, Keep, ListFilter, Policy, SqliteQueue, Submit, Work,
};

use super::worker;

/// The database of the released version, as it left it, and a connection to it.
async fn released() -> (TempDir, PathBuf, SqlitePool) {
    let packed = include_bytes!("../fixtures/queue_0001/queue.sql.gz");
    let mut sql = String::new();
    GzDecoder::new(&packed[..]).read_to_string(&mut sql).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("queue.db");
    let options = SqliteConnectOptions::new().filename(&file).create_if_missing(true);
    let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap();
    let script = format!("BEGIN;\n{sql}COMMIT;");
    sqlx::raw_sql(AssertSqlSafe(script)).execute(&pool).await.unwrap();
    (folder, file, pool)
}

async fn opened(file: &Path) -> SqliteQueue {
    SqliteQueue::open(file, Policy::default(), Duration::ZERO).await.unwrap()
}

async fn rows(pool: &SqlitePool, sql: &'static str) -> Vec<SqliteRow> {
    sqlx::query(sql).fetch_all(pool).await.unwrap()
}

#[tokio::test]
async fn every_job_is_still_there_with_its_files_by_role() {
    let (_folder, file, pool) = released().await;
    let before = rows(&pool, "SELECT * FROM jobs ORDER BY id DESC").await;
    SqliteQueue::migrate(&file).await.unwrap();
    let queue = opened(&file).await;

    let mut filter = ListFilter { limit: 100, ..ListFilter::default() };
    let mut jobs = Vec::new();
    loop {
        let page = queue.list(&filter).await.unwrap();
        jobs.extend(page.jobs);
        filter.cursor = page.next_cursor;
        if filter.cursor.is_none() {
            break;
        }
    }
    let mut states = BTreeMap::new();
    assert_eq!((before.len(), jobs.len()), (1000, 1000));
    for (job, row) in jobs.iter().zip(&before) {
        let text = |column: &str| row.get::<String, _>(column);
        assert_eq!((job.id.to_string(), job.state.as_str()), (text("id"), &*text("state")));
        assert_eq!((&job.tag, job.attempt), (&text("tag"), row.get("attempt")));
        assert_eq!(job.expired, row.get::<bool, _>("expired"));
        assert_eq!(job.last_seq as i64, row.get::<i64, _>("last_seq"));
        let mesh = job.inputs.mesh().unwrap();
        assert_eq!((&mesh.blob, mesh.kind), (&text("upload"), Some(MeshKind::Obj)));
        assert_eq!((mesh.name.as_str(), mesh.sha256.as_str(), mesh.bytes), ("", "", 0), "unknown");
        let labels = job.inputs.labels().map_or("", |labels| &labels.blob);
        assert_eq!(labels, text("labels"));
        assert_eq!(job.inputs.iter().len(), 1 + usize::from(!labels.is_empty()));
        *states.entry(job.state.as_str()).or_insert(0) += 1;
        *states.entry("with labels").or_insert(0) += i32::from(!labels.is_empty());
        *states.entry("expired").or_insert(0) += i32::from(job.expired);
    }
    let [queued, running] = [("queued", 600), ("running", 3)];
    let over = [("succeeded", 80), ("failed", 117), ("canceled", 200)];
    for (what, count) in
        over.into_iter().chain([queued, running, ("with labels", 220), ("expired", 20)])
    {
        assert_eq!(states[what], count, "{what}");
    }
}

#[tokio::test]
async fn every_event_says_what_it_said() {
    let (_folder, file, pool) = released().await;
    let before = rows(&pool, "SELECT kind, data FROM job_events ORDER BY event_id").await;
    let last: i64 =
        sqlx::query_scalar("SELECT seq FROM sqlite_sequence").fetch_one(&pool).await.unwrap();
    SqliteQueue::migrate(&file).await.unwrap();
    let queue = opened(&file).await;
    let events = queue.all_events_after(0, 100_000).await.unwrap();
    assert!(events.len() > 1000, "{} events", events.len());
    assert_eq!(events.len(), before.len());
    for (event, row) in events.iter().zip(&before) {
        assert_eq!(event.kind().as_str(), row.get::<String, _>("kind"));
        let was: Value = serde_json::from_str(row.get("data")).unwrap();
        assert_eq!(serde_json::to_string(&event.data).unwrap(), was.to_string());
    }
    assert_eq!(queue.last_event_id().await.unwrap(), last);
}

#[tokio::test]
async fn what_waits_is_claimed_and_finished_and_the_rest_is_kept() {
    let (_folder, file, pool) = released().await;
    SqliteQueue::migrate(&file).await.unwrap();
    let queue = opened(&file).await;
    // The three that ran lost their workers together with the server.
    let lost = rows(&pool, "SELECT id FROM jobs WHERE state = 'running'").await;
    let lost: Vec<JobId> = lost.iter().map(|row| row.get::<&str, _>(0).parse().unwrap()).collect();
    assert_eq!(queue.sweep().await.unwrap().requeued, 3);
    let mut done = Vec::new();
    for _ in 0..40 {
        let claim = queue.claim(&worker("new")).await.unwrap().unwrap();
        assert!(claim.job.inputs.mesh().is_some());
        queue.finish(&claim.lease, Handover::default()).await.unwrap();
        let job = queue.get(claim.job.id).await.unwrap().unwrap();
        assert_eq!(job.state, JobState::Succeeded);
        assert_eq!(job.versions.weights.as_deref(), Some("sha256:ab"));
        done.push(job.id);
    }
    assert!(lost.iter().all(|job| done.contains(job)), "the oldest come first");
    assert_eq!(queue.stats().await.unwrap().queued, 603 - 40);
    assert!(queue.expire().await.unwrap().is_empty(), "nothing expires before its time");

    // Blobs are kept as before: every one that a job names, and none of the expired.
    let held = rows(&pool, "SELECT name, job_id FROM blobs").await;
    let held: Vec<String> = held.iter().map(|row| row.get("name")).collect();
    assert_eq!(queue.named(&held).await.unwrap().len(), held.len());
    let inputs = "SELECT count(*) FROM job_inputs JOIN jobs ON jobs.id = job_inputs.job_id
                  LEFT JOIN blobs ON blobs.name = blob
                  WHERE expired = (blobs.name IS NOT NULL)";
    let wrong: i64 = sqlx::query_scalar(inputs).fetch_one(&pool).await.unwrap();
    assert_eq!(wrong, 0);
}

#[tokio::test]
async fn a_second_migration_changes_nothing() {
    let (_folder, file, pool) = released().await;
    SqliteQueue::migrate(&file).await.unwrap();
    // It changes when another connection commits anything.
    let version = "PRAGMA data_version";
    let once: i64 = sqlx::query_scalar(version).fetch_one(&pool).await.unwrap();
    SqliteQueue::migrate(&file).await.unwrap();
    let twice: i64 = sqlx::query_scalar(version).fetch_one(&pool).await.unwrap();
    assert_eq!(once, twice);
    let broken = rows(&pool, "PRAGMA foreign_key_check").await;
    assert!(broken.is_empty());
    let sound: String =
        sqlx::query_scalar("PRAGMA integrity_check").fetch_one(&pool).await.unwrap();
    assert_eq!(sound, "ok");
}
