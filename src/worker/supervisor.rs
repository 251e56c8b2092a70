//! Keeps the local workers alive: starts them, tells them to finish, replaces those that ended, and
//! takes back their jobs at once.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::AsyncWriteExt;
use tokio::process::{Child, Command};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::{EXIT_RENEW, parent};
use crate::jobs::Keep;

/// Shortest and longest wait before a worker that ended is replaced.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(200), Duration::from_secs(10));
/// A worker that lived this long was healthy: the back-off begins anew.
const HEALTHY: Duration = Duration::from_secs(30);
/// How long a worker gets to leave beyond the time that its job gets.
const LEAVE: Duration = Duration::from_secs(5);

/// The local workers of a server.
#[derive(Clone)]
pub struct Supervisor {
    /// The program, which has the subcommand `worker`.
    pub program: PathBuf,
    /// What follows `worker --supervised --id ID`.
    pub flags: Vec<OsString>,
    /// How many workers.
    pub count: usize,
    /// Threads of each worker's pipeline.
    pub threads: usize,
    /// The queue, which learns of deaths here.
    pub queue: Arc<dyn Keep>,
    /// How long a running job gets at a shutdown.
    pub drain_timeout: Duration,
}

impl Supervisor {
    /// Keep the workers alive until told to drain; then wait for them to leave, and kill those that
    /// do not. A dropped supervisor kills its workers.
    pub async fn run(self, drain: CancellationToken) {
        let mut slots = JoinSet::new();
        for slot in 0..self.count {
            slots.spawn(self.clone().keep(slot, drain.clone()));
        }
        while slots.join_next().await.is_some() {}
    }

    /// Keep one worker alive.
    async fn keep(self, slot: usize, drain: CancellationToken) {
        let mut back_off = BACK_OFF.0;
        while !drain.is_cancelled() {
            // Never an id twice: a lock or a row of the one before could be taken for its own.
            let id = format!("w{slot}-{}", Uuid::now_v7().simple());
            let began = Instant::now();
            let renewed = match self.start(&id) {
                Ok(child) => self.attend(&id, child, &drain).await,
                Err(error) => {
                    tracing::error!(%error, "cannot start a worker");
                    false
                }
            };
            self.take_back(&id).await;
            if renewed || began.elapsed() >= HEALTHY {
                back_off = BACK_OFF.0;
            }
            if !renewed && !drain.is_cancelled() {
                tokio::select! {
                    () = sleep(back_off) => {}
                    () = drain.cancelled() => {}
                }
                back_off = (back_off * 2).min(BACK_OFF.1);
            }
        }
    }

    fn start(&self, id: &str) -> std::io::Result<Child> {
        let mut command = Command::new(&self.program);
        command.args(["worker", "--supervised", "--id", id]).args(&self.flags);
        command.args(["--threads", &self.threads.to_string()]);
        command.stdin(Stdio::piped()).kill_on_drop(true).spawn()
    }

    /// Wait for a worker's end; says whether it asked to be replaced.
    async fn attend(&self, id: &str, mut child: Child, drain: &CancellationToken) -> bool {
        // Taken out, for `wait` would close it, and its end means that the server is gone.
        let mut input = child.stdin.take();
        let ended = tokio::select! {
            ended = child.wait() => ended,
            () = drain.cancelled() => {
                if let Some(input) = &mut input {
                    // A worker that is gone cannot be told; `wait` will say so.
                    let _ = input.write_all(parent::DRAIN.as_bytes()).await;
                    let _ = input.flush().await;
                }
                match timeout(self.drain_timeout + LEAVE, child.wait()).await {
                    Ok(ended) => ended,
                    Err(_) => {
                        tracing::warn!(worker = id, "did not leave in time and is killed");
                        let _ = child.kill().await;
                        child.wait().await
                    }
                }
            }
        };
        match ended {
            Ok(status) if status.code() == Some(EXIT_RENEW) => true,
            Ok(status) => {
                if !drain.is_cancelled() {
                    tracing::warn!(worker = id, %status, "a worker ended");
                }
                false
            }
            Err(error) => {
                tracing::error!(worker = id, %error, "cannot wait for a worker");
                false
            }
        }
    }

    /// The worker is dead: its jobs need not wait for their leases to lapse.
    async fn take_back(&self, id: &str) {
        match self.queue.worker_gone(id).await {
            Ok(swept) if swept == Default::default() => {}
            Ok(swept) => tracing::warn!(worker = id, ?swept, "took back the jobs of a dead worker"),
            Err(error) => tracing::error!(worker = id, %error, "cannot take back its jobs"),
        }
    }
}
