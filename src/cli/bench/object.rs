//! One object of the quality benchmark: unwrapped with the given options, next to the peer; again at
//! the peer's own distortion, to see who needs fewer charts then; and again along given labels.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, anyhow};
use serde_json::Value;

use super::files::guarded;
use super::options::unwrap;
use super::peer;
use super::row::{Measured, PeerFigures, ROUNDING, ResultFigures, Row};
use crate::cli::input::{Beside, Files};
use crate::contract::{
    ArtifactKind, Limits, Metrics, Quality, Run, SegmentationSource, UnwrapOptions,
};
use crate::mesh::{self, Conditioned, Sides};
use crate::pipeline::Engine;

/// By how much the bound may exceed the peer's mean distortion.
const WIDENINGS: [f64; 4] = [1.0, 3.0, 9.0, 27.0];

/// What is done with each object.
pub struct Plan<'a> {
    /// The options of the object's own result.
    pub options: &'a UnwrapOptions,
    /// What computes.
    pub engine: &'a Engine,
    /// Only that result and the peer.
    pub single: bool,
    /// The independent measure's command line.
    pub independent: Option<&'a str>,
    /// A folder for what is not kept.
    pub folder: &'a Path,
    /// Where models are kept.
    pub models: Option<&'a Path>,
}

/// The object's line. Whatever goes wrong, panics included, is an `error` in it.
pub fn line(name: &str, path: &Path, plan: &Plan) -> Row {
    let object = name.to_owned();
    match guarded(|| measure(name, path, plan)) {
        Ok(measured) => Row { object, measured: Some(measured), error: None },
        Err(error) => Row { object, measured: None, error: Some(format!("{error:#}")) },
    }
}

fn measure(name: &str, path: &Path, plan: &Plan) -> Result<Measured> {
    let labels = labels_beside(path);
    let files = Files::read(path, &Beside::default())?;
    let unwrapped = unwrap(&files, plan.options, plan.engine)?;
    let input = files.input();
    let scene = mesh::import(input.mesh(), input.kind(), &Limits::default())?;
    let Conditioned { surface, telling } =
        mesh::condition(&scene, plan.options.winding, &Run::quiet())?;
    let surface = Sides::of(&surface, &telling, true, false).surface;
    drop(scene);
    let (triangles, double_sided) = (surface.face_count(), surface.repairs.double_sided_faces);
    let peer = peer::measure(&surface);
    drop(surface);
    let (mut at_peers, mut along_labels) = (None, None);
    if !plan.single {
        if let Some(peer) = &peer {
            at_peers = matched(&files, &unwrapped.metrics, peer, plan)?;
        }
        if let Some(labels) = labels {
            let files = Files::read(path, &Beside::labels(labels))?;
            let options = UnwrapOptions {
                segmentation: SegmentationSource::Labels,
                quality: Quality::Fast,
                ..plan.options.clone()
            };
            let along = unwrap(&files, &options, plan.engine)?;
            along_labels = Some(ResultFigures::of(&along.metrics));
        }
    }
    let model = match plan.models {
        Some(models) => models.join(format!("{}.glb", name.replace(['/', '\\'], "_"))),
        None => plan.folder.join("model.glb"),
    };
    if plan.models.is_some() || plan.independent.is_some() {
        std::fs::write(&model, unwrapped.artifact(ArtifactKind::Model).unwrap_or_default())?;
        if let (Some(_), Some(picture)) = (plan.models, unwrapped.artifact(ArtifactKind::Preview)) {
            std::fs::write(model.with_extension("png"), picture)?;
        }
    }
    let independent = plan
        .independent
        .map(|independent| ask(independent, &model, path, plan.folder))
        .transpose()?;
    Ok(Measured {
        triangles,
        double_sided,
        ours: ResultFigures::of(&unwrapped.metrics),
        matched: at_peers,
        along_labels,
        peer,
        independent,
    })
}

/// The object at no more distortion than the peer has, untrained. The bound is one for each chart and the
/// peer's distortion a mean, so that the bound may be wider: it is widened while the mean stays below the
/// peer's, until the peer is beaten.
fn matched(
    files: &Files,
    ours: &Metrics,
    peer: &PeerFigures,
    plan: &Plan,
) -> Result<Option<ResultFigures>> {
    let limit = peer.symmetric_dirichlet;
    let within = |e: Option<f64>| e.is_some_and(|e| e <= limit + ROUNDING);
    let ours = ResultFigures::of(ours);
    if ours.symmetric_dirichlet.is_none() || within(ours.symmetric_dirichlet) {
        return Ok(Some(ours));
    }
    let mut best: Option<ResultFigures> = None;
    for widening in WIDENINGS {
        let options = UnwrapOptions {
            distortion_bound: widening * (limit - 1.0).max(ROUNDING),
            quality: Quality::Fast,
            ..plan.options.clone()
        };
        let found = ResultFigures::of(&unwrap(files, &options, plan.engine)?.metrics);
        if best.is_some() && !within(found.symmetric_dirichlet) {
            break;
        }
        let enough = found.dominates(peer);
        best = Some(found);
        if enough {
            break;
        }
    }
    Ok(best)
}

/// NAME.inst.txt or NAME.labels.txt.
fn labels_beside(path: &Path) -> Option<PathBuf> {
    ["inst.txt", "labels.txt"].map(|e| path.with_extension(e)).into_iter().find(|p| p.exists())
}

/// What the independent measure says.
fn ask(independent: &str, model: &Path, original: &Path, folder: &Path) -> Result<Value> {
    let mut words = independent.split_whitespace();
    let program = words.next().ok_or_else(|| anyhow!("--independent names no program"))?;
    let said = folder.join("independent.json");
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
        anyhow!(
            "the program of --independent wrote nothing: {}",
            String::from_utf8_lossy(&output.stderr)
        )
    })?;
    Ok(serde_json::from_slice(&text)?)
}
