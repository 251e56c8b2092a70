//! Notices that something was committed, by this process or another, so that streams, long polls
//! and idle workers need not ask the queue all the time.

use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use tokio::sync::watch;

/// How often the database is asked.
const POLL: Duration = Duration::from_millis(100);

/// A subscription to commits. Take one (clone it), *then* read, then wait, then read again: no
/// commit is missed. It does not say what changed.
#[derive(Debug, Clone)]
pub struct Changes(watch::Receiver<u64>);

impl Changes {
    /// Watch the database behind `options` from a task that ends when the last subscription is
    /// dropped.
    pub(super) fn watch(options: SqliteConnectOptions) -> Self {
        let (sender, receiver) = watch::channel(0);
        tokio::spawn(poll(options, sender));
        Self(receiver)
    }

    /// Wait until something was committed since this returned last (or since this subscription was
    /// taken). Commits in quick succession are noticed once.
    pub async fn changed(&mut self) {
        if self.0.changed().await.is_err() {
            // The watcher is gone, so the runtime is going: nothing will change any more.
            std::future::pending::<()>().await;
        }
    }

    /// [`Changes::changed`], or the end of `patience`, whatever is first.
    pub async fn changed_within(&mut self, patience: Duration) {
        // Both ends mean the same to the caller: look again.
        let _ = tokio::time::timeout(patience, self.changed()).await;
    }
}

/// `PRAGMA data_version` changes when *another* connection commits, so the connection must be one
/// of its own and never one of a pool (<https://sqlite.org/pragma.html#pragma_data_version>).
async fn poll(options: SqliteConnectOptions, sender: watch::Sender<u64>) {
    let mut connection: Option<SqliteConnection> = None;
    let mut last = None;
    while !sender.is_closed() {
        match version(&mut connection, &options).await {
            Ok(version) if last == Some(version) => {}
            Ok(version) => {
                last = Some(version);
                sender.send_modify(|count| *count += 1);
            }
            Err(error) => {
                tracing::warn!(%error, "cannot watch the database for changes");
                // A new connection counts anew, and waiters had better look.
                (connection, last) = (None, None);
            }
        }
        tokio::time::sleep(POLL).await;
    }
    if let Some(connection) = connection {
        let _ = connection.close().await;
    }
}

async fn version(
    connection: &mut Option<SqliteConnection>,
    options: &SqliteConnectOptions,
) -> Result<i64, sqlx::Error> {
    let connection = match connection {
        Some(open) => open,
        None => connection.insert(options.connect().await?),
    };
    sqlx::query_scalar("PRAGMA data_version").fetch_one(connection).await
}
