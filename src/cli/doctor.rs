//! `uvsegnet doctor`: which device would be used, proved by a small computation.

use anyhow::Result;

use crate::device::{self, DeviceChoice};
use crate::tasks;

/// Arguments of `uvsegnet doctor`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Device to ask for: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    println!("uvsegnet {}", env!("CARGO_PKG_VERSION"));
    println!("threads that this process may use: {}", tasks::available());
    println!("devices this program can see:");
    for device in device::available() {
        println!("  {}", device.description());
    }
    let chosen = device::choose(&args.device)?;
    println!("--device {} would use: {}", args.device, chosen.description());
    let probe = device::probe(&chosen)?;
    println!("a matrix product and a gradient on it are right ({:.3} s)", probe.seconds);
    Ok(())
}
