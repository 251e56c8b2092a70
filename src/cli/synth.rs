//! `uvsegnet synth`: make a labelled sample object.

use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::synth::{self, SynthKind, SynthStyle, SynthVariant};

/// Arguments of `uvsegnet synth`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What to make.
    #[arg(value_enum)]
    pub kind: SynthKind,
    /// Which one: the same seed always gives the same object.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How the parts stand in the file.
    #[arg(long, value_enum, default_value_t)]
    pub variant: SynthVariant,
    /// About how many triangles.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(200..=200_000))]
    pub triangles: u32,
    /// The GLB file to write; <KIND>.glb by default.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Write the part of each face here, one number a line.
    #[arg(long)]
    pub labels: Option<PathBuf>,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let style = SynthStyle { variant: args.variant, triangles: args.triangles as usize };
    let object = synth::make(args.kind, args.seed, style);
    let output = args.output.unwrap_or_else(|| format!("{}.glb", args.kind.as_str()).into());
    std::fs::write(&output, object.glb())
        .with_context(|| format!("cannot write {}", output.display()))?;
    if let Some(labels) = &args.labels {
        std::fs::write(labels, object.labels_text())
            .with_context(|| format!("cannot write {}", labels.display()))?;
    }
    let (triangles, parts) = (object.triangle_count(), object.parts.len());
    eprintln!("{}: {triangles} triangles, {parts} parts", output.display());
    Ok(())
}
