//! `uvsegnet unwrap`: the pipeline on one file, without a server.

use std::path::PathBuf;

use anyhow::{Context, Result, bail};

use super::input::Files;
use super::progress_bar;
use super::weights::Weights;
use crate::contract::{Limits, MeshKind, UnwrapOptions};
use crate::device::{self, DeviceChoice};
use crate::pipeline;

/// Arguments of `uvsegnet unwrap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The mesh.
    #[arg(help = format!("The mesh: {}", MeshKind::inputs()))]
    pub input: PathBuf,
    /// Where the UV'd GLB goes.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Where the metrics go.
    #[arg(long)]
    pub metrics: Option<PathBuf>,
    /// Where the drawing of the UV layout goes (SVG).
    #[arg(long)]
    pub layout: Option<PathBuf>,
    /// Where the picture goes (PNG).
    #[arg(long)]
    pub preview: Option<PathBuf>,
    /// Part labels: one integer a line, line i for face i, −1 unknown.
    #[arg(long)]
    pub labels: Option<PathBuf>,
    /// Device to train on: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: Weights,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    if let Err(errors) = args.options.validate() {
        let lines: Vec<String> = errors
            .iter()
            .map(|e| {
                format!("--{} {}", e.pointer.trim_start_matches('/').replace('_', "-"), e.detail)
            })
            .collect();
        bail!("{}", lines.join("\n"));
    }
    args.weights.apply();
    let files = Files::read(&args.input, args.labels.as_deref())?;
    let device = device::choose(&args.device)?;
    let (run, bar) = progress_bar::run(&args.options);
    let result =
        pipeline::unwrap_input(&files.input(), &args.options, &Limits::default(), &device, &run);
    bar.finish_and_clear();
    let unwrapped = result?;
    for artifact in unwrapped.artifacts() {
        let path = match artifact.name {
            "model.glb" => Some(&args.output),
            "metrics.json" => args.metrics.as_ref(),
            "uv_layout.svg" => args.layout.as_ref(),
            "preview.png" => args.preview.as_ref(),
            _ => None,
        };
        if let Some(path) = path {
            std::fs::write(path, &artifact.bytes)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
    }
    eprintln!("{}", unwrapped.summary());
    Ok(())
}
