//! Time and memory of a job: what runs out ends in a degraded but valid result that says what was given
//! up, or in a code with the number that would do.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use uvsegnet::contract::{
    ArtifactKind, Budget, Cancel, ErrorCode, Limits, Progress, Quality, Run, Stage, UnwrapOptions,
    WarningCode,
};
use uvsegnet::device::Device;
use uvsegnet::pipeline::{Engine, Input, UnwrapError, Unwrapped, unwrap_input};

use super::{example, kind_of, quick, unwrap};

fn unwrap_within(
    bytes: &[u8],
    options: &UnwrapOptions,
    budget: Budget,
) -> (Result<Unwrapped, UnwrapError>, Vec<Progress>) {
    let told = Arc::new(Mutex::new(Vec::new()));
    let listener = told.clone();
    let run = Run::new(move |p| listener.lock().unwrap().push(p), Cancel::default(), budget);
    let input = Input::new(kind_of(bytes), bytes);
    let engine = Engine::new(Device::cpu());
    let result = unwrap_input(&input, options, &Limits::default(), &engine, &run);
    let told = told.lock().unwrap().clone();
    (result, told)
}

/// A ball of 2 · 120 · 100 triangles, as OBJ.
fn ball() -> String {
    let (across, up) = (180, 110);
    let mut text = String::new();
    for j in 0..=up {
        for i in 0..across {
            let (a, b) = (
                std::f64::consts::TAU * f64::from(i) / f64::from(across),
                std::f64::consts::PI * (f64::from(j) + 0.5) / f64::from(up + 1),
            );
            text += &format!("v {} {} {}\n", b.sin() * a.cos(), b.cos(), b.sin() * a.sin());
        }
    }
    for j in 0..up {
        for i in 0..across {
            let at = |i: i32, j: i32| j * across + i % across + 1;
            text +=
                &format!("f {} {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    text
}

#[test]
fn a_job_whose_stages_are_all_late_is_valid_and_says_what_it_gave_up() {
    let bytes = std::fs::read(example("chair_small.glb")).unwrap();
    let options = UnwrapOptions { quality: Quality::Best, ..quick() };
    let late = Budget::new(Some(1e5), 6144).since(Instant::now() - Duration::from_secs(90_000));
    let (result, told) = unwrap_within(&bytes, &options, late);
    let result = result.unwrap();
    let m = &result.metrics;
    assert!(m.atlas.certificate.valid && !m.deterministic);
    assert!(m.charts.iter().all(|c| c.steps == 0));
    let stages: Vec<&str> = m.degraded.iter().map(|d| d.split(':').next().unwrap()).collect();
    for stage in [Stage::Segment, Stage::Charts, Stage::Polish, Stage::Pack] {
        assert!(stages.contains(&stage.as_str()), "{stage:?} is not in {:?}", m.degraded);
    }
    assert!(result.artifact(ArtifactKind::Preview).is_none());
    assert!(result.artifact(ArtifactKind::Model).is_some());
    let warned = told
        .iter()
        .filter(|p| matches!(p, Progress::Warning(w) if w.code == WarningCode::Degraded));
    assert_eq!(warned.count(), m.degraded.len());
    // Without the network, its weights have no say.
    assert_eq!(m.weights, None);
}

#[test]
fn a_job_whose_time_is_over_says_how_many_seconds_would_do() {
    let bytes = std::fs::read(example("chair_small.glb")).unwrap();
    let options = UnwrapOptions { budget_s: Some(0.001), ..quick() };
    let (result, _) = unwrap_within(&bytes, &options, Budget::new(options.budget_s, 6144));
    let error = result.unwrap_err().job_error().unwrap();
    assert_eq!(error.code, ErrorCode::TimedOut);
    assert!(error.message.contains("budget_s") && error.message.contains("would do"), "{error}");
}

#[test]
fn a_job_with_too_little_memory_says_how_much_would_do_and_that_does() {
    let ball = ball();
    let with = |budget_mib| {
        let options = UnwrapOptions { budget_mib, quality: Quality::Fast, ..quick() };
        unwrap_within(ball.as_bytes(), &options, Budget::new(None, budget_mib)).0
    };
    let error = with(64).unwrap_err().job_error().unwrap();
    assert_eq!(error.code, ErrorCode::OutOfMemory);
    let number = error.message.split("about ").nth(1).and_then(|rest| rest.split(' ').next());
    let enough: u64 = number.unwrap().parse().unwrap();
    assert!((65..200).contains(&enough), "{error}");
    // Just enough: valid, the same everywhere, and without pictures.
    let result = with(enough).unwrap();
    let m = &result.metrics;
    assert!(m.atlas.certificate.valid && m.deterministic);
    assert!(
        m.degraded.iter().any(|d| d.starts_with("preview: too little memory")),
        "{:?}",
        m.degraded
    );
    assert!(result.artifact(ArtifactKind::Preview).is_none());
    let plenty = with(6144).unwrap();
    assert!(plenty.metrics.degraded.is_empty() && plenty.artifact(ArtifactKind::Preview).is_some());
}

#[test]
fn the_fraction_of_a_job_never_falls_and_every_stage_moves_it() {
    let bytes = std::fs::read(example("table.glb")).unwrap();
    let (result, told) = unwrap_within(&bytes, &quick(), Budget::default());
    let parts = result.unwrap().metrics.parts.len() as u32;
    let mut last = (0.0, 0);
    let mut moved = Vec::new();
    for progress in &told {
        if let Progress::Progress { stage, fraction, parts_done, parts_total } = *progress {
            assert!(fraction >= last.0 && parts_done >= last.1, "{progress:?} after {last:?}");
            assert!(parts_done <= parts_total && [0, parts].contains(&parts_total));
            if fraction > last.0 && moved.last() != Some(&stage) {
                moved.push(stage);
            }
            last = (fraction, parts_done);
        }
    }
    assert_eq!(last, (1.0, parts));
    for stage in [Stage::Segment, Stage::Charts, Stage::Polish, Stage::Pack, Stage::Preview] {
        assert!(moved.contains(&stage), "{stage:?} is not among {moved:?}");
    }
}

#[test]
fn options_are_checked_where_every_command_passes() {
    let options = UnwrapOptions { part_boundary: 7.0, ..quick() };
    let error = unwrap(super::options::CUBE.as_bytes(), None, &options).unwrap_err();
    assert_eq!(error.job_error().unwrap().code, ErrorCode::InvalidOption);
    assert!(error.to_string().contains("`part_boundary`"), "{error}");
}
