//! `uvsegnet bench sheet`: many objects on one picture, to be looked at.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};

use super::files::{Shard, guarded, named, stem};
use super::options::{BenchOptions, unwrap};
use crate::cli::ending;
use crate::cli::input::{Beside, Files};
use crate::contract::{ArtifactKind, MeshKind, Metrics, UnwrapOptions};
use crate::pipeline::Engine;
use crate::preview::{SheetCell, contact_sheet};

/// Arguments of `uvsegnet bench sheet`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes, searched to the bottom.
    #[arg(help = format!("Folder of meshes ({}), searched to the bottom", MeshKind::names()))]
    pub dir: PathBuf,
    /// Where the picture goes (PNG).
    #[arg(short, long, default_value = "sheet.png", value_parser = ending::of(vec![ArtifactKind::Preview]))]
    pub output: PathBuf,
    /// Which objects: one file name without its extension a line, # begins a comment.
    #[arg(long, conflicts_with_all = ["limit", "shard"])]
    pub names: Option<PathBuf>,
    /// At most so many objects.
    #[arg(long)]
    pub limit: Option<usize>,
    /// I/N: every N-th object, by file size, from the I-th on.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Objects a row.
    #[arg(long, default_value_t = 5)]
    pub columns: usize,
    #[command(flatten)]
    pub bench: BenchOptions,
}

/// Run it. An object that fails has an empty place on the sheet, and the command fails in the end.
pub fn run(args: Args) -> Result<()> {
    let engine = args.bench.engine()?;
    let mut paths = match &args.names {
        Some(names) => named(&args.dir, names)?,
        None => args.shard.of(&args.dir)?,
    };
    paths.truncate(args.limit.unwrap_or(usize::MAX));
    let mut failed = 0;
    let mut cells = Vec::new();
    for path in &paths {
        let cell = guarded(|| cell(path, &args.bench.options, &engine)).unwrap_or_else(|error| {
            failed += 1;
            SheetCell { preview: None, caption: vec![stem(path), format!("{error:#}")] }
        });
        eprintln!("{}", cell.caption.join(", "));
        cells.push(cell);
    }
    let sheet = contact_sheet(&cells, args.columns)?;
    std::fs::write(&args.output, sheet)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    if failed > 0 {
        bail!("{failed} of {} objects could not be unwrapped", paths.len());
    }
    Ok(())
}

/// One object: unwrapped, with its name and its figures.
fn cell(path: &Path, options: &UnwrapOptions, engine: &Engine) -> Result<SheetCell> {
    let files = Files::read(path, &Beside::default())?;
    let unwrapped = unwrap(&files, options, engine)?;
    let preview = unwrapped.artifact(ArtifactKind::Preview).ok_or_else(|| anyhow!("no preview"))?;
    let mut caption = vec![stem(path)];
    caption.extend(figures(&unwrapped.metrics));
    Ok(SheetCell { preview: Some(preview.to_vec()), caption })
}

/// Charts, seam length over √area, symmetric Dirichlet energy.
fn figures(metrics: &Metrics) -> [String; 2] {
    let atlas = &metrics.atlas;
    let number = |x: Option<f64>, digits: usize| x.map_or("-".into(), |x| format!("{x:.digits$}"));
    let seam = atlas.figures.seam_length.map(|s| s.per_sqrt_area);
    [
        format!("{} charts, seam {}", atlas.charts, number(seam, 2)),
        format!("SD {}", number(atlas.figures.symmetric_dirichlet, 4)),
    ]
}
