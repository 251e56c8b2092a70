//! Our own labelled folder: meshes `X.glb`, `X.obj` or in another known format, beside each `X.inst.txt`
//! (part of each face) or else `X.labels.txt` (one integer a line), and `X.parts.json`:
//!
//! ```json
//! {"category": "Chair", "family": "ikea_kyrre", "licence": "CC-BY-4.0",
//!  "labels": {"0": "leg", "1": "seat"}, "coarse": {"0": "leg"}, "semantic_auto": {"0": "leg"}}
//! ```
//!
//! `labels` and `coarse` name the numbers of `X.labels.txt`, `semantic_auto` those of the instances.
//! `coarse` is believed before `labels`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::names::name_index;
use crate::contract::{Limits, MeshKind, Run, Winding};
use crate::mesh::{self, Surface};

/// Why a labelled folder cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct FolderError {
    /// The file.
    pub file: String,
    /// What is wrong with it.
    pub reason: String,
}

/// `X.parts.json`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct PartsFile {
    category: String,
    family: String,
    licence: String,
    source: String,
    labels: BTreeMap<String, String>,
    coarse: BTreeMap<String, String>,
    semantic_auto: BTreeMap<String, String>,
}

/// An object of a labelled folder.
#[derive(Debug, Clone)]
pub struct LabelledMesh {
    /// Its file's name without the ending.
    pub id: String,
    /// Its category.
    pub category: String,
    /// Its family.
    pub family: String,
    /// Where it comes from.
    pub source: String,
    /// The conditioned surface.
    pub surface: Surface,
    /// Part of each face, −1 unknown.
    pub parts: Vec<i32>,
    /// Index into the network's names of each face, −1 unknown.
    pub names: Vec<i32>,
}

/// The meshes of a folder and below, in order of path.
pub fn meshes(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder).map_err(|e| error(&folder, e))?;
        for entry in entries {
            let path = entry.map_err(|e| error(&folder, e))?.path();
            let labelled = || {
                path.with_extension("inst.txt").exists()
                    || path.with_extension("labels.txt").exists()
            };
            if path.is_dir() {
                open.push(path);
            } else if path
                .extension()
                .and_then(|e| e.to_str())
                .and_then(MeshKind::of_ending)
                .is_some()
                && labelled()
            {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Whether the licence of a mesh begins with one of `licences`, or there are none to ask for.
pub fn is_allowed(mesh: &Path, licences: &[String]) -> Result<bool, FolderError> {
    if licences.is_empty() {
        return Ok(true);
    }
    let licence = parts_file(mesh)?.licence;
    Ok(licences.iter().any(|l| licence.starts_with(l.as_str())))
}

/// Read one labelled mesh.
pub fn read(path: &Path, run: &Run) -> Result<LabelledMesh, FolderError> {
    let bytes = std::fs::read(path).map_err(|e| error(path, e))?;
    let kind = MeshKind::detect(&bytes)
        .ok_or_else(|| error(path, format!("is no {} file", MeshKind::names())))?;
    let scene = mesh::import(&bytes, kind, &Limits::default()).map_err(|e| error(path, e))?;
    let faces = scene.face_count();
    let (inst, labels) = (path.with_extension("inst.txt"), path.with_extension("labels.txt"));
    let by_label = if labels.exists() { Some(numbers(&labels, faces)?) } else { None };
    let by_instance = if inst.exists() { Some(numbers(&inst, faces)?) } else { None };
    let about = parts_file(path)?;
    let index = |names: &BTreeMap<String, String>, number: i32| {
        names.get(&number.to_string()).and_then(|n| name_index(n)).map(|i| i as i32)
    };
    let parts = by_instance.or_else(|| by_label.clone());
    let parts = parts.ok_or_else(|| error(path, "has no labels beside it"))?;
    let name = |f: usize| {
        let label = by_label.as_ref().map_or(-1, |l| l[f]);
        index(&about.coarse, label)
            .or_else(|| index(&about.labels, label))
            .or_else(|| index(&about.semantic_auto, parts[f]))
            .unwrap_or(-1)
    };
    let names: Vec<i32> = (0..faces).map(name).collect();
    let surface =
        mesh::condition(&scene, Winding::Surface, run).map_err(|e| error(path, e))?.surface;
    let (parts, names) = (surface.from_file_order(&parts), surface.from_file_order(&names));
    let id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let family = if about.family.is_empty() { id.clone() } else { about.family };
    let (category, source) = (about.category, about.source);
    Ok(LabelledMesh { id, category, family, source, surface, parts, names })
}

fn parts_file(mesh: &Path) -> Result<PartsFile, FolderError> {
    let path = mesh.with_extension("parts.json");
    if !path.exists() {
        return Ok(PartsFile::default());
    }
    let text = std::fs::read_to_string(&path).map_err(|e| error(&path, e))?;
    let value: serde_json::Value = serde_json::from_str(&text).map_err(|e| error(&path, e))?;
    // Absent maps may be written as null.
    let mut value = value;
    if let Some(map) = value.as_object_mut() {
        map.retain(|_, v| !v.is_null());
    }
    serde_json::from_value(value).map_err(|e| error(&path, e))
}

fn numbers(path: &Path, faces: usize) -> Result<Vec<i32>, FolderError> {
    let bytes = std::fs::read(path).map_err(|e| error(path, e))?;
    mesh::import::parse_labels(&bytes, faces).map_err(|e| error(path, e))
}

/// An error in a file of a data set.
pub(super) fn error(file: &Path, reason: impl std::fmt::Display) -> FolderError {
    FolderError { file: file.display().to_string(), reason: reason.to_string() }
}
