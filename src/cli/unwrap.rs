//! `uvsegnet unwrap`: the pipeline on one file or many, without a server.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use super::input::{Beside, Files};
use super::many;
use super::options::valid;
use super::outputs::Outputs;
use super::threads::ThreadsFlag;
use super::told;
use super::watched::{self, Quiet};
use super::weights::WeightFlags;
use crate::contract::{Limits, MeshKind, UnwrapOptions};
use crate::device::DeviceChoice;
use crate::pipeline::{self, Unwrapped};

/// Arguments of `uvsegnet unwrap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh, or several of them.
    #[arg(
        required = true,
        value_name = "MESH",
        help = format!("The mesh: {}. With --folder, any number of them", MeshKind::inputs())
    )]
    pub meshes: Vec<PathBuf>,
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
    pub threads: ThreadsFlag,
    /// How many of several meshes are worked on at once; half as many again as there are threads if absent. Each may
    /// use the memory of a job.
    #[arg(long, value_name = "N")]
    pub at_once: Option<NonZeroUsize>,
    #[command(flatten)]
    pub quiet: Quiet,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    valid(&args.options)?;
    args.outputs.hold(&args.meshes)?;
    args.threads.start();
    let engine = args.weights.engine(&args.device)?;
    // What is not kept is not drawn.
    let preview = args.options.preview && args.outputs.hold_pictures();
    let options = UnwrapOptions { preview, ..args.options };
    let [mesh] = &args.meshes[..] else {
        if !args.beside.is_empty() {
            bail!(
                "{} meshes were given: what stands beside a mesh goes with one",
                args.meshes.len()
            );
        }
        let at_once =
            args.at_once.map_or_else(|| many::at_once(args.threads.count()), NonZeroUsize::get);
        let write = |mesh: &Path, result: &Unwrapped| args.outputs.write(mesh, result);
        return many::unwrap(&args.meshes, at_once, (&options, &engine), args.quiet.quiet, &write);
    };
    let files = Files::read(mesh, &args.beside)?;
    let (run, watcher) = watched::run(&options, args.quiet);
    let result =
        pipeline::unwrap_input(&files.input(), &options, &Limits::default(), &engine, &run);
    drop(watcher);
    let unwrapped = result.map_err(|error| told::error(&error))?;
    args.outputs.write(mesh, &unwrapped)?;
    if !args.quiet.quiet {
        eprintln!("{}", told::as_flags(&unwrapped.summary()));
    }
    Ok(())
}
