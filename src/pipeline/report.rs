//! The last stages: measure, draw, write, and the metrics that say what was done.

use super::caps;
use super::choice;
use super::engine::Engine;
use super::error::Cause;
use super::extras;
use super::faces::{self, Faces};
use super::finish::CertifiedAtlas;
use super::instances::Instances;
use super::json;
use super::maps::Mapped;
use super::membership::Membership;
use super::parts::Found;
use super::pictures;
use super::result::{Artifact, Unwrapped};
use super::summary;
use crate::contract::{
    ArtifactKind, AtlasMetrics, Certificate, ChartMetrics, Figures, FirstFaces, JointSeams,
    Metrics, PartMetrics, Repairs, Run, Scarce, SegmentationSource, Stage, Summary, Units,
    UnwrapOptions,
};
use crate::mesh::{NONE, Scene, export};
use crate::metrics::{self, Measured, MeasuredFigures};
use crate::preview;
use crate::segmentation::{Part, PartLabels};
use crate::tasks;

/// Version of the shape of `metrics.json`.
const SCHEMA: u32 = 2;

/// The result of a whole job.
pub fn whole(
    scene: &Scene,
    found: &Found,
    finished: &CertifiedAtlas,
    joint_seams: Option<JointSeams>,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, Cause> {
    run.stage(Stage::Measure)?;
    let faces = tasks::link("collect", || faces::collect(found, finished));
    let chamfer: Vec<Option<f64>> = finished.charts.iter().map(|c| c.chamfer).collect();
    let measured = Measured {
        boundary_labels: found.surface.labels.as_deref(),
        chamfer: &chamfer,
        page_size: options.page_size,
        pages: finished.pages,
        page_of: &finished.page_of,
        ..measured(found, &faces, finished.charts.len())
    };
    let authored = |p: u32| found.parts.parts[p as usize].source == SegmentationSource::Authored;
    let shapes = || {
        let jaggedness = || tasks::link("jaggedness", || metrics::seam_jaggedness(&measured));
        let small = || metrics::small_charts(&measured, authored, options.atlas);
        tasks::join("shapes", jaggedness, || tasks::link("small charts", small))
    };
    let (figures, (jaggedness, small)) =
        tasks::join("measures", || metrics::measure(&measured, run), shapes);
    let figures = figures?;
    run.count(found.surface.face_count());
    let owned = finished.certificates.delivered
        * f64::from(options.page_size).powi(2)
        * f64::from(finished.pages);
    let packing_efficiency = metrics::packing_efficiency(&measured, owned.round() as u64);
    let instances = Instances::of(scene, found);
    let instance_metrics = match &instances {
        Some(instances) => Some(instances.metrics(&measured, run)?),
        None => None,
    };
    let write = || -> Result<Vec<u8>, Cause> {
        let extras = tasks::link("extras", || json::value(&extras::block(found, &faces.chart_of)))?;
        let file = || export::glb(scene, &faces.file, options.uv_channel, Some(&extras));
        Ok(tasks::link("glb", file)?)
    };
    let shown = instances.as_ref();
    let (pictures, glb) = if pictures::draws(found, shown, finished.pages, options, run) {
        // The file is written while they are drawn.
        run.stage(Stage::Preview)?;
        let draw = || pictures::of_atlas(&measured, found, shown, run);
        let (pictures, glb) = tasks::join("results", draw, write);
        run.stage(Stage::Export)?;
        (Some(pictures?), glb?)
    } else {
        run.stage(Stage::Export)?;
        (None, write()?)
    };
    run.count(glb.len());
    let steps = finished.charts.iter().map(|c| c.steps).max().unwrap_or(0);
    let enlarged_faces = finished.charts.iter().filter(|c| c.enlarged).count() as u64;
    let atlas = AtlasMetrics {
        pages: finished.pages,
        udim: options.udim,
        width: options.page_size,
        height: options.page_size,
        charts: finished.charts.len() as u32,
        edge_charts: caps::edge_charts(&found.surface, &finished.charts) as u32,
        certificate: finished.certificates.atlas.clone(),
        packing_efficiency,
        developable: metrics::developable(&measured),
        seam_jaggedness: jaggedness.map(|j| j.near),
        seam_jaggedness_15: jaggedness.map(|j| j.wide),
        small_charts: small.avoidable,
        small_charts_exempt: small.exempt,
        coarse_to_fine: found.dense.metrics(&found.surface, &finished.charts),
        objective: choice::objective(&found.surface, finished, options),
        joint_seams,
        instances: instance_metrics,
        figures: figures.atlas.clone(),
    };
    summary::warn_of_many_charts(finished, found, run);
    let membership = Membership::new(found, &finished.charts);
    let cost = run.cost(steps, &engine.device.name(), tasks::threads());
    let metrics = Metrics {
        schema: SCHEMA,
        summary: Summary {
            seconds: cost.wall_s,
            ..summary::of_atlas(&atlas, found, finished, options, run)
        },
        deterministic: is_deterministic(run),
        degraded: degraded(run),
        units: Units::default(),
        atlas,
        parts: parts(found, &membership, &figures),
        part_joins: found.parts.joins.clone(),
        charts: charts(&membership, finished, &figures),
        repairs: Repairs { enlarged_faces, ..repairs(found) },
        engine: env!("CARGO_PKG_VERSION").into(),
        weights: found.weights.clone(),
        device: engine.device.name(),
        cost,
    };
    let mut artifacts = vec![
        Artifact { kind: ArtifactKind::Model, bytes: glb },
        Artifact { kind: ArtifactKind::Metrics, bytes: json::file(&metrics)? },
    ];
    if let Some((layout, picture)) = pictures {
        artifacts.push(Artifact { kind: ArtifactKind::Layout, bytes: layout });
        artifacts.push(Artifact { kind: ArtifactKind::Preview, bytes: picture });
    }
    run.advance(1.0);
    Ok(Unwrapped { metrics, artifacts })
}

/// The result of a job that ends with its parts: the model with a part a face, the same as text, and a
/// picture of the parts.
pub fn segmentation_only(
    scene: &Scene,
    found: &Found,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, Cause> {
    let instances = Instances::of(scene, found);
    let picture = if pictures::draws(found, instances.as_ref(), 0, options, run) {
        run.stage(Stage::Preview)?;
        let count = found.surface.face_count();
        let uvs = vec![[[f32::NAN; 2]; 3]; count];
        let faces = Faces { file: Vec::new(), uvs, chart_of: vec![NONE; count] };
        let measured = measured(found, &faces, 0);
        let shown = instances.as_ref().map(|instances| instances.shown(&measured));
        let shown = shown.as_ref().map(|shown| shown.measured(&measured));
        Some(preview::preview_png(&measured, shown.as_ref(), run)?)
    } else {
        None
    };
    run.stage(Stage::Export)?;
    let counts = face_counts(found);
    let part = |p: &Part| PartMetrics {
        id: p.id,
        name: p.name.clone(),
        source: p.source,
        confidence: p.confidence,
        name_confidence: p.name_confidence,
        faces: counts[p.id as usize],
        charts: Vec::new(),
        figures: Figures::default(),
    };
    let cost = run.cost(0, &engine.device.name(), tasks::threads());
    let metrics = Metrics {
        schema: SCHEMA,
        summary: Summary {
            parts: found.parts.parts.len() as u32,
            seconds: cost.wall_s,
            warnings: run.warnings(),
            ..Summary::default()
        },
        deterministic: is_deterministic(run),
        degraded: degraded(run),
        units: Units::default(),
        atlas: AtlasMetrics::default(),
        parts: found.parts.parts.iter().map(part).collect(),
        part_joins: found.parts.joins.clone(),
        charts: Vec::new(),
        repairs: repairs(found),
        engine: env!("CARGO_PKG_VERSION").into(),
        weights: found.weights.clone(),
        device: engine.device.name(),
        cost,
    };
    let labels = found.telling.in_file_order(&found.parts.labels, NONE);
    let parts: Vec<i32> = labels.iter().map(|&p| if p == NONE { -1 } else { p as i32 }).collect();
    let glb = export::part_glb(scene, &parts, Some(&json::value(&extras::block(found, &[]))?))?;
    let labels = PartLabels { labels, ..found.parts.clone() }.to_text().into_bytes();
    let mut artifacts = vec![
        Artifact { kind: ArtifactKind::Model, bytes: glb },
        Artifact { kind: ArtifactKind::Labels, bytes: labels },
        Artifact { kind: ArtifactKind::Metrics, bytes: json::file(&metrics)? },
    ];
    artifacts.extend(picture.map(|bytes| Artifact { kind: ArtifactKind::Preview, bytes }));
    run.advance(1.0);
    Ok(Unwrapped { metrics, artifacts })
}

/// Whether the clock changed nothing.
fn is_deterministic(run: &Run) -> bool {
    run.budget.degraded().iter().all(|d| d.scarce != Scarce::Time)
}

/// What was given up, in a sentence each.
fn degraded(run: &Run) -> Vec<String> {
    run.budget.degraded().iter().map(ToString::to_string).collect()
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

/// What was repaired, with the faces that the file winds the other way.
fn repairs(found: &Found) -> Repairs {
    let known = found.surface.repairs;
    let (surface, telling) = (&found.surface, &found.telling);
    let is_against = |&(i, &f): &(usize, &u32)| f != NONE && telling.is_against(surface, i);
    let mut against = telling.face.iter().enumerate().filter(is_against).map(|(i, _)| i as u64);
    let first = against.next();
    let first_faces = FirstFaces { against_file_winding: first, ..known.first_faces };
    let against_file_winding = against.count() as u64 + u64::from(first.is_some());
    Repairs { against_file_winding, first_faces, ..known }
}

/// Faces of each part.
fn face_counts(found: &Found) -> Vec<u64> {
    let mut faces = vec![0; found.parts.parts.len()];
    let of_file = found.telling.in_file_order(&found.parts.labels, NONE);
    for part in of_file.into_iter().filter(|p| *p != NONE) {
        faces[part as usize] += 1;
    }
    faces
}

fn parts(found: &Found, membership: &Membership, figures: &MeasuredFigures) -> Vec<PartMetrics> {
    let faces = face_counts(found);
    let part = |(p, figures): (&Part, &Figures)| PartMetrics {
        id: p.id,
        name: p.name.clone(),
        source: p.source,
        confidence: p.confidence,
        name_confidence: p.name_confidence,
        faces: faces[p.id as usize],
        charts: membership.charts(p.id),
        figures: figures.clone(),
    };
    found.parts.parts.iter().zip(&figures.parts).map(part).collect()
}

fn charts(
    membership: &Membership,
    finished: &CertifiedAtlas,
    figures: &MeasuredFigures,
) -> Vec<ChartMetrics> {
    let rows = finished.charts.iter().zip(&figures.charts).zip(&finished.certificates.charts);
    let chart =
        |(id, ((m, figures), proof)): (usize, ((&Mapped, &Figures), &Certificate))| ChartMetrics {
            id: id as u32,
            parts: membership.parts(id as u32),
            page: finished.page_of[id],
            faces: m.chart.faces.len() as u64,
            shape: m.chart.shape.kind(),
            start: m.chart.start_kind,
            form: m.form,
            isometric_start: m.isometric_start,
            steps: m.steps,
            neural_gain: m.gain,
            certificate: proof.clone(),
            figures: figures.clone(),
        };
    rows.enumerate().map(chart).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Budget, Cancel, GaveUp};
    use crate::pipeline::scenes;

    /// Two squares and a cube beside them, as far as the result; `change` may change what stands in the atlas.
    fn reported(run: &Run, change: impl Fn(&mut CertifiedAtlas)) -> (CertifiedAtlas, Unwrapped) {
        let text = scenes::and_a_cube(&scenes::squares(2), 8);
        let options = scenes::options();
        let (found, _, mut atlas) = scenes::atlas(&text, &options, run);
        change(&mut atlas);
        let seams = Some(JointSeams { pieces: 3, kept: 1, gain: Some(0.5) });
        let (scene, engine) = (scenes::scene(&text), scenes::engine());
        let result = whole(&scene, &found, &atlas, seams, &options, &engine, run).unwrap();
        (atlas, result)
    }

    #[test]
    fn each_chart_is_told_with_its_part_and_each_part_with_its_charts() {
        let (atlas, result) = reported(&Run::quiet(), |_| {});
        let m = &result.metrics;
        assert_eq!(m.parts.iter().map(|p| p.faces).collect::<Vec<_>>(), [2, 12, 2]);
        assert_eq!(m.charts.len(), atlas.charts.len());
        assert!(m.charts.len() >= 4, "the cube has more than one");
        for (c, mapped) in m.charts.iter().zip(&atlas.charts) {
            assert_eq!(c.faces, mapped.chart.faces.len() as u64);
            let of_part: Vec<u32> =
                (0..3).filter(|&p| m.parts[p as usize].charts.contains(&c.id)).collect();
            assert_eq!(of_part, c.parts);
        }
        assert_eq!(m.atlas.joint_seams.unwrap().kept, 1);
        assert_eq!((m.atlas.charts, m.atlas.width), (m.charts.len() as u32, 256));
        assert!(m.deterministic && m.degraded.is_empty() && m.weights.is_none());
        let kinds: Vec<ArtifactKind> = result.artifacts().iter().map(|a| a.kind).collect();
        let (model, layout) = (ArtifactKind::Model, ArtifactKind::Layout);
        assert_eq!(kinds, [model, ArtifactKind::Metrics, layout, ArtifactKind::Preview]);
        assert_eq!(m.summary.charts, m.atlas.charts);
        assert_eq!(m.summary.symmetric_dirichlet, m.atlas.figures.symmetric_dirichlet_chart);
        assert_eq!((m.summary.density_variation, m.summary.charts_of_network), (None, 0));
    }

    #[test]
    fn what_became_of_a_chart_is_told() {
        let (_, result) = reported(&Run::quiet(), |atlas| {
            let first = &mut atlas.charts[0];
            (first.steps, first.enlarged, first.chamfer) = (40, true, Some(0.5));
            atlas.certificates.charts[1].zero_area_3d = 6;
        });
        let m = &result.metrics;
        assert_eq!((m.charts[0].steps, m.cost.steps, m.repairs.enlarged_faces), (40, 40, 1));
        assert_eq!(m.charts[0].figures.paper.chamfer, Some(0.5));
        assert_eq!(m.charts[1].figures.paper.chamfer, None);
        assert_eq!(m.charts[1].certificate.zero_area_3d, 6);
    }

    #[test]
    fn what_the_clock_decided_is_not_deterministic_and_what_memory_did_is() {
        for (scarce, deterministic) in [(Scarce::Memory, true), (Scarce::Time, false)] {
            let run = Run::quiet();
            run.give_up(Stage::Train, GaveUp::Training, scarce);
            let m = reported(&run, |_| {}).1.metrics;
            assert_eq!(m.deterministic, deterministic);
            assert!(m.degraded.len() == 1 && m.degraded[0].starts_with("train: too little"));
        }
    }

    #[test]
    fn without_memory_or_time_there_are_no_pictures() {
        let budget = Budget::new(None, 64);
        budget.hold(64 << 20).unwrap();
        let poor = Run::new(|_| {}, Cancel::default(), budget);
        for (run, said) in
            [(poor, "preview: too little memory"), (scenes::late(86), "measure: too little time")]
        {
            let result = reported(&run, |_| {}).1;
            assert_eq!(result.artifacts().len(), 2, "the model and the metrics");
            assert!(result.metrics.degraded.iter().any(|d| d.starts_with(said)));
        }
    }

    #[test]
    fn a_job_that_ends_with_its_parts_tells_no_chart() {
        let run = Run::quiet();
        let (found, _) = scenes::found(&scenes::squares(2), &scenes::options(), &run);
        let scene = scenes::scene(&scenes::squares(2));
        let (options, engine) = (scenes::options(), scenes::engine());
        let result = segmentation_only(&scene, &found, &options, &engine, &run).unwrap();
        let m = &result.metrics;
        assert!(m.charts.is_empty() && m.atlas == AtlasMetrics::default());
        assert_eq!(m.parts.iter().map(|p| p.faces).collect::<Vec<_>>(), [2, 2]);
        assert_eq!(result.artifact(ArtifactKind::Labels).unwrap(), b"0\n0\n1\n1\n");
        assert!(result.artifact(ArtifactKind::Layout).is_none());
    }
}
