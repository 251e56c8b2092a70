//! The meshes of a benchmark: all under a folder by size, or those that a list names.

use std::any::Any;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, Result, anyhow, bail};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::contract::MeshKind;

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

impl Shard {
    /// This share of the meshes under a folder, by file size.
    pub fn of(self, dir: &Path) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        meshes(dir, &mut files)?;
        files.sort();
        let own = |(i, (_, path)): (usize, (u64, PathBuf))| {
            (i % self.count == self.index).then_some(path)
        };
        Ok(files.into_iter().enumerate().filter_map(own).collect())
    }
}

/// Write one JSON line a row.
pub fn write_rows<T: Serialize>(path: &Path, rows: &[T]) -> Result<()> {
    let mut lines = String::new();
    for row in rows {
        lines += &serde_json::to_string(row)?;
        lines += "\n";
    }
    std::fs::write(path, lines).with_context(|| format!("cannot write {}", path.display()))
}

/// A file that lines are added to.
pub fn appending(path: &Path) -> Result<File> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    file.with_context(|| format!("cannot write {}", path.display()))
}

/// Read one JSON row a line.
pub fn read_rows<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let row = |(i, line)| {
        let place = || format!("{} line {}: not a line of this benchmark", path.display(), i + 1);
        serde_json::from_str(line).with_context(place)
    };
    lines.map(row).collect()
}

/// The meshes under a folder that a list names, in its order. The list has one file name without its
/// extension a line; `#` begins a comment. A name that is not there, or is there twice, is an error.
pub fn named(dir: &Path, list: &Path) -> Result<Vec<PathBuf>> {
    let text =
        std::fs::read_to_string(list).with_context(|| format!("cannot read {}", list.display()))?;
    let mut files = Vec::new();
    meshes(dir, &mut files)?;
    let mut by_name: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for (_, path) in files {
        by_name.entry(stem(&path)).or_default().push(path);
    }
    let names = text.lines().map(|line| line.split('#').next().unwrap_or_default().trim());
    let find = |name: &str| match by_name.get(name).map(Vec::as_slice) {
        Some([path]) => Ok(path.clone()),
        Some(_) => bail!("{} has more than one {name}", dir.display()),
        None => {
            bail!("{} has no {name} with the ending {}", dir.display(), MeshKind::all_endings())
        }
    };
    names.filter(|name| !name.is_empty()).map(find).collect()
}

/// The name of a file without its extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Do the work; a panic is an error like any other, so that one object does not end a benchmark.
pub fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    let panicked = |_: Box<dyn Any + Send>| Err(anyhow!("panicked"));
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(panicked)
}

/// Every mesh under a folder with its size.
fn meshes(dir: &Path, into: &mut Vec<(u64, PathBuf)>) -> Result<()> {
    let entries = std::fs::read_dir(dir)
        .with_context(|| format!("cannot read the folder {}", dir.display()))?;
    for entry in entries {
        let path = entry?.path();
        let kind = path.extension().and_then(|e| e.to_str()).and_then(MeshKind::of_ending);
        if path.is_dir() {
            meshes(&path, into)?;
        } else if kind.is_some() {
            into.push((path.metadata()?.len(), path));
        }
    }
    Ok(())
}
