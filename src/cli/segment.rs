//! `uvsegnet segment`: the parts of one file, one label a face.

use std::path::PathBuf;

use anyhow::{Context, Result};

use super::input::Files;
use super::progress_bar;
use super::weights::Weights;
use crate::contract::{Limits, Seed, SegmentationSource, UnwrapOptions};
use crate::device::{DeviceChoice, choose};
use crate::pipeline;

/// Arguments of `uvsegnet segment`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh: GLB, glTF with data URIs, or OBJ.
    pub input: PathBuf,
    /// Where the labels go: one integer a line, line i for face i, −1 for a face without area.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Where the parts come from.
    #[arg(long, value_enum, default_value_t)]
    pub segmentation: SegmentationSource,
    /// Labels that are known already.
    #[arg(long)]
    pub labels: Option<PathBuf>,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: Weights,
    /// Where the network runs: cpu, gpu, gpu:N, auto.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Seed of the sampling.
    #[arg(long, default_value_t)]
    pub seed: Seed,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    args.weights.apply();
    let device = choose(&args.device)?;
    let files = Files::read(&args.input, args.labels.as_deref())?;
    let options =
        UnwrapOptions { segmentation: args.segmentation, seed: args.seed, ..Default::default() };
    let (run, bar) = progress_bar::run(&options);
    let result =
        pipeline::segment_input(&files.input(), &options, &Limits::default(), &device, &run);
    bar.finish_and_clear();
    let parts = result?;
    let text = parts.to_text();
    std::fs::write(&args.output, text)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    for part in &parts.parts {
        eprintln!(
            "{:>5}  {}  ({}, confidence {:.2})",
            part.id, part.name, part.source, part.confidence
        );
    }
    Ok(())
}
