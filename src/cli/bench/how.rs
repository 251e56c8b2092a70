//! How every benchmark unwraps: on which device, with which options.

use anyhow::{Result, bail};

use crate::cli::input::Files;
use crate::contract::{Limits, Run, UnwrapOptions};
use crate::device::{self, Device, DeviceChoice};
use crate::pipeline::{self, Unwrapped};

/// Arguments that the benchmarks share.
#[derive(Debug, clap::Args)]
pub struct How {
    /// Device to train on: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    device: DeviceChoice,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

impl How {
    /// The device; an error for options that no object could be unwrapped with.
    pub fn device(&self) -> Result<Device> {
        if let Err(errors) = self.options.validate() {
            bail!("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"));
        }
        Ok(device::choose(&self.device)?)
    }
}

/// Unwrap an object, quietly and within the limits of the service.
pub fn unwrap(files: &Files, options: &UnwrapOptions, device: &Device) -> Result<Unwrapped> {
    let limits = Limits::default();
    Ok(pipeline::unwrap_input(&files.input(), options, &limits, device, &Run::quiet())?)
}
