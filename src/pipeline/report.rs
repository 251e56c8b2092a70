//! The last stages: measure, draw, write, and the metrics that say what was done.

use super::clock::Clock;
use super::error::UnwrapError;
use super::extras;
use super::faces::{self, Faces};
use super::finish::Finished;
use super::maps::Mapped;
use super::parts::Found;
use super::result::{Artifact, Unwrapped};
use crate::contract::{
    AtlasMetrics, Certificate, ChartMetrics, Figures, Metrics, PartMetrics, Run, Stage, Units,
    UnwrapOptions,
};
use crate::device::Device;
use crate::mesh::{NONE, Scene, export};
use crate::metrics::{self, Measured, MeasuredFigures};
use crate::preview;
use crate::segmentation::Part;

/// Version of the shape of `metrics.json`.
const SCHEMA: u32 = 1;

/// The result of a whole job.
pub fn whole(
    scene: &Scene,
    found: &Found,
    finished: &Finished,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
    mut clock: Clock,
) -> Result<Unwrapped, UnwrapError> {
    clock.stage(Stage::Measure, run)?;
    let faces = faces::collect(found, finished);
    let chamfer: Vec<Option<f64>> = finished.charts.iter().map(|c| c.chamfer).collect();
    let measured = Measured {
        boundary_labels: found.surface.labels.as_deref(),
        chamfer: &chamfer,
        page_size: options.page_size,
        pages: finished.pages,
        page_of: &finished.page_of,
        ..measured(found, &faces, finished.charts.len())
    };
    let figures = metrics::measure(&measured, run)?;
    let owned = finished.certificates.delivered
        * f64::from(options.page_size).powi(2)
        * f64::from(finished.pages);
    let packing_efficiency = metrics::packing_efficiency(&measured, owned.round() as u64);
    clock.stage(Stage::Preview, run)?;
    let names: Vec<String> = found.parts.parts.iter().map(|p| p.name.clone()).collect();
    let layout = preview::uv_layout_svg(&measured, &names, &run.cancel)?;
    let picture = preview::preview_png(&measured, run)?;
    clock.stage(Stage::Export, run)?;
    let extras = extras::block(found, &faces.chart_of);
    let glb = export::glb(scene, &faces.file, options.uv_channel, Some(&extras))?;
    let steps = finished.charts.iter().map(|c| c.steps).max().unwrap_or(0);
    let metrics = Metrics {
        atlas: AtlasMetrics {
            pages: finished.pages,
            udim: options.udim,
            width: options.page_size,
            height: options.page_size,
            charts: finished.charts.len() as u32,
            certificate: finished.certificates.atlas.clone(),
            packing_efficiency,
            developable: metrics::developable(&measured),
            joint_seams: finished.joint_seams,
            figures: figures.atlas.clone(),
        },
        parts: parts(found, finished, &figures),
        charts: charts(found, finished, &figures),
        ..empty(found, device, run, &mut clock, steps)
    };
    let artifacts = vec![
        artifact("model.glb", "model/gltf-binary", glb),
        json(&metrics)?,
        artifact("uv_layout.svg", "image/svg+xml", layout.into_bytes()),
        artifact("preview.png", "image/png", picture),
    ];
    Ok(Unwrapped { metrics, artifacts })
}

/// The result of a job that ends with its parts: the model with a part a face, the same as text, and a
/// picture of the parts.
pub fn segmentation_only(
    scene: &Scene,
    found: &Found,
    device: &Device,
    run: &Run,
    mut clock: Clock,
) -> Result<Unwrapped, UnwrapError> {
    clock.stage(Stage::Preview, run)?;
    let count = found.surface.face_count();
    let uvs = vec![[[f32::NAN; 2]; 3]; count];
    let faces = Faces { file: Vec::new(), uvs, chart_of: vec![NONE; count] };
    let picture = preview::preview_png(&measured(found, &faces, 0), run)?;
    clock.stage(Stage::Export, run)?;
    let mut metrics = empty(found, device, run, &mut clock, 0);
    let counts = face_counts(found);
    let part = |p: &Part| PartMetrics {
        id: p.id,
        name: p.name.clone(),
        source: p.source.to_string(),
        confidence: p.confidence,
        faces: counts[p.id as usize],
        ..Default::default()
    };
    metrics.parts = found.parts.parts.iter().map(part).collect();
    let parts = found.parts.labels.iter().map(|&p| if p == NONE { -1 } else { p as i32 });
    let parts: Vec<i32> = parts.collect();
    let glb = export::part_glb(scene, &parts, Some(&extras::block(found, &[])))?;
    let artifacts = vec![
        artifact("model.glb", "model/gltf-binary", glb),
        artifact("labels.txt", "text/plain", found.parts.to_text().into_bytes()),
        json(&metrics)?,
        artifact("preview.png", "image/png", picture),
    ];
    Ok(Unwrapped { metrics, artifacts })
}

