//! How far the maps go: what training gains, which seams it moves, how many charts there are, and where a job
//! may end.

use std::sync::{Arc, Mutex};

use uvsegnet::contract::{
    ArtifactKind, Budget, Cancel, ChartForm, ChartMetrics, Limits, Progress, Quality, Run,
    SegmentationSource, Stage, StopAfter, UnwrapOptions, WarningCode,
};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, Unwrapped, unwrap_input};

use super::options::CUBE;
use super::{example, kind_of, quick, unwrap, unwrap_example};

#[test]
fn training_runs_on_doubly_curved_charts_and_says_what_it_gained() {
    let options = UnwrapOptions { quality: Quality::Best, ..quick() };
    let m = unwrap_example("chair_small.glb", &options).metrics;
    let trained: Vec<_> = m.charts.iter().filter(|c| c.steps > 0).collect();
    assert!(trained.len() >= 4, "{} charts trained", trained.len());
    for chart in trained {
        let gain = chart.neural_gain.as_ref().unwrap();
        let (start, baseline, net) =
            (gain.start.unwrap(), gain.start_polish.unwrap(), gain.net.unwrap());
        assert!(baseline <= start + 1e-9, "{gain:?}");
        let best = match gain.net_polish {
            Some(polished) => {
                assert!(net < start && polished <= net + 1e-9, "{gain:?}");
                assert_eq!(gain.gain, Some((baseline - polished) / baseline));
                baseline.min(polished)
            }
            None => baseline,
        };
        // The network ships where it wins, and the map that ships is the better of the two.
        let wins = gain.net_polish.is_some_and(|polished| polished + 1e-6 < baseline);
        assert_eq!(chart.form == ChartForm::Trained, wins, "{gain:?}");
        let measured = chart.figures.symmetric_dirichlet_chart.unwrap();
        assert!((measured - best).abs() < 1e-5, "{measured} {gain:?}");
    }
    assert!(m.charts.iter().filter(|c| c.isometric_start).all(|c| c.steps == 0));
}

#[test]
fn the_best_quality_trains_the_seams_and_never_loses_by_it() {
    let options = UnwrapOptions { quality: Quality::Best, steps: 20, points: 64, ..quick() };
    let best = unwrap_example("chair_small.glb", &options).metrics;
    let joint = best.atlas.joint_seams.unwrap();
    let gain = joint.gain.unwrap();
    assert!(joint.pieces > 0, "{joint:?}");
    // Who keeps a trained seam has gained by it, and nobody else has.
    assert_eq!(gain > 0.0, joint.kept > 0, "{joint:?}");
    assert!(best.atlas.certificate.valid);
    let plain = unwrap_example("chair_small.glb", &quick()).metrics;
    assert_eq!(plain.atlas.joint_seams, None);
    let seams = |m: &uvsegnet::contract::Metrics| m.atlas.figures.seam_length.unwrap();
    assert_eq!(seams(&best) != seams(&plain), joint.kept > 0, "kept seams are other seams");
}

#[test]
fn quality_fast_trains_nothing() {
    let m =
        unwrap_example("table.glb", &UnwrapOptions { quality: Quality::Fast, ..quick() }).metrics;
    assert!(m.atlas.certificate.valid);
    assert!(m.charts.iter().all(|c| c.steps == 0 && c.neural_gain.is_none()));
}

/// The result, and the warnings of missed aims.
fn told(bytes: &[u8], options: &UnwrapOptions) -> (Unwrapped, Vec<String>) {
    let told = Arc::new(Mutex::new(Vec::new()));
    let listener = told.clone();
    let listen = move |p| {
        if let Progress::Warning(w) = p
            && w.code == WarningCode::MaxChartsMissed
        {
            listener.lock().unwrap().push(w.message);
        }
    };
    let run = Run::new(listen, Cancel::default(), Budget::default());
    let input = Input::new(kind_of(bytes), bytes);
    let engine = Engine::new(Device::cpu());
    let result = unwrap_input(&input, options, &Limits::default(), &engine, &run).unwrap();
    let told = told.lock().unwrap().clone();
    (result, told)
}

#[test]
fn there_are_fewer_charts_when_asked_or_a_warning() {
    let bytes = std::fs::read(example("chair_small.glb")).unwrap();
    let with = |max_charts| {
        let (quality, distortion_bound) = (Quality::Fast, 1e-4);
        let options = UnwrapOptions { max_charts, quality, distortion_bound, ..quick() };
        let (result, warned) = told(&bytes, &options);
        assert!(result.metrics.atlas.certificate.valid);
        (result.metrics.atlas.charts, result.metrics.parts.len() as u32, warned)
    };
    let (free, parts, warned) = with(None);
    assert!(warned.is_empty());
    let (fewer, _, warned) = with(Some(free - 1));
    assert!(fewer < free && warned.is_empty(), "{fewer} of {free}, {warned:?}");
    let (least, _, warned) = with(Some(1));
    assert!(least <= fewer && least >= parts, "each part has a chart");
    assert!(
        warned.len() == 1 && warned[0].starts_with(&format!("there are {least} charts")),
        "{warned:?}"
    );
}

#[test]
fn a_job_may_end_with_its_charts() {
    let stop = |quality, stop_after| {
        let options = UnwrapOptions { stop_after, quality, ..quick() };
        unwrap_example("chair_small.glb", &options)
    };
    let result = stop(Quality::Best, Some(StopAfter::Charts));
    let m = &result.metrics;
    assert!(m.atlas.certificate.valid && m.deterministic);
    for kind in [ArtifactKind::Model, ArtifactKind::Layout, ArtifactKind::Preview] {
        assert!(result.artifact(kind).is_some(), "{kind:?}");
    }
    // Nothing was trained or polished: the maps of the cut ship.
    assert!(m.charts.iter().all(|c| c.steps == 0 && c.form == ChartForm::Start));
    assert!(m.charts.iter().all(|c| c.neural_gain.is_none()));
    let ran = |stage: Stage| m.cost.stages.iter().any(|s| s.name == stage.as_str());
    assert!(ran(Stage::Charts) && ran(Stage::Pack) && !ran(Stage::Train) && !ran(Stage::Polish));
    // What was trained may ship another cut: `balanced` cuts both alike.
    let m = stop(Quality::Balanced, Some(StopAfter::Charts)).metrics;
    let whole = stop(Quality::Balanced, None).metrics;
    assert_eq!(whole.atlas.charts, m.atlas.charts);
    let energy = |c: &ChartMetrics| c.figures.symmetric_dirichlet_chart.unwrap();
    for (start, polished) in m.charts.iter().zip(&whole.charts) {
        assert!(energy(start) > energy(polished) - 1e-6, "chart {}", start.id);
    }
    let worse = m.charts.iter().zip(&whole.charts).filter(|(a, b)| energy(a) > energy(b) + 1e-4);
    assert!(worse.count() > 0, "some start map can be polished");
}

#[test]
fn seams_are_trained_in_each_component_that_leaves_a_choice() {
    // A cube apart, and a square that leaves none.
    let text = format!("{CUBE}v 0 5 0\nv 1 5 0\nv 1 6 0\nv 0 6 0\nf 9 10 11 12\n");
    let options = UnwrapOptions {
        quality: Quality::Best,
        segmentation: SegmentationSource::Authored,
        ..quick()
    };
    let m = unwrap(text.as_bytes(), None, &options).unwrap().metrics;
    assert_eq!(m.atlas.joint_seams.map(|joint| joint.pieces), Some(1));
}
