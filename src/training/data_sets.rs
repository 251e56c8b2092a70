//! The data sets that can be learned from, told by what lies in a folder: our own labelled folders
//! (`folder`), PartNet's hierarchies (`partnet_tree`), ShapeNet-part (`shapenet_part`). What may be learned from depends on the licences that are asked for.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::example::{Example, Labels};
use super::folder::{self, FolderError, LabelledMesh};
use super::{partnet_tree, shapenet_part};
use crate::contract::Run;

/// What a folder holds.
#[derive(Debug, Clone, PartialEq, Eq)]
enum DataSet {
    Labelled(Vec<PathBuf>),
    PartNetTrees(Vec<PathBuf>),
    ShapeNetPart(Vec<(String, PathBuf)>),
}

impl DataSet {
    fn of(folder: &Path) -> Result<Self, FolderError> {
        if folder.join(shapenet_part::CATEGORIES).exists() {
            return shapenet_part::files(folder).map(Self::ShapeNetPart);
        }
        let trees = partnet_tree::annotations(folder)?;
        if !trees.is_empty() {
            return Ok(Self::PartNetTrees(trees));
        }
        folder::meshes(folder).map(Self::Labelled)
    }

    fn len(&self) -> usize {
        match self {
            Self::Labelled(files) | Self::PartNetTrees(files) => files.len(),
            Self::ShapeNetPart(files) => files.len(),
        }
    }

    /// Leave out what `licences` do not allow; returns how much that was. Without licences all is allowed.
    fn keep(&mut self, licences: &[String]) -> Result<usize, FolderError> {
        let before = self.len();
        if licences.is_empty() {
            return Ok(0);
        }
        match self {
            Self::Labelled(files) => {
                let allowed: Result<Vec<bool>, FolderError> =
                    files.iter().map(|f| folder::is_allowed(f, licences)).collect();
                let mut allowed = allowed?.into_iter();
                files.retain(|_| allowed.next().unwrap_or(false));
            }
            _ if licences.iter().any(|l| partnet_tree::TERMS.starts_with(l.as_str())) => {}
            Self::PartNetTrees(files) => files.clear(),
            Self::ShapeNetPart(files) => files.clear(),
        }
        Ok(before - self.len())
    }
}

/// The examples of a folder that may be used under `licences` (all, if there are none), and how many
/// files were left out.
pub fn load_examples(
    folder: &Path,
    licences: &[String],
    seed: u64,
    run: &Run,
) -> Result<(Vec<Example>, usize), FolderError> {
    let mut set = DataSet::of(folder)?;
    let left_out = set.keep(licences)?;
    let of_mesh = |mesh: LabelledMesh| {
        let labels = Labels { parts: &mesh.parts, names: &mesh.names };
        let example = Example::of_surface(&mesh.surface, &labels, seed, run);
        let mut example = example.map_err(|e| folder::error(Path::new(&mesh.id), e))?;
        (example.id, example.family, example.category) = (mesh.id, mesh.family, mesh.category);
        Ok(example)
    };
    let examples: Result<Vec<Example>, FolderError> = match &set {
        DataSet::Labelled(files) => {
            files.par_iter().map(|f| folder::read(f, run).and_then(of_mesh)).collect()
        }
        DataSet::PartNetTrees(files) => {
            files.par_iter().map(|f| partnet_tree::read(f, run).and_then(of_mesh)).collect()
        }
        DataSet::ShapeNetPart(files) => {
            files.par_iter().map(|(c, f)| shapenet_part::read(c, f, run)).collect()
        }
    };
    Ok((examples?, left_out))
}

/// The meshes of a folder that may be used under `licences`, without the families that `spare` tells,
/// and how many files were left out. Sets of points have none.
pub fn load_meshes(
    folder: &Path,
    licences: &[String],
    spare: impl Fn(&str) -> bool + Sync,
    run: &Run,
) -> Result<(Vec<LabelledMesh>, usize), FolderError> {
    let mut set = DataSet::of(folder)?;
    let left_out = set.keep(licences)?;
    let meshes: Result<Vec<LabelledMesh>, FolderError> = match &set {
        DataSet::Labelled(files) => files.par_iter().map(|f| folder::read(f, run)).collect(),
        DataSet::PartNetTrees(files) => {
            files.par_iter().map(|f| partnet_tree::read(f, run)).collect()
        }
        DataSet::ShapeNetPart(_) => Err(folder::error(
            folder,
            "has points and no surfaces: the boundary classifier learns from meshes",
        )),
    };
    let mut meshes = meshes?;
    meshes.retain(|mesh| !spare(&mesh.family));
    Ok((meshes, left_out))
}
