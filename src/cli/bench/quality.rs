//! `uvsegnet bench quality`: which objects, in which order, what was done before, and the table at
//! the end. One JSON line an object; lines that are there already are not made again.

use std::collections::BTreeSet;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, Result, bail};

use super::object::{self, Arms};
use super::table;
use crate::contract::UnwrapOptions;
use crate::device::{self, DeviceChoice};

/// Arguments of `uvsegnet bench quality`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of meshes (GLB, glTF, OBJ), searched to the bottom. Labels are taken from
    /// NAME.inst.txt or NAME.labels.txt beside NAME.obj.
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
    /// Leave the arms out that unwrap an object again: at the peer's distortion, and along given
    /// labels.
    #[arg(long)]
    pub single: bool,
    /// A program that judges the results, run as COMMAND MODEL.glb --original INPUT --json FILE;
    /// what it writes to FILE becomes `judge` in the object's line.
    #[arg(long)]
    pub judge: Option<String>,
    /// Where the models go; they are not kept otherwise.
    #[arg(long)]
    pub models: Option<PathBuf>,
    /// Device to train on: auto, cpu, gpu or gpu:N.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    #[command(flatten)]
    pub options: UnwrapOptions,
}

/// The I-th of N shares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed =
            text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((index, count)) if index < count => Ok(Self { index, count }),
            _ => Err("must be I/N with I < N, for example 0/4".into()),
        }
    }
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    if let Err(errors) = args.options.validate() {
        bail!("{}", errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"));
    }
    let mut files = Vec::new();
    meshes(&args.dir, &mut files)?;
    files.sort();
    let shard = files
        .into_iter()
        .enumerate()
        .filter(|(i, _)| i % args.shard.count == args.shard.index)
        .map(|(_, (_, path))| path);
    let done = done(&args.output)?;
    let device = device::choose(&args.device)?;
    let folder = std::env::temp_dir().join(format!("uvsegnet-bench-{}", std::process::id()));
    for folder in [Some(&folder), args.models.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    let arms = Arms {
        options: &args.options,
        device: &device,
        single: args.single,
        judge: args.judge.as_deref(),
        folder: &folder,
        models: args.models.as_deref(),
    };
    let mut lines = OpenOptions::new()
        .create(true)
        .append(true)
        .open(&args.output)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    let named = |path: &Path| path.strip_prefix(&args.dir).unwrap_or(path).display().to_string();
    let open = shard.filter(|path| !done.contains(&named(path)));
    for path in open.take(args.limit.unwrap_or(usize::MAX)) {
        let line = object::line(&named(&path), &path, &arms);
        eprintln!("{}", table::brief(&line));
        writeln!(lines, "{line}").context("cannot write a line")?;
    }
    std::fs::remove_dir_all(&folder).ok();
    println!("{}", table::table(&table::read(&args.output)?));
    Ok(())
}

/// Every mesh under a folder with its size.
fn meshes(dir: &Path, into: &mut Vec<(u64, PathBuf)>) -> Result<()> {
    let entries = std::fs::read_dir(dir)
        .with_context(|| format!("cannot read the folder {}", dir.display()))?;
    for entry in entries {
        let path = entry?.path();
        let kind = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        if path.is_dir() {
            meshes(&path, into)?;
        } else if matches!(kind.as_deref(), Some("obj" | "glb" | "gltf")) {
            into.push((path.metadata()?.len(), path));
        }
    }
    Ok(())
}

/// Names of the objects that have a line.
fn done(output: &Path) -> Result<BTreeSet<String>> {
    if !output.exists() {
        return Ok(BTreeSet::new());
    }
    let lines = table::read(output)?;
    Ok(lines.iter().filter_map(|l| l["object"].as_str().map(str::to_owned)).collect())
}
