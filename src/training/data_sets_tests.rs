//! What reading a data set promises, on tiny sets in the real formats (tests/fixtures/make.py): a stool of
//! a seat and four legs.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::*;
use crate::contract::Run;
use crate::segmentation::point_mae::NAMES;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

fn load(name: &str) -> Vec<Example> {
    load_examples(&fixture(name), &[], 1, &Run::quiet()).unwrap().0
}

/// Parts of an example that have points.
fn parts(example: &Example) -> usize {
    example.part.iter().filter(|p| **p >= 0).collect::<BTreeSet<_>>().len()
}

/// Whether points high up are one part, and all its legs others.
fn assert_stool(example: &Example) {
    assert_eq!(parts(example), 5, "{}", example.id);
    let high = example.cloud.positions.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
    let top: BTreeSet<i32> = (example.cloud.positions.iter().zip(&example.part))
        .filter(|(p, part)| p[1] > high - 0.02 && **part >= 0)
        .map(|(_, part)| *part)
        .collect();
    assert_eq!(top.len(), 1, "{}: the seat is one part", example.id);
    let unit = |n: &[f32; 3]| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3;
    assert!(example.cloud.normals.iter().all(unit), "{}", example.id);
}

fn names(example: &Example) -> BTreeSet<&'static str> {
    example.name.iter().filter(|n| **n >= 0).map(|n| NAMES[*n as usize]).collect()
}

#[test]
fn a_kind_of_part_at_several_places_is_several_parts() {
    let examples = load("shapenet_part");
    assert_eq!((examples.len(), examples[0].category.as_str()), (1, "Chair"));
    examples.iter().for_each(assert_stool);
}

#[test]
fn partnet_hierarchies_are_meshes_of_their_leaves() {
    let examples = load("partnet_tree");
    assert_eq!((examples.len(), examples[0].family.as_str()), (1, "stool-a"));
    assert_stool(&examples[0]);
    assert_eq!(names(&examples[0]), BTreeSet::from(["leg", "seat"]), "seat is its parent's name");
    let (meshes, _) = load_meshes(&fixture("partnet_tree"), &[], |_| false, &Run::quiet()).unwrap();
    assert_eq!(meshes[0].surface.face_count(), 60);
    let (spared, _) = load_meshes(&fixture("partnet_tree"), &[], |_| true, &Run::quiet()).unwrap();
    assert!(spared.is_empty());
}

#[test]
fn bound_sets_are_left_out_unless_they_are_asked_for() {
    let free = ["MIT".to_owned(), "CC-BY-4.0".to_owned()];
    for name in ["partnet_tree", "shapenet_part"] {
        let (examples, left_out) = load_examples(&fixture(name), &free, 1, &Run::quiet()).unwrap();
        assert_eq!((examples.len(), left_out), (0, 1), "{name}");
    }
    let bound = ["PartNet/ShapeNet terms".to_owned()];
    let (examples, _) = load_examples(&fixture("shapenet_part"), &bound, 1, &Run::quiet()).unwrap();
    assert_eq!(examples.len(), 1);
}

#[test]
fn broken_files_are_named_with_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let fail = || load_examples(folder.path(), &[], 1, &Run::quiet()).unwrap_err().to_string();
    let own = folder.path().join("7");
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("result_after_merging.json"), r#"[{"name":"chair","objs":["x"]}]"#)
        .unwrap();
    let error = fail();
    assert!(error.contains("x.obj"), "{error}");
    std::fs::remove_dir_all(own).unwrap();
    std::fs::write(folder.path().join("synsetoffset2category.txt"), "Chair 03\n").unwrap();
    std::fs::create_dir(folder.path().join("03")).unwrap();
    std::fs::write(folder.path().join("03/a.txt"), "0 0 0 0 0 1 3\n0 0 zero\n").unwrap();
    let error = fail();
    assert!(error.contains("a.txt") && error.contains("line 2"), "{error}");
    std::fs::write(folder.path().join("03/a.txt"), "\n").unwrap();
    assert!(fail().contains("no points"));
    let meshes = load_meshes(folder.path(), &[], |_| false, &Run::quiet()).unwrap_err();
    assert!(meshes.to_string().contains("no surfaces"), "{meshes}");
}
