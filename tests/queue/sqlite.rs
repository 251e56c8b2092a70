//! What only a database in a file can promise: that nobody opens it whose schema is another.

use std::time::Duration;

use uvsegnet::jobs::{Policy, SqliteQueue};

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

    let newer = sqlx::sqlite::SqlitePool::connect(path.to_str().unwrap()).await.unwrap();
    sqlx::query("UPDATE _sqlx_migrations SET checksum = x'00'").execute(&newer).await.unwrap();
    let refused = open().await.unwrap_err().to_string();
    assert!(refused.contains("schema"), "{refused}");
    let refused = SqliteQueue::migrate(&path).await.unwrap_err().to_string();
    assert!(refused.contains("another version"), "{refused}");
}
