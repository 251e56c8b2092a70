//! `uvsegnet bench same`: whether this program makes the same files as another build of it. Each object
//! is unwrapped by both, each with one thread and with two, as processes of their own; every artifact is
//! compared by its SHA-256, and of `metrics.json` every figure, less what tells of the run.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::files::{Shard, guarded, stem};

/// Members of `metrics.json` that tell of the run and of the program, not of the result.
const OF_THE_RUN: [&str; 2] = ["cost", "engine"];

/// The same of its summary.
const OF_THE_RUN_IN_SUMMARY: &str = "seconds";

/// Threads of each run.
const THREADS: [usize; 2] = [1, 2];

/// What `unwrap` writes, by the flag that asks for it.
const FILES: [(&str, &str); 4] = [
    ("--output", "model.glb"),
    ("--metrics", "metrics.json"),
    ("--layout", "uv_layout.svg"),
    ("--preview", "preview.png"),
];

/// Arguments of `uvsegnet bench same`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The other program.
    pub old: PathBuf,
    /// Folders of meshes, each searched to the bottom.
    #[arg(required = true)]
    pub dirs: Vec<PathBuf>,
    /// Only the I-th of N shares of each folder.
    #[arg(long, value_name = "I/N", default_value_t)]
    pub shard: Shard,
    /// Write one JSON line an object here, with the digest of every file.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// A difference that is meant, as it is printed: it is told and is no error.
    #[arg(long, value_name = "WHAT")]
    pub expect: Vec<String>,
    /// What both programs are told besides, as in `-- --quality fast`.
    #[arg(last = true)]
    pub options: Vec<String>,
}

/// What one run of one program left.
#[derive(Debug, Serialize)]
struct Run {
    /// SHA-256 of each file; of `metrics.json` of what does not tell of the run.
    digests: BTreeMap<&'static str, String>,
    /// What it said where it wrote nothing.
    refused: Option<String>,
    seconds: f64,
    #[serde(skip)]
    metrics: Value,
}

/// One object.
#[derive(Debug, Serialize)]
struct Row {
    object: String,
    old: Vec<Run>,
    new: Vec<Run>,
    /// Files that differ, of `metrics.json` the members.
    differ: BTreeSet<String>,
}

