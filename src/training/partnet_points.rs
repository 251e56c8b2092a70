//! PartNet's point sets in HDF5 (`ins_seg_h5`, `ins_seg_h5_for_detection` and `sem_seg_h5` of
//! github.com/daerduoCarey/partnet_seg_exps), of N shapes with P points:
//!
//! | file | datasets | parts |
//! |---|---|---|
//! | instances | `pts` N × P × 3, `label` N × P; `X.json` beside `X.h5` | the leaves |
//! | for detection | `pts`, `gt_mask` N × K × P, `gt_valid` N × K | the masks |
//! | semantic | `data` N × P × 3, `label_seg` N × P | components of each label |
//!
//! Files lie in folders named after the category, such as `Chair` or `Chair-3`.

use std::path::{Path, PathBuf};

use glam::DVec3;
use hdf5_pure::{Dataset, File};
use serde::Deserialize;

use super::example::Example;
use super::folder::{FolderError, error};
use super::names::name_index;
use super::partnet_tree::json;
use super::points::LabelledPoints;
use crate::contract::Run;

/// Points of a shape that are taken at most.
const MOST: usize = 10_000;

/// One shape's record in the JSON file.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Record {
    anno_id: serde_json::Value,
    ins_seg: Vec<Instance>,
}

/// A part at some level of the hierarchy, by its leaves.
#[derive(Debug, Deserialize)]
struct Instance {
    part_name: String,
    leaf_id_list: Vec<i64>,
}

/// The `.h5` files of a folder and of the folders in it, in order of path.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    let list = |folder: &Path| -> Result<Vec<PathBuf>, FolderError> {
        let entries = std::fs::read_dir(folder).map_err(|e| error(folder, e))?;
        entries.map(|e| e.map(|e| e.path()).map_err(|e| error(folder, e))).collect()
    };
    let mut found = Vec::new();
    for path in list(folder)? {
        if path.is_dir() {
            found.extend(list(&path)?);
        } else {
            found.push(path);
        }
    }
    found.retain(|path| path.extension().is_some_and(|e| e == "h5"));
    found.sort();
    Ok(found)
}

/// The examples of a file.
pub fn read(path: &Path, run: &Run) -> Result<Vec<Example>, FolderError> {
    let wrong = |e: hdf5_pure::Error| error(path, e);
    let file = File::open(path).map_err(wrong)?;
    let has = file.root().datasets().map_err(wrong)?;
    let of = |name: &str| has.iter().any(|d| d == name).then(|| file.dataset(name)).transpose();
    let of = |name: &str| of(name).map_err(wrong);
    let Some(points) = of("pts")?.or(of("data")?) else {
        return Err(error(path, "has neither pts nor data: it is no point set of PartNet"));
    };
    let [shapes, count, 3] = shape(path, &points)?[..] else {
        return Err(error(path, "its points are not N × P × 3"));
    };
    let beside = path.with_extension("json");
    let records: Vec<Record> = if beside.exists() { json(&beside)? } else { Vec::new() };
    let (leaves, masks, kinds) = (of("label")?, of("gt_mask")?, of("label_seg")?);
    let category = category(path);
    let mut examples = Vec::new();
    for i in 0..shapes {
        run.cancel.check().map_err(|e| error(path, e))?;
        let row = points.read_f32_rows(i as u64, 1).map_err(wrong)?;
        let at = |p: &[f32]| DVec3::new(p[0].into(), p[1].into(), p[2].into());
        let positions: Vec<DVec3> = row.chunks_exact(3).map(at).collect();
        let record = records.get(i);
        let mut cloud = LabelledPoints { positions, ..Default::default() };
        if let Some(leaves) = &leaves {
            cloud.parts = numbers(path, leaves, i, count)?;
            cloud.names = cloud.parts.iter().map(|&leaf| name(record, leaf)).collect();
        } else if let Some(masks) = &masks {
            cloud.parts = masked(path, masks, i, count)?;
        } else if let Some(kinds) = &kinds {
            // 0 is what the level has no name for.
            let kind = |k: i32| if k == 0 { -1 } else { k };
            cloud.parts = numbers(path, kinds, i, count)?.into_iter().map(kind).collect();
            cloud = cloud.divided();
        } else {
            return Err(error(path, "has none of label, gt_mask and label_seg"));
        }
        cloud.names.resize(count, -1);
        let mut example = thinned(cloud).example(path, run)?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let number = record.map(|r| r.anno_id.to_string().replace('"', ""));
        let number = number.filter(|n| n != "null").unwrap_or_else(|| format!("{stem}_{i}"));
        example.id = format!("{category}_{number}");
        example.family = example.id.clone();
        example.category = category.clone();
        examples.push(example);
    }
    Ok(examples)
}

/// `Chair` of `…/Chair-3/train-00.h5`.
fn category(path: &Path) -> String {
    let folder = path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    let (name, level) = folder.rsplit_once('-').unwrap_or((&folder, ""));
    let is_level = !level.is_empty() && level.bytes().all(|b| b.is_ascii_digit());
    if is_level { name.to_owned() } else { folder.clone().into_owned() }
}

fn shape(path: &Path, of: &Dataset) -> Result<Vec<usize>, FolderError> {
    let shape = of.shape().map_err(|e| error(path, e))?;
    Ok(shape.into_iter().map(|n| n as usize).collect())
}

/// One number a point of shape `i`.
fn numbers(path: &Path, of: &Dataset, i: usize, count: usize) -> Result<Vec<i32>, FolderError> {
    let row = of.read_i32_rows(i as u64, 1).map_err(|e| error(path, e))?;
    if row.len() != count {
        return Err(error(path, format!("has {} labels for {count} points", row.len())));
    }
    Ok(row)
}

/// The mask that each point of shape `i` lies in; −1 in none.
fn masked(path: &Path, masks: &Dataset, i: usize, count: usize) -> Result<Vec<i32>, FolderError> {
    // Booleans are an enumeration of bytes.
    let bytes = masks.read_raw_rows(i as u64, 1).map_err(|e| error(path, e))?;
    match shape(path, masks)?[..] {
        [_, parts, points] if points == count && bytes.len() == parts * count => {}
        _ => return Err(error(path, "its gt_mask is not N × K × P booleans")),
    }
    let mut parts = vec![-1; count];
    for (k, mask) in (0..).zip(bytes.chunks_exact(count)) {
        parts.iter_mut().zip(mask).filter(|(_, m)| **m != 0).for_each(|(part, _)| *part = k);
    }
    Ok(parts)
}

/// The name of a leaf, or of the smallest part with a name that it belongs to.
fn name(record: Option<&Record>, leaf: i32) -> i32 {
    let leaf = i64::from(leaf);
    let of = record.into_iter().flat_map(|r| &r.ins_seg).filter(|s| s.leaf_id_list.contains(&leaf));
    let mut holding: Vec<&Instance> = of.collect();
    holding.sort_by_key(|s| s.leaf_id_list.len());
    holding.iter().find_map(|s| name_index(&s.part_name)).map_or(-1, |i| i as i32)
}

/// At most as many points as are looked at, evenly.
fn thinned(points: LabelledPoints) -> LabelledPoints {
    let total = points.positions.len();
    if total <= MOST {
        return points;
    }
    let pick = || (0..MOST).map(|i| i * total / MOST);
    LabelledPoints {
        positions: pick().map(|i| points.positions[i]).collect(),
        normals: Vec::new(),
        parts: pick().map(|i| points.parts[i]).collect(),
        names: pick().map(|i| points.names[i]).collect(),
    }
}
