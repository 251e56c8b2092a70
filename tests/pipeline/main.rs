//! Whole jobs through the library, on the samples: valid output, the same bytes at any number of
//! threads, files that the glTF validator accepts.

mod benchmarks;
mod budget;
mod certificate;
mod options;

use std::path::{Path, PathBuf};
use std::process::Command;

use uvsegnet::contract::{
    ArtifactKind, ChartForm, DoubleSided, ErrorCode, InputRole, Limits, MeshKind, Quality,
    Rotation, Run, SegmentationSource, StopAfter, UnwrapOptions,
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
fn training_runs_on_doubly_curved_charts_and_says_what_it_gained() {
    let options = UnwrapOptions { quality: Quality::Best, ..quick() };
    let m = unwrap_example("chair_small.glb", &options).metrics;
    let trained: Vec<_> = m.charts.iter().filter(|c| c.steps > 0).collect();
    assert!(trained.len() >= 4, "{} charts trained", trained.len());
    for chart in trained {
        let gain = chart.neural_gain.as_ref().unwrap();
        let (start, control) = (gain.start.unwrap(), gain.start_polish.unwrap());
        assert!(control <= start + 1e-9 && gain.net.unwrap() >= 1.0, "{gain:?}");
        let shipped_net = chart.form == ChartForm::Trained;
        assert!(!shipped_net || gain.gain.unwrap() > 0.0, "{gain:?}");
    }
    assert!(m.charts.iter().filter(|c| c.isometric_start).all(|c| c.steps == 0));
}

#[test]
fn the_best_quality_trains_the_seams_and_never_loses_by_it() {
    let options = UnwrapOptions { quality: Quality::Best, steps: 20, points: 64, ..quick() };
    let metrics = unwrap_example("chair_small.glb", &options).metrics;
    let joint = metrics.atlas.joint_seams.unwrap();
    assert!(joint.pieces > 0 && joint.kept <= joint.pieces, "{joint:?}");
    assert!(joint.gain.is_some_and(|gain| gain >= 0.0), "{joint:?}");
    assert!(metrics.atlas.certificate.valid);
    assert_eq!(unwrap_example("chair_small.glb", &quick()).metrics.atlas.joint_seams, None);
}

#[test]
fn quality_fast_trains_nothing() {
    let m =
        unwrap_example("table.glb", &UnwrapOptions { quality: Quality::Fast, ..quick() }).metrics;
    assert!(m.atlas.certificate.valid);
    assert!(m.charts.iter().all(|c| c.steps == 0 && c.neural_gain.is_none()));
}

#[test]
fn the_same_bytes_at_one_and_two_threads() {
    let at = |threads: usize, name: &str| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| unwrap_example(name, &quick()))
    };
    for name in ["chair_small.glb", "chair_fused.glb"] {
        let differences = at(1, name).differences(&at(2, name));
        assert!(differences.is_empty(), "{name}: {differences:?} differ");
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

/// UDIM tiles that each triangle of a GLB's first texture coordinates lies in, v up.
fn tiles(glb: &[u8]) -> Vec<[u32; 3]> {
    let file = gltf::Gltf::from_slice(glb).unwrap();
    let mut tiles = Vec::new();
    for primitive in file.meshes().flat_map(|m| m.primitives()) {
        let reader = primitive.reader(|_| file.blob.as_deref());
        let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        let tile = |corner: u32| {
            let [u, v] = uvs[corner as usize];
            1001 + u.floor() as u32 + 10 * (1.0 - v).floor() as u32
        };
        tiles.extend(corners.chunks_exact(3).map(|t| [tile(t[0]), tile(t[1]), tile(t[2])]));
    }
    tiles
}

#[test]
fn pages_go_to_tiles_of_their_own_or_share_one() {
    // Twelve squares: each fills a page of its own.
    let square = |k: u32| {
        let (x, i) = (2 * k, 4 * k);
        let corners = [(x, 0), (x + 1, 0), (x + 1, 1), (x, 1)].map(|(x, y)| format!("v {x} {y} 0"));
        format!("{}\nf {} {} {} {}\n", corners.join("\n"), i + 1, i + 2, i + 3, i + 4)
    };
    let squares: String = (0..12).map(square).collect();
    let on = |pages, udim| {
        let options = UnwrapOptions { pages, udim, quality: Quality::Fast, ..quick() };
        unwrap(squares.as_bytes(), None, &options).unwrap()
    };
    let (one, many, apart) = (on(1, false), on(12, false), on(12, true));
    let density = |result: &Unwrapped| result.metrics.atlas.figures.texel_density.unwrap().mean;
    assert!(density(&many) > 3.0 * density(&one));
    for (result, udim) in [(&many, false), (&apart, true)] {
        let m = &result.metrics;
        assert!(m.atlas.certificate.valid);
        assert_eq!((m.atlas.pages, m.atlas.udim), (12, udim));
        let pages: std::collections::BTreeSet<u32> = m.charts.iter().map(|c| c.page).collect();
        assert_eq!(pages, (0..12).collect());
        let tiles = tiles(result.artifact(ArtifactKind::Model).unwrap());
        assert!(tiles.iter().all(|t| t.iter().all(|&tile| tile == t[0])), "no triangle is torn");
        let tiles: std::collections::BTreeSet<u32> = tiles.iter().map(|t| t[0]).collect();
        assert_eq!(tiles, if udim { (1001..1013).collect() } else { [1001].into() });
        let layout = std::str::from_utf8(result.artifact(ArtifactKind::Layout).unwrap()).unwrap();
        assert_eq!(layout.matches("<rect").count(), 12);
    }
}

#[test]
fn parts_get_the_density_that_was_asked_for() {
    let with = |density: &str| {
        let density = Some(density.to_owned());
        let options = UnwrapOptions { density, quality: Quality::Fast, ..quick() };
        let bytes = std::fs::read(example("table.glb")).unwrap();
        unwrap(&bytes, None, &options)
    };
    let even = with("").unwrap().metrics;
    let name = even.parts[1].name.clone();
    assert_eq!(even.parts.iter().filter(|p| p.name == name).count(), 1);
    let m = with(&format!("0=2,{name}=0.5")).unwrap().metrics;
    assert!(m.atlas.certificate.valid);
    let density = |part: usize| m.parts[part].figures.texel_density.unwrap().mean;
    assert!((density(0) / density(2) - 2.0).abs() < 0.03, "{}", density(0) / density(2));
    assert!((density(1) / density(2) - 0.5).abs() < 0.01, "{}", density(1) / density(2));
    let error = with("lamp=2").unwrap_err();
    assert_eq!(error.job_error().unwrap().code, ErrorCode::InvalidOption);
    let said = error.to_string();
    assert!(said.contains("lamp") && said.contains(&name) && said.contains("/density"), "{said}");
}

#[test]
fn charts_keep_to_blocks_and_to_their_turns_when_asked() {
    let options = UnwrapOptions {
        block_align: true,
        rotation: Rotation::None,
        quality: Quality::Fast,
        ..quick()
    };
    for name in ["table.glb", "chair_small.glb"] {
        assert!(unwrap_example(name, &options).metrics.atlas.certificate.valid, "{name}");
    }
}

#[test]
fn the_validator_finds_no_error() {
    let Some(modules) = std::env::var_os("UVSEGNET_VALIDATOR") else {
        assert!(
            std::env::var_os("CI").is_none(),
            "tests/run installs the validator and says where"
        );
        eprintln!("skipped: UVSEGNET_VALIDATOR is not set (tests/run installs the validator)");
        return;
    };
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