/// Run it: a line for each object that differs, and which files and members do in how many objects. An
/// error if any does.
pub fn run(args: Args) -> Result<()> {
    let new = std::env::current_exe().context("cannot find this program")?;
    let folder = std::env::temp_dir().join(format!("uvsegnet-same-{}", std::process::id()));
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let compared = compare_all(&args, &new, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    let (objects, what, failed) = compared?;
    for (what, objects) in &what {
        println!("{what}: {} objects, the first {}", objects.len(), objects[0]);
    }
    let meant = |what: &String| args.expect.contains(what);
    let differing: BTreeSet<&String> =
        what.iter().filter(|(what, _)| !meant(what)).flat_map(|(_, objects)| objects).collect();
    let same = objects - differing.len() - failed;
    let but = if what.keys().any(meant) { " but for what is expected" } else { "" };
    println!(
        "{objects} objects: {same} the same{but}, {} differ, {failed} failed",
        differing.len()
    );
    if same < objects {
        bail!("{} of {objects} objects are not the same", objects - same)
    }
    Ok(())
}

/// How many objects there are, which of them differ in what, and how many could not be compared.
fn compare_all(
    args: &Args,
    new: &Path,
    folder: &Path,
) -> Result<(usize, BTreeMap<String, Vec<String>>, usize)> {
    let mut lines = String::new();
    let (mut objects, mut failed) = (0, 0);
    let mut what: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for dir in &args.dirs {
        for path in args.shard.of(dir)? {
            objects += 1;
            let name = stem(&path);
            let row = match guarded(|| compare(&path, args, new, folder)) {
                Ok(row) => row,
                Err(error) => {
                    failed += 1;
                    println!("{name}: {error:#}");
                    continue;
                }
            };
            if !row.differ.is_empty() {
                let list: Vec<&str> = row.differ.iter().map(String::as_str).collect();
                println!("{name}: {}", list.join(", "));
            }
            for one in &row.differ {
                what.entry(one.clone()).or_default().push(name.clone());
            }
            if let Some(output) = &args.output {
                lines += &serde_json::to_string(&row)?;
                lines.push('\n');
                std::fs::write(output, &lines)
                    .with_context(|| format!("cannot write {}", output.display()))?;
            }
        }
    }
    Ok((objects, what, failed))
}

fn compare(path: &Path, args: &Args, new: &Path, folder: &Path) -> Result<Row> {
    let runs = |program: &Path| {
        let run = |threads| unwrap(program, path, threads, &args.options, folder);
        THREADS.into_iter().map(run).collect::<Result<Vec<Run>>>()
    };
    let (old, new) = (runs(&args.old)?, runs(new)?);
    let first = &old[0];
    let mut differ = BTreeSet::new();
    for run in old[1..].iter().chain(&new) {
        if first.refused != run.refused {
            differ.insert("what is said of a refused file".to_owned());
        }
        for (_, name) in FILES {
            if first.digests.get(name) != run.digests.get(name) && name != "metrics.json" {
                differ.insert(name.to_owned());
            }
        }
        members("", &first.metrics, &run.metrics, &mut differ);
    }
    Ok(Row { object: stem(path), old, new, differ })
}

/// One object by one program.
fn unwrap(
    program: &Path,
    path: &Path,
    threads: usize,
    options: &[String],
    folder: &Path,
) -> Result<Run> {
    let mut command = Command::new(program);
    command.arg("unwrap").arg(path).args(options).env("RAYON_NUM_THREADS", threads.to_string());
    for (flag, name) in FILES {
        let _ = std::fs::remove_file(folder.join(name));
        command.arg(flag).arg(folder.join(name));
    }
    let began = Instant::now();
    let output = command.output().with_context(|| format!("cannot run {}", program.display()))?;
    let seconds = began.elapsed().as_secs_f64();
    let mut run = Run { digests: BTreeMap::new(), refused: None, seconds, metrics: Value::Null };
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let said = said.lines().filter(|line| line.starts_with("error:"));
        run.refused = Some(said.collect::<Vec<_>>().join("\n"));
        if output.status.code().is_none() || run.refused.as_deref() == Some("") {
            return Err(anyhow!("{} ended with {}", program.display(), output.status));
        }
        return Ok(run);
    }
    for (_, name) in FILES {
        // What a job that ends early does not make is not there.
        let Ok(bytes) = std::fs::read(folder.join(name)) else { continue };
        let bytes = if name == "metrics.json" {
            run.metrics = serde_json::from_slice(&bytes).context("metrics.json is no JSON")?;
            if let Some(metrics) = run.metrics.as_object_mut() {
                OF_THE_RUN.iter().for_each(|member| drop(metrics.shift_remove(*member)));
                if let Some(summary) = metrics.get_mut("summary").and_then(Value::as_object_mut) {
                    summary.shift_remove(OF_THE_RUN_IN_SUMMARY);
                }
            }
            run.metrics.to_string().into_bytes()
        } else {
            bytes
        };
        let digest = Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect();
        run.digests.insert(name, digest);
    }
    Ok(run)
}

/// Members of two values that differ, as JSON pointers with `*` for an index.
fn members(place: &str, old: &Value, new: &Value, differ: &mut BTreeSet<String>) {
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                match (a.get(key), b.get(key)) {
                    (Some(x), Some(y)) => members(&format!("{place}/{key}"), x, y, differ),
                    (_, new) => {
                        let how = if new.is_none() { "gone" } else { "new" };
                        differ.insert(format!("metrics.json {place}/{key} ({how})"));
                    }
                }
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).for_each(|(x, y)| members(&format!("{place}/*"), x, y, differ));
        }
        _ if old == new => {}
        _ => {
            differ.insert(format!("metrics.json {place}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn members_that_differ_are_named_by_their_place() {
        let old = json!({"atlas": {"charts": 3, "pages": 1}, "parts": [{"id": 0}, {"id": 1}]});
        let new =
            json!({"atlas": {"charts": 3, "pages": 2, "x": 0}, "parts": [{"id": 0}, {"id": 2}]});
        let mut differ = BTreeSet::new();
        members("", &old, &new, &mut differ);
        let differ: Vec<String> = differ.into_iter().collect();
        assert_eq!(
            differ,
            [
                "metrics.json /atlas/pages",
                "metrics.json /atlas/x (new)",
                "metrics.json /parts/*/id"
            ]
        );
        let mut none = BTreeSet::new();
        members("", &old, &old, &mut none);
        assert!(none.is_empty());
    }
}
