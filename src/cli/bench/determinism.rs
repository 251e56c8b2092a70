//! `uvsegnet bench determinism`: the promise of the same bytes, kept on given objects. Each is unwrapped with one
//! thread, two, three and eight, whose tasks end in disorder, and every file is compared.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rayon::ThreadPool;

use super::files::{guarded, named, stem};
use super::options::{BenchOptions, unwrap};
use crate::cli::input::{Beside, Files};
use crate::contract::{MeshKind, UnwrapOptions};
use crate::pipeline::{Engine, Unwrapped};
use crate::tasks;

/// Threads of each run; the others are held against the first.
const THREADS: [usize; 4] = [1, 2, 3, 8];

/// Arguments of `uvsegnet bench determinism`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes, searched to the bottom.
    #[arg(help = format!("Folder of meshes ({}), searched to the bottom", MeshKind::names()))]
    pub dir: PathBuf,
    /// Which objects: one file name without its extension a line, # begins a comment.
    #[arg(long)]
    pub names: PathBuf,
    #[command(flatten)]
    pub bench: BenchOptions,
}

/// Run it: one line an object, a summary; an error if any object differs or fails.
pub fn run(args: Args) -> Result<()> {
    let engine = args.bench.engine()?;
    let pool = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.context("cannot start the threads")
    };
    let pools = THREADS.iter().map(|&t| pool(t)).collect::<Result<Vec<_>>>()?;
    let paths = named(&args.dir, &args.names)?;
    let (mut same, mut differ, mut failed) = (0, 0, 0);
    for path in &paths {
        let verdict = match guarded(|| compare(path, &args.bench.options, &engine, &pools)) {
            Ok((text, true)) => {
                same += 1;
                text
            }
            Ok((text, false)) => {
                differ += 1;
                text
            }
            Err(error) => {
                failed += 1;
                format!("{error:#}")
            }
        };
        println!("{}: {verdict}", stem(path));
    }
    println!("{} objects: {same} the same bytes, {differ} differ, {failed} failed", paths.len());
    if same < paths.len() {
        bail!("{} of {} objects are not the same at every run", paths.len() - same, paths.len());
    }
    Ok(())
}

/// What is said of one object, and whether every run gave the same bytes.
fn compare(
    path: &Path,
    options: &UnwrapOptions,
    engine: &Engine,
    pools: &[ThreadPool],
) -> Result<(String, bool)> {
    let files = Files::read(path, &Beside::default())?;
    let unwrap = |pool: &ThreadPool| pool.install(|| unwrap(&files, options, engine));
    let first = unwrap(&pools[0])?;
    let mut text = format!("{} triangles", triangles(&first));
    let mut clocked = !first.metrics.deterministic;
    let mut same = true;
    for (pool, run) in pools.iter().zip(1..).skip(1) {
        tasks::disturb(run);
        let again = unwrap(pool);
        tasks::disturb(0);
        let again = again?;
        clocked |= !again.metrics.deterministic;
        let differing = first.differences(&again);
        if !differing.is_empty() {
            same = false;
            let names: Vec<&str> = differing.iter().map(|kind| kind.name()).collect();
            let threads = pool.current_num_threads();
            text += &format!(", run {run} ({threads} threads) differs: {}", names.join(", "));
        }
    }
    if same {
        text += ", ok";
    }
    if clocked {
        text += " (the clock stepped in: nothing was promised)";
    }
    Ok((text, same))
}

/// Triangles that have charts, with those that carry another's coordinates.
fn triangles(unwrapped: &Unwrapped) -> u64 {
    unwrapped.metrics.parts.iter().map(|part| part.faces).sum()
}
