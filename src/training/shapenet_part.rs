//! ShapeNet-part with normals (Yi et al. 2016, doi:10.1145/2980179.2980238): `synsetoffset2category.txt`
//! with lines of a category and its folder, and in each folder `ID.txt` with a line
//! `x y z nx ny nz label` a point. A label is a kind of part over all the set, so its pieces are the
//! parts; what a kind is called, the set does not say.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::example::Example;
use super::folder::{FolderError, error};
use super::points::LabelledPoints;
use crate::contract::Run;

/// The file by which the set is known.
pub const CATEGORIES: &str = "synsetoffset2category.txt";

/// The files of the set, each with its category, in order of path.
pub fn files(folder: &Path) -> Result<Vec<(String, PathBuf)>, FolderError> {
    let list = folder.join(CATEGORIES);
    let text = std::fs::read_to_string(&list).map_err(|e| error(&list, e))?;
    let mut found = Vec::new();
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        let mut words = line.split_whitespace();
        let (Some(category), Some(offset)) = (words.next(), words.next()) else {
            return Err(error(&list, format!("\"{line}\" is not a category and its folder")));
        };
        let own = folder.join(offset);
        // A part of the set is a set too.
        if !own.is_dir() {
            continue;
        }
        for entry in std::fs::read_dir(&own).map_err(|e| error(&own, e))? {
            let path = entry.map_err(|e| error(&own, e))?.path();
            if path.extension().is_some_and(|e| e == "txt") {
                found.push((category.to_owned(), path));
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Read one object.
pub fn read(category: &str, path: &Path, run: &Run) -> Result<Example, FolderError> {
    let text = std::fs::read_to_string(path).map_err(|e| error(path, e))?;
    let mut points = LabelledPoints::default();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(|w| w.parse().ok()).collect();
        let numbers = numbers.filter(|n| n.len() == 7 && n.iter().all(|x| x.is_finite()));
        let Some(n) = numbers else {
            let reason = format!("line {}: expected x y z nx ny nz label", number + 1);
            return Err(error(path, reason));
        };
        points.positions.push(DVec3::new(n[0], n[1], n[2]));
        points.normals.push(DVec3::new(n[3], n[4], n[5]).normalize_or_zero());
        points.parts.push(n[6] as i32);
    }
    points.names = vec![-1; points.parts.len()];
    let mut example = points.divided().example(path, run)?;
    example.id = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    example.family = example.id.clone();
    example.category = category.to_owned();
    Ok(example)
}
