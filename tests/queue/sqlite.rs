//! What only a database in a file can promise: that nobody opens it whose schema is another, and that
//! a row which cannot be read does not hold up the others.

use std::time::Duration;

use sqlx::sqlite::SqlitePool;
use uvsegnet::jobs::{Handover, Keep, Policy, SqliteQueue, Work};

use super::{claim, submit};

#[tokio::test]
async fn the_schema_must_be_exactly_ours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("queue.db");
    let open = || SqliteQueue::open(&path, Policy::default(), Duration::from_millis(200));
    let refused = open().await.unwrap_err().to_string();
    assert!(refused.contains("uvsegnet serve"), "{refused}");
    assert!(!path.exists(), "only a server makes the file");

    // Several servers may start at once.
    let (a, b) = tokio::join!(SqliteQueue::migrate(&path), SqliteQueue::migrate(&path));
    a.and(b).unwrap();
    open().await.unwrap();

    let newer = SqlitePool::connect(path.to_str().unwrap()).await.unwrap();
    sqlx::query("UPDATE _sqlx_migrations SET checksum = x'00'").execute(&newer).await.unwrap();
    let refused = open().await.unwrap_err().to_string();
    assert!(refused.contains("schema"), "{refused}");
    let refused = SqliteQueue::migrate(&path).await.unwrap_err().to_string();
    assert!(refused.contains("another version"), "{refused}");
}

#[tokio::test]
async fn a_row_that_cannot_be_read_holds_up_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("queue.db");
    SqliteQueue::migrate(&path).await.unwrap();
    let policy = Policy { retention: Duration::ZERO, ..Policy::default() };
    let queue = SqliteQueue::open(&path, policy, Duration::ZERO).await.unwrap();
    for _ in 0..2 {
        submit(&queue).await;
        queue.finish(&claim(&queue).await.lease, Handover::default()).await.unwrap();
    }
    let file = SqlitePool::connect(path.to_str().unwrap()).await.unwrap();
    let broken = "UPDATE jobs SET metrics = '{' WHERE id = (SELECT min(id) FROM jobs)";
    sqlx::query(broken).execute(&file).await.unwrap();
    assert_eq!(queue.expire().await.unwrap().len(), 1);
}
