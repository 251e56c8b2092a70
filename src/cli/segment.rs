//! `uvsegnet segment`: the parts of one file, as text, as a model, or as a picture.

use std::path::PathBuf;

use anyhow::{Context, Result};

use super::ending;
use super::input::{Beside, Files};
use super::options::{PartOptions, valid};
use super::told;
use super::watched::{self, Quiet};
use super::weights::WeightFlags;
use crate::contract::{ArtifactKind, Limits, MeshKind, StopAfter, UnwrapOptions};
use crate::device::DeviceChoice;
use crate::pipeline;

/// Arguments of `uvsegnet segment`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(help = format!("The mesh: {}", MeshKind::inputs()))]
    pub input: PathBuf,
    /// Where the parts go, by its ending: X.glb is the model with the part of each face in `_PART` and
    /// names and confidences in its extras; X.json the metrics; X.png a picture; X.txt, or X without an
    /// ending, text: one integer a line, line i for face i, −1 for a face without area.
    #[arg(short, long, value_parser = ending::of(of_parts()))]
    pub output: PathBuf,
    /// What the parts depend on.
    #[command(flatten)]
    pub options: PartOptions,
    /// What stands beside the mesh.
    #[command(flatten)]
    pub beside: Beside,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: WeightFlags,
    #[command(flatten)]
    pub quiet: Quiet,
    /// Where the network runs: cpu, gpu, gpu:N, auto.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
}

/// What a job that ends with its parts writes.
fn of_parts() -> Vec<ArtifactKind> {
    ArtifactKind::ALL.iter().copied().filter(|kind| kind.when().is_of_parts()).collect()
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let stop_after = Some(StopAfter::Segmentation);
    let options = UnwrapOptions { stop_after, ..args.options.0 };
    valid(&options)?;
    let files = Files::read(&args.input, &args.beside)?;
    let engine = args.weights.engine(&args.device)?;
    let wanted = ending::kind(&args.output, &of_parts()).unwrap_or(ArtifactKind::Labels);
    let (run, watcher) = watched::run(&options, args.quiet);
    let result =
        pipeline::unwrap_input(&files.input(), &options, &Limits::default(), &engine, &run);
    drop(watcher);
    let result = result.map_err(|error| told::error(&error))?;
    let bytes = result.artifact(wanted).context("the result lacks a file")?;
    std::fs::write(&args.output, bytes)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    for part in result.metrics.parts.iter().filter(|_| !args.quiet.quiet) {
        eprintln!(
            "{:>5}  {}  ({}, confidence {:.2})",
            part.id, part.name, part.source, part.confidence
        );
    }
    Ok(())
}
