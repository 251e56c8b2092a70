//! What a job of this size will need, counted from its input and options before anything is done: memory,
//! which is refused where the job has not so much, and work, by which progress is weighed.

use super::error::Cause;
use crate::atlas;
use crate::contract::{Quality, Run, Stage, StopAfter, UnwrapOptions};
use crate::mesh::Scene;

/// Bytes that the pipeline holds for each face, measured on large objects with room to spare.
const BYTES_PER_FACE: u64 = 3_000;

/// Count the scene against the job's memory, and say how much work each stage has ahead.
pub fn admit(scene: &Scene, options: &UnwrapOptions, run: &Run) -> Result<(), Cause> {
    let faces = scene.face_count() as u64;
    run.budget.hold(required_bytes(faces, options)).map_err(|need| {
        Cause::OutOfMemory(format!(
            "{faces} triangles on pages of {} texels need about {need} MiB and the job may use {} MiB: raise \
             budget_mib, or send a mesh with fewer triangles",
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

/// Expected seconds of each stage on one core (lines through 58 objects of 300 to 73,000 faces).
fn work(faces: f64, options: &UnwrapOptions) -> Vec<(Stage, f64)> {
    let thousands = faces / 1000.0;
    let line = |fixed: f64, each: f64| fixed + each * thousands;
    let mut work = vec![
        (Stage::Import, line(0.002, 0.0003)),
        (Stage::Condition, line(0.001, 0.0006)),
        (Stage::Sample, line(0.003, 0.0014)),
        (Stage::Segment, line(0.22, 0.006)),
    ];
    let train = match options.quality {
        Quality::Fast => 0.0,
        Quality::Balanced => line(0.15, 0.05).min(2.0),
        Quality::Best => line(0.5, 0.2),
    };
    let joint = if options.quality == Quality::Best { 2.0 } else { 1.0 };
    if options.stop_after != Some(StopAfter::Segmentation) {
        work.push((Stage::Charts, joint * line(0.15, 0.06)));
        if options.stop_after.is_none() {
            work.extend([(Stage::Train, train), (Stage::Polish, line(0.003, 0.006))]);
        }
        work.extend([(Stage::Pack, line(0.5, 0.004)), (Stage::Measure, line(0.01, 0.005))]);
    }
    work.extend([(Stage::Preview, line(0.4, 0.002)), (Stage::Export, line(0.002, 0.0006))]);
    work
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Limits;

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
}
