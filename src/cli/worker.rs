//! `uvsegnet worker`: one worker on the queue of a service. A server starts its own; more can be
//! started by hand on the same host.

use std::time::Duration;

use anyhow::{Context, Result};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;

use super::log::LogFlag;
use super::threads::ThreadsFlag;
use super::weights::WeightFlags;
use crate::config::{DataDir, LimitFlags, TimeFlags, host_name};
use crate::device::DeviceChoice;
use crate::jobs::{self, Kept, Policy, Schema};
use crate::worker::{EXIT_RENEW, WorkerSettings, watch_parent};
use crate::{telemetry, worker};

/// How long a worker waits for a server to bring the schema up to date.
const PATIENCE: Duration = Duration::from_secs(30);

/// Arguments of `uvsegnet worker`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Where everything is kept: the data directory of the server.
    #[command(flatten)]
    pub data: DataDir,
    /// Where to compute: auto, cpu, gpu or gpu:N.
    #[arg(long, env = "UVSEGNET_DEVICE", default_value_t)]
    pub device: DeviceChoice,
    /// How many threads it has.
    #[command(flatten)]
    pub threads: ThreadsFlag,
    /// What is logged.
    #[command(flatten)]
    pub log: LogFlag,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: WeightFlags,
    /// Id of this worker, which no other has or had; drawn if not given.
    #[arg(long)]
    pub id: Option<String>,
    /// What is accepted.
    #[command(flatten)]
    pub limits: LimitFlags,
    /// How long things take.
    #[command(flatten)]
    pub times: TimeFlags,
    /// Standard input is held by the server that started this: a line `drain` asks to finish, its
    /// end to exit at once.
    #[arg(long, hide = true)]
    pub supervised: bool,
}

/// Work until told to stop.
pub fn run(args: Args) -> Result<()> {
    telemetry::init(args.log.told());
    args.threads.start();
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    if runtime.block_on(work(args))? {
        // Without waiting for the pipeline's thread, which may be what must be got rid of.
        std::process::exit(EXIT_RENEW);
    }
    Ok(())
}

async fn work(args: Args) -> Result<bool> {
    let drain = CancellationToken::new();
    if args.supervised {
        watch_parent(drain.clone()).context("cannot watch the server")?;
    }
    super::signals::cancel_on_signal(drain.clone(), args.supervised)?;
    let policy = Policy { retention: args.times.retention(), ..Policy::default() };
    let Kept { queue, changes, presence, blobs } =
        jobs::open(&args.data, policy, Schema::Await(PATIENCE)).await?;
    let settings = WorkerSettings {
        id: args.id.unwrap_or_else(|| format!("w-{}", Uuid::now_v7().simple())),
        host: host_name(),
        queue,
        blobs,
        changes,
        presence,
        device: args.device,
        weights: args.weights.weights()?,
        limits: args.limits.limits(),
        drain,
        drain_timeout: args.times.drain_timeout(),
    };
    Ok(worker::run(settings).await?)
}
