//! The schema: brought up to date by a server, waited for by everybody else.

use std::fs::File;
use std::path::Path;
use std::time::{Duration, Instant};

use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::sqlite::SqliteConnection;
use sqlx::{ConnectOptions, Connection, SqlStr};

use super::{QueueError, connect_options, disk};

/// How often a waiting process looks.
const LOOK: Duration = Duration::from_millis(100);

/// Every migration, in order. One that was released is never edited: its checksum is stored.
fn migrations() -> Migrator {
    const SQL: [(&str, &str); 2] = [
        ("jobs", include_str!("../../../migrations/sqlite/0001_jobs.sql")),
        ("job inputs", include_str!("../../../migrations/sqlite/0002_job_inputs.sql")),
    ];
    let migrations = SQL.into_iter().zip(1..).map(|((name, sql), version)| {
        let sql = SqlStr::from_static(sql);
        Migration::new(version, name.into(), MigrationType::Simple, sql, false)
    });
    Migrator::with_migrations(migrations.collect())
}

/// Bring the schema up to date. sqlx has no migration lock for SQLite, so a file lock beside the
/// database lets in one process at a time.
pub async fn migrate(file: &Path) -> Result<(), QueueError> {
    let unusable = |error: std::io::Error| {
        QueueError::Schema(format!("cannot make the database {}: {error}", file.display()))
    };
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder).map_err(unusable)?;
    }
    disk::refuse_network(file)?;
    let lock = File::create(file.with_extension("migrate.lock")).map_err(unusable)?;
    let lock = tokio::task::spawn_blocking(move || lock.lock().map(|()| lock));
    let _held = lock.await.map_err(|error| unusable(error.into()))?.map_err(unusable)?;

    let mut connection = connect_options(file).create_if_missing(true).connect().await?;
    let done = migrations().run(&mut connection).await;
    connection.close().await?;
    done.map_err(|error| {
        QueueError::Schema(format!(
            "cannot bring the database {} up to date: {error}. It may come from another version of \
             this program; use that version, or another data directory",
            file.display()
        ))
    })
}

/// Wait until the schema is exactly the one that this program knows.
pub async fn wait(file: &Path, patience: Duration) -> Result<(), QueueError> {
    let give_up = Instant::now() + patience;
    loop {
        let found = match file.exists() {
            true => look(file).await,
            false => Err("there is no such file".into()),
        };
        let Err(why) = found else { return Ok(()) };
        if Instant::now() >= give_up {
            return Err(QueueError::Schema(format!(
                "the database {} does not have this program's schema: {why}. Start `uvsegnet \
                 serve` of the same version on this data directory",
                file.display()
            )));
        }
        tokio::time::sleep(LOOK).await;
    }
}

async fn look(file: &Path) -> Result<(), String> {
    let connection = connect_options(file).connect().await;
    let mut connection = connection.map_err(|error| error.to_string())?;
    let applied = applied(&mut connection).await;
    let _ = connection.close().await;
    let applied = applied.map_err(|error| error.to_string())?;
    let migrator = migrations();
    let known: Vec<_> = migrator.iter().map(|one| (one.version, one.checksum.to_vec())).collect();
    if applied == known {
        return Ok(());
    }
    let last = |list: &[(i64, Vec<u8>)]| list.last().map_or(0, |(version, _)| *version);
    Err(format!("it has version {}, this program has {}", last(&applied), last(&known)))
}

async fn applied(connection: &mut SqliteConnection) -> Result<Vec<(i64, Vec<u8>)>, sqlx::Error> {
    sqlx::query_as("SELECT version, checksum FROM _sqlx_migrations WHERE success ORDER BY version")
        .fetch_all(connection)
        .await
}