/// The view that figures and pictures are taken of.
fn measured<'a>(found: &'a Found, faces: &'a Faces, charts: usize) -> Measured<'a> {
    Measured {
        surface: &found.surface,
        uvs: &faces.uvs,
        chart_of: &faces.chart_of,
        part_of: &found.parts.labels,
        charts,
        parts: found.parts.parts.len(),
        boundary_labels: None,
        page_size: 0,
        pages: 0,
        page_of: &[],
        chamfer: &[],
    }
}

/// Metrics without charts.
fn empty(found: &Found, device: &Device, run: &Run, clock: &mut Clock, steps: u32) -> Metrics {
    let degraded = run.budget.degraded();
    let sentence =
        |stage: &Stage| format!("{}: the clock ran out, a cheaper form was taken", stage.as_str());
    Metrics {
        schema: SCHEMA,
        deterministic: degraded.is_empty(),
        degraded: degraded.iter().map(sentence).collect(),
        units: Units { length: "world".into() },
        atlas: AtlasMetrics::default(),
        parts: Vec::new(),
        part_joins: found.parts.joins.clone(),
        charts: Vec::new(),
        repairs: found.surface.repairs,
        engine: env!("CARGO_PKG_VERSION").into(),
        device: device.name(),
        cost: clock.cost(steps, &device.name()),
    }
}

/// Faces of each part.
fn face_counts(found: &Found) -> Vec<u64> {
    let mut faces = vec![0; found.parts.parts.len()];
    for &part in found.parts.labels.iter().filter(|p| **p != NONE) {
        faces[part as usize] += 1;
    }
    faces
}

fn parts(found: &Found, finished: &Finished, figures: &MeasuredFigures) -> Vec<PartMetrics> {
    let faces = face_counts(found);
    let charts_of = |part: u32| {
        let charts = finished.charts.iter().enumerate();
        let own = |(_, m): &(usize, &Mapped)| found.part_of_region[m.chart.part as usize] == part;
        charts.filter(own).map(|(i, _)| i as u32).collect()
    };
    let part = |(p, figures): (&Part, &Figures)| PartMetrics {
        id: p.id,
        name: p.name.clone(),
        source: p.source.to_string(),
        confidence: p.confidence,
        faces: faces[p.id as usize],
        charts: charts_of(p.id),
        figures: figures.clone(),
    };
    found.parts.parts.iter().zip(&figures.parts).map(part).collect()
}

fn charts(found: &Found, finished: &Finished, figures: &MeasuredFigures) -> Vec<ChartMetrics> {
    let rows = finished.charts.iter().zip(&figures.charts).zip(&finished.certificates.charts);
    let chart =
        |(id, ((m, figures), proof)): (usize, ((&Mapped, &Figures), &Certificate))| ChartMetrics {
            id: id as u32,
            part: found.part_of_region[m.chart.part as usize],
            page: finished.page_of[id],
            faces: m.chart.faces.len() as u64,
            shape: m.chart.shape.as_str().into(),
            start: m.chart.start_kind.as_str().into(),
            form: m.form,
            isometric_start: m.isometric_start,
            steps: m.steps,
            neural_gain: m.gain,
            certificate: proof.clone(),
            figures: figures.clone(),
        };
    rows.enumerate().map(chart).collect()
}

fn artifact(name: &'static str, media_type: &'static str, bytes: Vec<u8>) -> Artifact {
    Artifact { name, media_type, bytes }
}

fn json(metrics: &Metrics) -> Result<Artifact, UnwrapError> {
    let bytes = serde_json::to_vec_pretty(metrics)
        .map_err(|error| UnwrapError::Internal(format!("metrics cannot be written: {error}")))?;
    Ok(artifact("metrics.json", "application/json", bytes))
}
