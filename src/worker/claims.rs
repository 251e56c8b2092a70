//! The life of a worker: show presence, register, take job after job, leave.

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use tokio_util::sync::CancellationToken;

use super::WorkerError;
use super::attempt::{self, Context, Next};
use crate::contract::Limits;
use crate::device::{self, Device, DeviceChoice};
use crate::jobs::{Blobs, Changes, Presence, Work, Worker};
use crate::pipeline::{Engine, Weights};
use crate::tasks;

/// How often a worker says that it is alive.
const HEARTBEAT: Duration = Duration::from_secs(5);
/// How long an idle worker waits for a commit before it looks all the same: leases lapse silently.
const IDLE: Duration = Duration::from_secs(2);
/// How long a worker waits after an error of the queue.
const AFTER_ERROR: Duration = Duration::from_secs(1);

/// What a worker is told at its start.
pub struct WorkerSettings {
    /// Its id, which no other process has or had.
    pub id: String,
    /// The name of this host.
    pub host: String,
    /// The queue.
    pub queue: Arc<dyn Work>,
    /// The blobs.
    pub blobs: Blobs,
    /// Tells when a job may wait.
    pub changes: Changes,
    /// Where this worker shows that it lives.
    pub presence: Arc<dyn Presence>,
    /// Where to compute.
    pub device: DeviceChoice,
    /// Weights of the segmentation network.
    pub weights: Weights,
    /// What is accepted.
    pub limits: Limits,
    /// Set when the worker is to shut down.
    pub drain: CancellationToken,
    /// How long a job may go on after that.
    pub drain_timeout: Duration,
}

/// Work until told to shut down. `Ok(true)` asks for a fresh process in place of this one: exit with
/// [`EXIT_RENEW`](super::EXIT_RENEW), and at once, for the pipeline may still be running.
pub async fn run(settings: WorkerSettings) -> Result<bool, WorkerError> {
    let _alive = settings.presence.declare(&settings.id)?;
    let device = ready_device(settings.device).await?;
    let worker = Worker {
        id: settings.id,
        pid: std::process::id(),
        host: settings.host,
        device: device.name(),
        engine: env!("CARGO_PKG_VERSION").into(),
        weights: Some(settings.weights.digest().to_owned()),
        threads: u32::try_from(tasks::threads()).unwrap_or(u32::MAX),
        draining: false,
        last_seen: Timestamp::now(),
    };
    settings.queue.register(&worker).await?;
    let heart = tokio::spawn(beat(settings.queue.clone(), worker.clone(), settings.drain.clone()));
    tracing::info!(worker = worker.id, device = worker.device, "worker is ready");
    let context = Context {
        queue: settings.queue,
        blobs: settings.blobs,
        changes: settings.changes,
        engine: Engine { device, weights: settings.weights },
        limits: settings.limits,
        drain: settings.drain,
        drain_timeout: settings.drain_timeout,
    };
    let renew = take_jobs(&context, &worker).await;
    heart.abort();
    // A heart beat after this would register the worker anew.
    let _ = heart.await;
    context.queue.leave(&worker.id).await?;
    tracing::info!(worker = worker.id, renew, "worker leaves");
    Ok(renew)
}

/// The device, once it has shown that it computes.
async fn ready_device(choice: DeviceChoice) -> Result<Device, WorkerError> {
    let ready = tokio::task::spawn_blocking(move || {
        let device = device::choose(&choice)?;
        device::probe(&device)?;
        Ok::<_, device::DeviceError>(device)
    });
    Ok(ready.await.map_err(std::io::Error::from)??)
}

/// Take job after job until told to shut down; says whether the process must be renewed.
async fn take_jobs(context: &Context, worker: &Worker) -> bool {
    let mut changes = context.changes.clone();
    while !context.drain.is_cancelled() {
        let wait = match context.queue.claim(worker).await {
            Ok(Some(claim)) => match attempt::run(context, claim).await {
                Ok(Next::Go) => continue,
                Ok(Next::Renew) => return true,
                Err(error) => {
                    tracing::error!(%error, "the end of an attempt cannot be committed");
                    return true;
                }
            },
            Ok(None) => IDLE,
            Err(error) => {
                tracing::error!(%error, "cannot ask for a job");
                tokio::time::sleep(AFTER_ERROR).await;
                continue;
            }
        };
        // Subscribed before the look: a job that was queued in between wakes this up.
        tokio::select! {
            () = changes.changed_within(wait) => {}
            () = context.drain.cancelled() => {}
        }
    }
    false
}

async fn beat(queue: Arc<dyn Work>, mut worker: Worker, drain: CancellationToken) {
    loop {
        tokio::select! {
            () = tokio::time::sleep(HEARTBEAT) => {}
            () = drain.cancelled(), if !worker.draining => worker.draining = true,
        }
        if let Err(error) = queue.register(&worker).await {
            tracing::warn!(%error, "a sign of life cannot be written");
        }
    }
}
