//! `uvsegnet segment`: the parts of one file, one label a face.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};

use super::progress_bar;
use crate::contract::{Limits, MeshKind, Seed, SegmentationSource, UnwrapOptions};
use crate::pipeline::{self, Input};

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
    /// Seed of the sampling.
    #[arg(long, default_value_t)]
    pub seed: Seed,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let read = |path: &PathBuf| {
        std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))
    };
    let bytes = read(&args.input)?;
    let labels = args.labels.as_ref().map(read).transpose()?;
    let kind = MeshKind::detect(&bytes).ok_or_else(|| {
        anyhow!("{} is no GLB, glTF or OBJ file: convert it first", args.input.display())
    })?;
    let options =
        UnwrapOptions { segmentation: args.segmentation, seed: args.seed, ..Default::default() };
    let (run, bar) = progress_bar::run(&options);
    let input = Input { bytes: &bytes, kind, labels: labels.as_deref() };
    let result = pipeline::segment_input(&input, &options, &Limits::default(), &run);
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
