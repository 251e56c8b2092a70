//! What a job of this size will need, counted from its input and options before anything is done: memory,
//! which is refused where the job has not so much, and work, by which progress is weighed.

use super::error::Cause;
use crate::atlas;
use crate::contract::{Quality, Run, Stage, StopAfter, UnwrapOptions};
use crate::mesh::Scene;

/// Bytes that the pipeline holds for each face, measured on large objects with room to spare.
const BYTES_PER_FACE: u64 = 2_000;

/// Count the scene against the job's memory, and say how much work each stage has ahead.
pub fn admit(scene: &Scene, options: &UnwrapOptions, run: &Run) -> Result<(), Cause> {
    let faces = scene.face_count() as u64;
    run.budget.hold(required_bytes(faces, options)).map_err(|need| {
        Cause::OutOfMemory(format!(
            "{faces} triangles on pages of {} texels need about {need} MiB and the job may use {} MiB: raise \
             `budget_mib`, or simplify the mesh",
            options.page_size,
            run.budget.memory_mib()
        ))
    })?;
    run.expect(&work(faces as f64, options));
    Ok(())
}

/// Bytes without which such a job cannot be done.
pub fn required_bytes(faces: u64, options: &UnwrapOptions) -> u64 {
    faces.saturating_mul(BYTES_PER_FACE).saturating_add(atlas::raster_bytes(options.page_size))
}

/// Expected seconds of each stage on one core (lines through 41 objects of 300 to 75,000 faces).
fn work(faces: f64, options: &UnwrapOptions) -> Vec<(Stage, f64)> {
    let thousands = faces / 1000.0;
    let line = |fixed: f64, each: f64| fixed + each * thousands;
    let mut work = vec![
        (Stage::Import, line(0.002, 0.0003)),
        (Stage::Condition, line(0.001, 0.0006)),
        (Stage::Sample, line(0.003, 0.0014)),
        (Stage::Segment, line(0.21, 0.006)),
    ];
    let train = match options.quality {
        Quality::Fast | Quality::Balanced => 0.0,
        Quality::Best => line(0.5, 0.2),
    };
    let joint = if options.quality == Quality::Best { 2.0 } else { 1.0 };
    if options.stop_after != Some(StopAfter::Segmentation) {
        work.push((Stage::Charts, joint * line(0.12, 0.065)));
        if options.stop_after.is_none() {
            work.extend([(Stage::Train, train), (Stage::Polish, line(0.003, 0.006))]);
        }
        work.extend([(Stage::Pack, line(0.15, 0.004)), (Stage::Measure, line(0.01, 0.005))]);
    }
    if options.preview {
        work.push((Stage::Preview, line(0.1, 0.004)));
    }
    work.push((Stage::Export, line(0.002, 0.0006)));
    work
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{Budget, Cancel, Limits};
    use crate::pipeline::scenes;

    #[test]
    fn what_is_accepted_fits_the_memory_that_a_job_has() {
        let (limits, options) = (Limits::default(), UnwrapOptions::default());
        let most = UnwrapOptions { page_size: 16384, pages: 64, ..options.clone() };
        for options in [options, most] {
            assert!(required_bytes(limits.triangles, &options) <= options.budget_mib << 20);
            assert!(options.budget_mib <= limits.job_mib);
        }
        // Whatever the numbers are, they are only counted.
        assert_eq!(required_bytes(u64::MAX, &UnwrapOptions::default()), u64::MAX);
    }

    #[test]
    fn a_scene_that_does_not_fit_is_refused_with_the_memory_that_would_do() {
        let scene = scenes::scene(&scenes::sheet(80, |_, _| 0.0));
        let options = UnwrapOptions { budget_mib: 64, page_size: 4096, ..Default::default() };
        let admitted = |mib| {
            let run = Run::new(|_| {}, Cancel::default(), Budget::new(None, mib));
            admit(&scene, &options, &run).map(|()| run.budget.spare_bytes())
        };
        let need = required_bytes(12_800, &options);
        let mib = need.div_ceil(1 << 20);
        assert!(mib > 65);
        let error = admitted(mib - 1).unwrap_err().to_string();
        assert!(error.contains(&format!("about {mib} MiB")), "{error}");
        assert!(error.contains("12800 triangles") && error.contains("budget_mib"), "{error}");
        // What is admitted is held to the end.
        assert_eq!(admitted(mib).unwrap(), (mib << 20) - need);
    }

    #[test]
    fn only_the_stages_that_will_run_are_expected() {
        let stages = |stop_after| -> Vec<Stage> {
            let options = UnwrapOptions { stop_after, ..Default::default() };
            let mut stages: Vec<Stage> = work(1e3, &options).iter().map(|w| w.0).collect();
            stages.sort();
            stages
        };
        assert_eq!(stages(None), Stage::ALL);
        let trained = |s: &&Stage| matches!(s, Stage::Train | Stage::Polish);
        let charts: Vec<Stage> = Stage::ALL.iter().filter(|s| !trained(s)).copied().collect();
        assert_eq!(stages(Some(StopAfter::Charts)), charts);
        let parts = stages(Some(StopAfter::Segmentation));
        assert!(!parts.contains(&Stage::Charts) && !parts.contains(&Stage::Pack));
        assert!(parts.contains(&Stage::Segment) && parts.contains(&Stage::Export));
        // More quality is more work.
        let train = |quality| {
            let options = UnwrapOptions { quality, ..Default::default() };
            work(1e4, &options).iter().find(|w| w.0 == Stage::Train).unwrap().1
        };
        let [fast, balanced, best] = [Quality::Fast, Quality::Balanced, Quality::Best].map(train);
        assert!(fast == 0.0 && balanced == 0.0 && best > 0.0);
    }
}
