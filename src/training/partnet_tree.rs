//! PartNet's hierarchies (Mo et al. 2019, doi:10.1109/CVPR.2019.00100): a folder for each annotation with
//! `result_after_merging.json`, a list of one root; nodes have `id`, `name`, `children`, and leaves `objs`,
//! the stems of files in `objs/`; beside it `meta.json` with `model_cat` and `model_id`. The leaves are the
//! parts. A leaf's name is looked up first, then those of its parents.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::folder::{FolderError, LabelledMesh, error};
use super::names::name_index;
use crate::contract::{Limits, MeshKind, Run, Winding};
use crate::mesh::{self, Primitive, Scene};

/// The file by which such a folder is known.
pub const TREE: &str = "result_after_merging.json";

/// What PartNet's terms allow, as far as it matters here.
pub const TERMS: &str = "PartNet/ShapeNet terms: non-commercial research and education only";

#[derive(Debug, Deserialize)]
struct Node {
    name: String,
    #[serde(default)]
    children: Vec<Node>,
    #[serde(default)]
    objs: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Meta {
    model_cat: String,
    model_id: String,
}

/// A leaf: its objects, and the index of its name.
struct Leaf {
    name: String,
    index: Option<usize>,
    objs: Vec<String>,
}

/// The annotations of a folder, in order of path: itself, or the folders in it.
pub fn annotations(folder: &Path) -> Result<Vec<PathBuf>, FolderError> {
    if folder.join(TREE).exists() {
        return Ok(vec![folder.to_path_buf()]);
    }
    let entries = std::fs::read_dir(folder).map_err(|e| error(folder, e))?;
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| error(folder, e))?.path();
        if path.join(TREE).exists() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Read one annotation.
pub fn read(folder: &Path, run: &Run) -> Result<LabelledMesh, FolderError> {
    let roots: Vec<Node> = json(&folder.join(TREE))?;
    let meta = folder.join("meta.json");
    let meta: Meta = if meta.exists() { json(&meta)? } else { Meta::default() };
    let mut leaves = Vec::new();
    for root in roots {
        collect(root, &mut Vec::new(), &mut leaves);
    }
    let (mut scene, mut parts, mut names) = (Scene::default(), Vec::new(), Vec::new());
    for (number, leaf) in (0..).zip(&leaves) {
        for obj in &leaf.objs {
            let path = folder.join("objs").join(format!("{obj}.obj"));
            let bytes = std::fs::read(&path).map_err(|e| error(&path, e))?;
            let read = mesh::import(&bytes, MeshKind::Obj, &Limits::default());
            for own in read.map_err(|e| error(&path, e))?.primitives {
                let faces = own.triangles.len();
                parts.extend(std::iter::repeat_n(number, faces));
                names.extend(std::iter::repeat_n(leaf.index.map_or(-1, |i| i as i32), faces));
                // Its number of a material is one of its own file.
                scene.add(&leaf.name, Primitive { material: None, ..own });
            }
        }
    }
    if scene.primitives.is_empty() {
        return Err(error(&folder.join(TREE), "no leaf of it has objects"));
    }
    let conditioned = mesh::condition(&scene, Winding::Surface, run);
    let surface = conditioned.map_err(|e| error(folder, e))?.surface;
    let (parts, names) = (surface.from_file_order(&parts), surface.from_file_order(&names));
    let id = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let family = if meta.model_id.is_empty() { id.clone() } else { meta.model_id };
    let source = "PartNet".to_owned();
    Ok(LabelledMesh { id, category: meta.model_cat, family, source, surface, parts, names })
}

fn collect(node: Node, above: &mut Vec<String>, leaves: &mut Vec<Leaf>) {
    above.push(node.name);
    if node.children.is_empty() {
        let index = above.iter().rev().find_map(|name| name_index(name));
        let name = above.last().cloned().unwrap_or_default();
        leaves.push(Leaf { name, index, objs: node.objs });
    }
    for child in node.children {
        collect(child, above, leaves);
    }
    above.pop();
}

pub(super) fn json<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T, FolderError> {
    let text = std::fs::read_to_string(path).map_err(|e| error(path, e))?;
    serde_json::from_str(&text).map_err(|e| error(path, e))
}
