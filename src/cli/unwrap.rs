//! `uvsegnet unwrap`: the pipeline on one file, without a server.

use std::path::PathBuf;

use anyhow::Result;

use super::input::{Beside, Files};
use super::options::valid;
use super::outputs::Outputs;
use super::told;
use super::watched::{self, Quiet};
use super::weights::WeightFlags;
use crate::contract::{Limits, MeshKind, UnwrapOptions};
use crate::device::DeviceChoice;
use crate::pipeline;

/// Arguments of `uvsegnet unwrap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(help = format!("The mesh: {}", MeshKind::inputs()))]
    pub input: PathBuf,
    /// Where the files go.
    #[command(flatten)]
    pub outputs: Outputs,
    /// What stands beside the mesh.
    #[command(flatten)]
    pub beside: Beside,
    /// Device to train on: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: WeightFlags,
    #[command(flatten)]
    pub quiet: Quiet,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    valid(&args.options)?;
    let files = Files::read(&args.input, &args.beside)?;
    let engine = args.weights.engine(&args.device)?;
    let (run, watcher) = watched::run(&args.options, args.quiet);
    // What is not kept is not drawn.
    let preview = args.options.preview && args.outputs.hold_pictures();
    let options = UnwrapOptions { preview, ..args.options };
    let result =
        pipeline::unwrap_input(&files.input(), &options, &Limits::default(), &engine, &run);
    drop(watcher);
    let unwrapped = result.map_err(|error| told::error(&error))?;
    args.outputs.write(&unwrapped)?;
    if !args.quiet.quiet {
        eprintln!("{}", told::as_flags(&unwrapped.summary()));
    }
    Ok(())
}
