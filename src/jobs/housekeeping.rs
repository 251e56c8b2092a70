//! What the server does beside answering: take back the jobs of dead workers, let go of what has
//! expired, sweep blobs that no row names.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};
use tokio_util::sync::CancellationToken;

use super::{Blobs, Keep, Presence};

/// How often leases are looked through.
const SWEEP: Duration = Duration::from_secs(1);
/// How often retention is looked at.
const EXPIRE: Duration = Duration::from_secs(60);
/// How often blobs are compared with rows.
const ORPHANS: Duration = Duration::from_secs(600);
/// Age below which a blob is not an orphan: its row may be about to commit.
const ORPHAN_GRACE: Duration = Duration::from_secs(3600);

/// The loops. One server needs them; several at once do no harm.
#[derive(Clone)]
pub struct Housekeeping {
    /// The queue to keep.
    pub queue: Arc<dyn Keep>,
    /// The blobs to keep.
    pub blobs: Blobs,
    /// Which workers of this host live.
    pub presence: Arc<dyn Presence>,
    /// The name of this host, as its workers register it.
    pub host: String,
}

impl Housekeeping {
    /// Keep house until told to stop. An error is logged and tried again at the next turn.
    pub async fn run(self, stop: CancellationToken) {
        let every = |period| {
            let mut timer = interval(period);
            timer.set_missed_tick_behavior(MissedTickBehavior::Delay);
            timer
        };
        let (mut sweep, mut expire, mut orphans) = (every(SWEEP), every(EXPIRE), every(ORPHANS));
        loop {
            tokio::select! {
                () = stop.cancelled() => return,
                _ = sweep.tick() => self.take_back().await,
                _ = expire.tick() => self.let_go().await,
                _ = orphans.tick() => self.sweep_orphans().await,
            }
        }
    }

    /// Take back the jobs of workers that are dead or silent.
    async fn take_back(&self) {
        if let Err(error) = self.queue.sweep().await {
            tracing::error!(%error, "cannot look through the leases");
        }
        match self.queue.workers_on(&self.host).await {
            Ok(workers) => {
                for worker in workers {
                    if self.presence.is_dead(&worker.id)
                        && let Err(error) = self.queue.worker_gone(&worker.id).await
                    {
                        tracing::error!(worker = worker.id, %error, "cannot forget a dead worker");
                    }
                }
            }
            Err(error) => tracing::error!(%error, "cannot list the workers of this host"),
        }
    }

    /// Let go of uploads and artifacts whose time is over, and of the locks of the dead.
    async fn let_go(&self) {
        if let Err(error) = self.presence.tidy() {
            tracing::warn!(%error, "cannot tidy away what dead workers left");
        }
        let blobs = match self.queue.expire().await {
            Ok(blobs) => blobs,
            Err(error) => return tracing::error!(%error, "cannot look for expired jobs"),
        };
        for blob in blobs {
            if let Err(error) = self.blobs.delete(&blob).await {
                tracing::warn!(blob, %error, "cannot delete an expired blob: the sweep will");
            }
        }
    }

    async fn sweep_orphans(&self) {
        match self.blobs.sweep_orphans(&*self.queue, ORPHAN_GRACE).await {
            Ok(0) => {}
            Ok(gone) => tracing::info!(gone, "swept blobs that no row names"),
            Err(error) => tracing::error!(%error, "cannot sweep orphaned blobs"),
        }
    }
}
