//! One object of the quality benchmark: unwrapped with the given options, next to the peer; again at
//! the peer's own distortion, to see who needs fewer charts then; and again along given labels.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow};
use serde_json::{Map, Value, json};

use super::files::guarded;
use super::how::unwrap;
use super::{peer, table};
use crate::cli::input::Files;
use crate::contract::{
    ArtifactKind, Limits, Metrics, Quality, Run, SegmentationSource, Stage, UnwrapOptions,
};
use crate::mesh;
use crate::pipeline::Engine;

/// An isometry by this peer's arithmetic: single precision leaves so much.
const ROUNDING: f64 = 1e-5;

/// By how much the bound may exceed the peer's mean distortion.
const WIDENINGS: [f64; 4] = [1.0, 3.0, 9.0, 27.0];

/// What is done with each object.
pub struct Arms<'a> {
    /// The options of the object's own result.
    pub options: &'a UnwrapOptions,
    /// What computes.
    pub engine: &'a Engine,
    /// Only that result and the peer.
    pub single: bool,
    /// The independent measure's command line.
    pub judge: Option<&'a str>,
    /// A folder for what is not kept.
    pub folder: &'a Path,
    /// Where models are kept.
    pub models: Option<&'a Path>,
}

/// The object's line. Whatever goes wrong, panics included, is an `error` in it.
pub fn line(name: &str, path: &Path, arms: &Arms) -> Value {
    guarded(|| measure(name, path, arms))
        .unwrap_or_else(|error| json!({ "object": name, "error": format!("{error:#}") }))
}

fn measure(name: &str, path: &Path, arms: &Arms) -> Result<Value> {
    let labels = labels_beside(path);
    let files = Files::read(path, None)?;
    let unwrapped = unwrap(&files, arms.options, arms.engine)?;
    let input = files.input();
    let scene = mesh::import(input.mesh(), input.kind(), &Limits::default())?;
    let surface = mesh::condition(&scene, &Run::quiet())?;
    drop(scene);
    let mut line = Map::new();
    line.insert("object".into(), name.into());
    line.insert("triangles".into(), surface.face_count().into());
    line.insert("double_sided".into(), surface.repairs.double_sided_faces.into());
    line.insert("ours".into(), figures(&unwrapped.metrics));
    let peer = peer::measure(&surface);
    drop(surface);
    if !arms.single {
        line.insert("matched".into(), matched(&files, &unwrapped.metrics, &peer, arms)?);
        if let Some(labels) = labels {
            let files = Files::read(path, Some(&labels))?;
            let options = UnwrapOptions {
                segmentation: SegmentationSource::Labels,
                quality: Quality::Fast,
                ..arms.options.clone()
            };
            let along = unwrap(&files, &options, arms.engine)?;
            line.insert("along_labels".into(), figures(&along.metrics));
        }
    }
    line.insert("peer".into(), peer);
    let model = match arms.models {
        Some(models) => models.join(format!("{}.glb", name.replace(['/', '\\'], "_"))),
        None => arms.folder.join("model.glb"),
    };
    if arms.models.is_some() || arms.judge.is_some() {
        std::fs::write(&model, unwrapped.artifact(ArtifactKind::Model).unwrap_or_default())?;
        if let (Some(_), Some(picture)) = (arms.models, unwrapped.artifact(ArtifactKind::Preview)) {
            std::fs::write(model.with_extension("png"), picture)?;
        }
    }
    if let Some(judge) = arms.judge {
        line.insert("judge".into(), ask(judge, &model, path, arms.folder)?);
    }
    Ok(Value::Object(line))
}

/// The object at no more distortion than the peer has, untrained. The bound is one for each chart and the
/// peer's distortion a mean, so that the bound may be wider: it is widened while the mean stays below the
/// peer's, until the peer is beaten.
fn matched(files: &Files, ours: &Metrics, peer: &Value, arms: &Arms) -> Result<Value> {
    let Some(limit) = peer["symmetric_dirichlet"].as_f64() else { return Ok(Value::Null) };
    if ours.atlas.figures.symmetric_dirichlet.is_none_or(|e| e <= limit + ROUNDING) {
        return Ok(figures(ours));
    }
    let mut best = Value::Null;
    for widening in WIDENINGS {
        let options = UnwrapOptions {
            distortion_bound: widening * (limit - 1.0).max(ROUNDING),
            quality: Quality::Fast,
            ..arms.options.clone()
        };
        let found = figures(&unwrap(files, &options, arms.engine)?.metrics);
        let within = |e: f64| e <= limit + ROUNDING;
        if !best.is_null() && !found["symmetric_dirichlet"].as_f64().is_some_and(within) {
            break;
        }
        best = found;
        if table::dominates(&best, peer) {
            break;
        }
    }
    Ok(best)
}

/// The figures of a result that the table asks for.
fn figures(m: &Metrics) -> Value {
    let (f, c) = (&m.atlas.figures, &m.atlas.certificate);
    let preview = m.cost.stages.iter().find(|s| s.name == Stage::Preview.as_str());
    let preview = preview.map_or(0.0, |s| s.wall_s);
    let gains = m.charts.iter().filter_map(|c| c.neural_gain.and_then(|g| g.gain));
    json!({
        "valid": c.valid,
        "min_gutter_texels": c.min_gutter_texels,
        "parts": m.parts.len(),
        "charts": m.atlas.charts,
        "seam": f.seam_length.map(|s| s.per_sqrt_area),
        "symmetric_dirichlet": f.symmetric_dirichlet,
        "angular": f.quasi_conformal.map(|q| q.mean - 1.0),
        "area": f.area_distortion.map(|a| a.mean - 1.0),
        "packing": m.atlas.packing_efficiency.covered,
        "avoidable": f.avoidable_seam,
        "alignment": f.boundary_alignment,
        "developable": m.atlas.developable,
        "trained": m.charts.iter().filter(|c| c.steps > 0).count(),
        "gain": gains.reduce(f64::max),
        "degraded": m.degraded,
        "seconds": m.cost.wall_s - preview,
        "stages": m.cost.stages.iter().map(|s| (s.name.clone(), s.wall_s.into())).collect::<Map<_, _>>(),
        "peak_memory_mib": m.cost.peak_memory_mib,
    })
}

/// NAME.inst.txt or NAME.labels.txt.
fn labels_beside(path: &Path) -> Option<PathBuf> {
    ["inst.txt", "labels.txt"].map(|e| path.with_extension(e)).into_iter().find(|p| p.exists())
}

/// What the independent measure says.
fn ask(judge: &str, model: &Path, original: &Path, folder: &Path) -> Result<Value> {
    let mut words = judge.split_whitespace();
    let program = words.next().ok_or_else(|| anyhow!("--judge names no program"))?;
    let said = folder.join("judge.json");
    let output = Command::new(program)
        .args(words)
        .arg(model)
        .arg("--original")
        .arg(original)
        .arg("--json")
        .arg(&said)
        .output()
        .with_context(|| format!("cannot run {program}"))?;
    let text = std::fs::read(&said).map_err(|_| {
        anyhow!("the program of --judge wrote nothing: {}", String::from_utf8_lossy(&output.stderr))
    })?;
    Ok(serde_json::from_slice(&text)?)
}
