//! Notices the commits of every process that has the database open.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use futures::FutureExt;
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use tokio::sync::Notify;
use tokio::time::{sleep, timeout};

use crate::jobs::{Changes, Commits};

/// How often the database is asked though nothing was written to its log, as far as the file system tells.
const POLL: Duration = Duration::from_millis(100);

/// How long after the log was written to the database is asked first: a commit is some writes, and it counts a
/// little after the last of them. Asked in vain, the waits double.
const SOON: Duration = Duration::from_millis(1);

/// Watch the database in `file`, which is opened with `options`, from a task that ends when the last subscription is
/// dropped.
pub fn watch(file: &Path, options: SqliteConnectOptions) -> Changes {
    let (commits, changes) = Changes::new();
    let mut log = OsString::from(file);
    log.push("-wal");
    tokio::spawn(poll(log.into(), options, commits));
    changes
}

/// `PRAGMA data_version` changes when *another* connection commits, so the connection must be one
/// of its own and never one of a pool (<https://sqlite.org/pragma.html#pragma_data_version>).
async fn poll(log: PathBuf, options: SqliteConnectOptions, commits: Commits) {
    let mut connection: Option<SqliteConnection> = None;
    let mut last = None;
    let written = Arc::new(Notify::new());
    let watcher = watch_log(&log, written.clone());
    if let Err(error) = &watcher {
        tracing::warn!(%error, "the file system tells of no writes: commits are noticed {POLL:?} late");
    }
    let mut patience = POLL;
    while !commits.is_closed() {
        match version(&mut connection, &options).await {
            Ok(version) if last == Some(version) => patience = (2 * patience).min(POLL),
            Ok(version) => {
                (last, patience) = (Some(version), POLL);
                commits.tell();
            }
            Err(error) => {
                tracing::warn!(%error, "cannot watch the database for changes");
                // A new connection counts anew, and waiters had better look.
                (connection, last, patience) = (None, None, POLL);
            }
        }
        if timeout(patience, written.notified()).await.is_ok() {
            sleep(SOON).await;
            // The other writes of the same commit.
            let _ = written.notified().now_or_never();
            patience = SOON;
        }
    }
    if let Some(connection) = connection {
        let _ = connection.close().await;
    }
}

/// Tell `written` when something is written to the log, until what is returned is dropped.
fn watch_log(log: &Path, written: Arc<Notify>) -> notify::Result<RecommendedWatcher> {
    let (folder, name) = (log.parent(), log.file_name().map(OsString::from));
    let folder = folder.filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let tell = move |event: notify::Result<notify::Event>| {
        let is_write =
            |kind: &EventKind| matches!(kind, EventKind::Create(_) | EventKind::Modify(_));
        let of_log = |path: &PathBuf| path.file_name() == name.as_deref();
        if event.is_ok_and(|event| is_write(&event.kind) && event.paths.iter().any(of_log)) {
            written.notify_one();
        }
    };
    let mut watcher = notify::recommended_watcher(tell)?;
    // The folder, for the log comes and goes.
    watcher.watch(folder, RecursiveMode::NonRecursive)?;
    Ok(watcher)
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
