//! Notices the commits of every process that has the database open.

use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};

use crate::jobs::{Changes, Commits};

/// How often the database is asked.
const POLL: Duration = Duration::from_millis(100);

/// Watch the database behind `options` from a task that ends when the last subscription is dropped.
pub fn watch(options: SqliteConnectOptions) -> Changes {
    let (commits, changes) = Changes::new();
    tokio::spawn(poll(options, commits));
    changes
}

/// `PRAGMA data_version` changes when *another* connection commits, so the connection must be one
/// of its own and never one of a pool (<https://sqlite.org/pragma.html#pragma_data_version>).
async fn poll(options: SqliteConnectOptions, commits: Commits) {
    let mut connection: Option<SqliteConnection> = None;
    let mut last = None;
    while !commits.is_closed() {
        match version(&mut connection, &options).await {
            Ok(version) if last == Some(version) => {}
            Ok(version) => {
                last = Some(version);
                commits.tell();
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
