//! `uvsegnet serve`: the whole service. Composed here: the API, the supervisor of the local workers,
//! and the housekeeping.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::num::NonZeroUsize;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::log::LogFlag;
use super::threads::ThreadsFlag;
use super::weights::WeightFlags;
use crate::config::{DataDir, LimitFlags, TimeFlags, host_name};
use crate::device::DeviceChoice;
use crate::http::{self, AppState};
use crate::jobs::{self, Housekeeping, Keep, Kept, Policy, Schema};
use crate::telemetry;
use crate::worker::Supervisor;

/// Arguments of `uvsegnet serve`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Address to listen on; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS", env = "UVSEGNET_LISTEN")]
    #[arg(default_value_t = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080))]
    pub listen: SocketAddr,
    /// Listen on an address that other hosts can reach, though anybody may use the service.
    #[arg(long)]
    pub insecure: bool,
    /// Where everything is kept.
    #[command(flatten)]
    pub data: DataDir,
    /// Worker processes to start; 0 leaves the work to workers started by hand.
    #[arg(long, value_name = "N", env = "UVSEGNET_WORKERS", default_value_t = 1)]
    pub workers: usize,
    /// Threads of all workers together, divided among them; by default as many as the processors, the affinity mask
    /// and the cgroup of the process allow.
    #[arg(long, value_name = "N", env = "UVSEGNET_THREADS")]
    pub threads: Option<NonZeroUsize>,
    /// What is logged.
    #[command(flatten)]
    pub log: LogFlag,
    /// Where the workers compute: auto, cpu, gpu or gpu:N.
    #[arg(long, env = "UVSEGNET_DEVICE", default_value_t)]
    pub device: DeviceChoice,
    /// Which weights the workers have.
    #[command(flatten)]
    pub weights: WeightFlags,
    /// What is accepted.
    #[command(flatten)]
    pub limits: LimitFlags,
    /// How long things take.
    #[command(flatten)]
    pub times: TimeFlags,
}

/// Serve until told to stop.
pub fn run(args: Args) -> Result<()> {
    telemetry::init(args.log.told());
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    runtime.block_on(async {
        let stop = CancellationToken::new();
        super::signals::cancel_on_signal(stop.clone(), false)?;
        let service = Service::start(args).await?;
        println!("uvsegnet listens on http://{}", service.address());
        tokio::select! {
            () = stop.cancelled() => {}
            () = service.ended() => tracing::error!("the API ended by itself"),
        }
        tracing::info!("shutting down");
        service.stop().await
    })
}

/// A service that runs. Where its runtime ends without [`Service::stop`], its workers are killed, and
/// their jobs are taken up at the next start.
pub struct Service {
    address: SocketAddr,
    /// Readiness ends, no job is accepted or claimed.
    drain: CancellationToken,
    /// Streams end, nobody is let in any more, housekeeping ends.
    close: CancellationToken,
    api: JoinHandle<std::io::Result<()>>,
    supervisor: JoinHandle<()>,
    housekeeping: JoinHandle<()>,
    api_ended: CancellationToken,
}

impl Service {
    /// Start everything; the API answers when this returns, the workers may take a moment more.
    pub async fn start(args: Args) -> Result<Self> {
        if !args.listen.ip().to_canonical().is_loopback() && !args.insecure {
            bail!(
                "refusing to listen on {}: the service has no keys yet, so anybody who reaches it \
                 may use it. Listen on 127.0.0.1, or say --insecure",
                args.listen
            );
        }
        let policy = Policy { retention: args.times.retention(), ..Policy::default() };
        let Kept { queue, changes, presence, blobs } =
            jobs::open(&args.data, policy, Schema::Migrate).await?;
        let listener = TcpListener::bind(args.listen)
            .await
            .with_context(|| format!("cannot listen on {}", args.listen))?;
        let address = listener.local_addr()?;

        let (drain, close) = (CancellationToken::new(), CancellationToken::new());
        let supervisor = supervisor(&args, queue.clone())?.run(drain.clone());
        let housekeeping = Housekeeping {
            queue: queue.clone(),
            blobs: blobs.clone(),
            presence,
            host: host_name(),
        };
        let state = AppState {
            queue,
            blobs,
            changes,
            limits: args.limits.limits(),
            draining: drain.clone(),
            closing: close.clone(),
        };
        let api_ended = CancellationToken::new();
        let guard = api_ended.clone().drop_guard();
        Ok(Self {
            address,
            api: tokio::spawn(async move {
                let _guard = guard;
                http::serve(listener, state).await
            }),
            supervisor: tokio::spawn(supervisor),
            housekeeping: tokio::spawn(housekeeping.run(close.clone())),
            drain,
            close,
            api_ended,
        })
    }

    /// Where the API listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits until the API has ended by itself, which it should not.
    pub async fn ended(&self) {
        self.api_ended.cancelled().await;
    }

    /// Shut down in order: take nothing new, let running jobs finish or hand them back, end the
    /// streams, leave.
    pub async fn stop(self) -> Result<()> {
        self.drain.cancel();
        self.supervisor.await.context("the supervisor failed")?;
        self.close.cancel();
        self.housekeeping.await.context("the housekeeping failed")?;
        self.api.await.context("the API failed")?.context("the API failed")
    }
}

fn supervisor(args: &Args, queue: Arc<dyn Keep>) -> Result<Supervisor> {
    let mut flags = args.data.to_flags();
    flags.extend(["--device".into(), args.device.to_string().into()]);
    flags.extend(args.weights.flags());
    flags.extend(args.limits.to_flags());
    flags.extend(args.times.to_flags());
    flags.extend(args.log.flag());
    let threads = ThreadsFlag { threads: args.threads }.count();
    Ok(Supervisor {
        program: std::env::current_exe().context("cannot find this program")?,
        flags,
        count: args.workers,
        threads: (threads / args.workers.max(1)).max(1),
        queue,
        drain_timeout: args.times.drain_timeout(),
    })
}
