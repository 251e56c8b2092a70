//! How every benchmark unwraps: on which device, with which options.

use anyhow::Result;

use crate::cli::input::Files;
use crate::cli::options::valid;
use crate::contract::{Limits, Run, UnwrapOptions};
use crate::device::{self, DeviceChoice};
use crate::pipeline::{self, Engine, Unwrapped};

/// Arguments that the benchmarks share.
#[derive(Debug, clap::Args)]
pub struct BenchOptions {
    /// Device to train on: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    device: DeviceChoice,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

impl BenchOptions {
    /// What computes; an error for options that no object could be unwrapped with.
    pub fn engine(&self) -> Result<Engine> {
        valid(&self.options)?;
        Ok(Engine::new(device::choose(&self.device)?))
    }
}

/// Unwrap an object, quietly and within the limits of the service.
pub fn unwrap(files: &Files, options: &UnwrapOptions, engine: &Engine) -> Result<Unwrapped> {
    let limits = Limits::default();
    Ok(pipeline::unwrap_input(&files.input(), options, &limits, engine, &Run::quiet())?)
}
