//! `uvsegnet bench quality`: which objects, in which order, what was done before, and the table at
//! the end. One JSON line an object; lines that are there already are not made again.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::arms;
use super::files::{Shard, appending, read_rows};
use super::object::{self, Plan};
use super::options::BenchOptions;
use super::row::Row;
use super::table;
use crate::contract::MeshKind;

/// Arguments of `uvsegnet bench quality`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes, searched to the bottom. Labels are taken from NAME.inst.txt or
    /// NAME.labels.txt beside the mesh.
    #[arg(help = format!(
        "Folder of meshes ({}), searched to the bottom. Labels are taken from NAME.inst.txt or \
         NAME.labels.txt beside the mesh",
        MeshKind::names()
    ))]
    pub dir: PathBuf,
    /// One JSON line an object; an object that has a line is not unwrapped again.
    #[arg(short, long, default_value = "quality.jsonl")]
    pub output: PathBuf,
    /// At most so many objects in this run.
    #[arg(long)]
    pub limit: Option<usize>,
    /// I/N: every N-th object, by file size, from the I-th on.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Do not unwrap an object again: at the peer's distortion, and along given labels.
    #[arg(long)]
    pub single: bool,
    /// Cut each object once and map its charts every way that there is: carried over from the proxy, by a
    /// network, from the classical start, each polished. Tells which is best, instead of the usual figures.
    #[arg(long)]
    pub arms: bool,
    /// An independent measure of the results, run as COMMAND MODEL.glb --original INPUT --json FILE;
    /// what it writes to FILE becomes `independent` in the object's line.
    #[arg(long)]
    pub independent: Option<String>,
    /// Where the models go; they are not kept otherwise.
    #[arg(long)]
    pub models: Option<PathBuf>,
    #[command(flatten)]
    pub bench: BenchOptions,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let engine = args.bench.engine()?;
    let shard = args.shard.of(&args.dir)?.into_iter();
    let done = done(&args.output)?;
    let folder = std::env::temp_dir().join(format!("uvsegnet-bench-{}", std::process::id()));
    for folder in [Some(&folder), args.models.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let plan = Plan {
        options: &args.bench.options,
        engine: &engine,
        single: args.single,
        independent: args.independent.as_deref(),
        folder: &folder,
        models: args.models.as_deref(),
    };
    let mut lines = appending(&args.output)?;
    if args.arms {
        return arms::run(shard, args.limit, &args.bench.options, &engine, lines);
    }
    let named = |path: &Path| path.strip_prefix(&args.dir).unwrap_or(path).display().to_string();
    let open = shard.filter(|path| !done.contains(&named(path)));
    for path in open.take(args.limit.unwrap_or(usize::MAX)) {
        let line = object::line(&named(&path), &path, &plan);
        eprintln!("{}", table::brief(&line));
        writeln!(lines, "{}", serde_json::to_string(&line)?).context("cannot write a line")?;
    }
    std::fs::remove_dir_all(&folder).ok();
    println!("{}", table::table(&read_rows(&args.output)?));
    Ok(())
}

/// Names of the objects that have a line.
fn done(output: &Path) -> Result<BTreeSet<String>> {
    if !output.exists() {
        return Ok(BTreeSet::new());
    }
    let lines: Vec<Row> = read_rows(output)?;
    Ok(lines.into_iter().map(|l| l.object).collect())
}
