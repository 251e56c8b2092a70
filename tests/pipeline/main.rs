//! Whole jobs through the library, on the samples: valid output, the same bytes at any number of
//! threads, files that the glTF validator accepts.

mod benchmarks;
mod best;
mod budget;
mod certificate;
#[path = "../shared/glb.rs"]
mod glb;
mod large;
mod maps;
mod metrics;
mod options;
mod pages;
mod threads;

use std::path::{Path, PathBuf};
use std::process::Command;

use uvsegnet::contract::{
    ArtifactKind, DoubleSided, InputRole, Limits, MeshKind, Quality, Run, SegmentationSource,
    StopAfter, UnwrapOptions,
};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, InputFile, UnwrapError, Unwrapped, unwrap_input};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

fn kind_of(bytes: &[u8]) -> MeshKind {
    MeshKind::detect(bytes).unwrap()
}

fn unwrap(
    bytes: &[u8],
    labels: Option<&[u8]>,
    options: &UnwrapOptions,
) -> Result<Unwrapped, UnwrapError> {
    let labels = labels.map(|bytes| InputFile { role: InputRole::Labels, name: "", bytes });
    let input = Input::new(kind_of(bytes), bytes).with(labels);
    unwrap_input(&input, options, &Limits::default(), &Engine::new(Device::cpu()), &Run::quiet())
}

fn unwrap_example(name: &str, options: &UnwrapOptions) -> Unwrapped {
    unwrap(&std::fs::read(example(name)).unwrap(), None, options).unwrap()
}

/// Few steps: what is tested here does not depend on how far the training gets.
fn quick() -> UnwrapOptions {
    UnwrapOptions { steps: 20, ..Default::default() }
}

const SAMPLES: [&str; 7] = [
    "chair.glb",
    "chair_small.glb",
    "table.glb",
    "knife.glb",
    "laptop.glb",
    "skateboard.glb",
    "chair_fused.glb",
];

#[test]
fn every_sample_comes_out_valid() {
    for name in SAMPLES {
        let m = unwrap_example(name, &quick()).metrics;
        let c = &m.atlas.certificate;
        assert!(c.valid, "{name}: {c:?}");
        assert!(c.min_gutter_texels.is_none_or(|g| g >= 2.0), "{name}: {c:?}");
        assert!(m.charts.iter().all(|c| c.certificate.valid), "{name}");
        let energy = m.atlas.figures.symmetric_dirichlet.unwrap();
        assert!((1.0..1.01).contains(&energy), "{name}: {energy}");
        assert!(m.deterministic && m.degraded.is_empty(), "{name}");
        let faces: u64 = m.charts.iter().map(|c| c.faces).sum();
        assert_eq!(faces, m.parts.iter().map(|p| p.faces).sum::<u64>(), "{name}");
    }
}

#[test]
fn given_labels_are_kept() {
    let bytes = std::fs::read(example("chair_fused.glb")).unwrap();
    let labels = std::fs::read(example("chair_fused.labels.txt")).unwrap();
    let options = UnwrapOptions {
        segmentation: SegmentationSource::Labels,
        quality: Quality::Fast,
        ..quick()
    };
    let m = unwrap(&bytes, Some(&labels), &options).unwrap().metrics;
    assert!(m.atlas.certificate.valid);
    let given: std::collections::BTreeSet<&str> =
        std::str::from_utf8(&labels).unwrap().lines().collect();
    assert!(m.parts.len() >= given.len());
    assert!(m.parts.iter().all(|p| p.source == SegmentationSource::Labels));
    // Charts never cross a part: all of the boundary between parts is seam.
    let alignment = m.atlas.figures.boundary_alignment.unwrap();
    assert!((alignment.recall - 1.0).abs() < 1e-9, "{alignment:?}");
    let error = unwrap(&bytes, Some(b"0\n1\n"), &options).unwrap_err();
    assert!(error.to_string().contains('2'), "{error}");
}

#[test]
fn a_job_may_end_with_its_parts() {
    let options = UnwrapOptions { stop_after: Some(StopAfter::Segmentation), ..quick() };
    let result = unwrap_example("table.glb", &options);
    let labels = std::str::from_utf8(result.artifact(ArtifactKind::Labels).unwrap()).unwrap();
    let faces: u64 = result.metrics.parts.iter().map(|p| p.faces).sum();
    assert_eq!(labels.lines().count() as u64, faces);
    assert!(result.metrics.parts.len() > 3);
    // The model tells the parts, and given back, they are its labels.
    let model = result.artifact(ArtifactKind::Model).unwrap();
    let document = gltf::Gltf::from_slice(model).unwrap().document.into_json();
    let extras: serde_json::Value =
        serde_json::from_str(document.asset.extras.as_ref().unwrap().get()).unwrap();
    let told = extras["uvsegnet"]["parts"].as_array().unwrap();
    assert_eq!(told.len(), result.metrics.parts.len());
    assert_eq!(told[0]["name"], result.metrics.parts[0].name);
    let options = UnwrapOptions { segmentation: SegmentationSource::Labels, ..options };
    let again = unwrap(model, None, &options).unwrap();
    assert!(again.metrics.parts.iter().all(|p| p.source == SegmentationSource::Labels));
    assert_eq!(again.metrics.parts.len(), result.metrics.parts.len());
    assert_eq!(result.artifacts().len(), 4);
}

/// A cube whose every face stands twice, with both windings.
const DOUBLE_CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
    f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

#[test]
fn double_sided_faces_become_two_sheets_or_share_one() {
    let sheets = |double_sided| {
        let options = UnwrapOptions { double_sided, ..quick() };
        unwrap(DOUBLE_CUBE.as_bytes(), None, &options).unwrap().metrics
    };
    let (separate, share) = (sheets(DoubleSided::Separate), sheets(DoubleSided::Share));
    assert_eq!(separate.repairs.double_sided_faces, 24);
    assert!(separate.atlas.certificate.valid && share.atlas.certificate.valid);
    assert!(share.atlas.certificate.shared_sheets && !separate.atlas.certificate.shared_sheets);
    assert_eq!(separate.atlas.charts, 2 * share.atlas.charts);
}

#[test]
#[ignore = "needs the validator, which `tests/run validator` installs"]
fn the_validator_finds_no_error() {
    let modules = std::env::var_os("UVSEGNET_VALIDATOR").expect("where the validator is installed");
    let dir = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for name in SAMPLES {
        let path = dir.path().join(name);
        let result = unwrap_example(name, &UnwrapOptions { quality: Quality::Fast, ..quick() });
        std::fs::write(&path, result.artifact(ArtifactKind::Model).unwrap()).unwrap();
        files.push(path);
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validator/validate.cjs");
    let output = Command::new("node").arg(script).arg(modules).args(&files).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().count(), SAMPLES.len());
}
