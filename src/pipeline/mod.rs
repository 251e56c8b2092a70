//! The stages in order, and every loop that goes back, since only this module sees both ends: a
//! chart that fails its certificate is divided and goes round again. A pure library: it knows no
//! HTTP and no database. The command line, the worker, the benchmarks and the tests call it.

mod charting;
mod clock;
mod error;
mod extras;
mod faces;
mod finish;
mod input;
mod joint;
mod maps;
mod neural;
mod parts;
mod regions;
mod report;
mod result;
mod sheets;
mod weights;

pub use error::UnwrapError;
pub use input::{Input, InputFile};
pub use result::{Artifact, Unwrapped};

use crate::contract::{Limits, Run, Stage, StopAfter, UnwrapOptions};
use crate::device::Device;
use crate::mesh::{self, Scene};
use clock::Clock;
use finish::Finished;

/// Import and unwrap.
pub fn unwrap_input(
    input: &Input,
    options: &UnwrapOptions,
    limits: &Limits,
    device: &Device,
    run: &Run,
) -> Result<Unwrapped, UnwrapError> {
    let mut clock = Clock::new();
    let scene = import(input, limits, run, &mut clock)?;
    unwrap_scene(&scene, options, device, run, clock)
}

/// Unwrap a scene.
pub fn unwrap(
    scene: &Scene,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
) -> Result<Unwrapped, UnwrapError> {
    unwrap_scene(scene, options, device, run, Clock::new())
}

fn import(
    input: &Input,
    limits: &Limits,
    run: &Run,
    clock: &mut Clock,
) -> Result<Scene, UnwrapError> {
    clock.stage(Stage::Import, run)?;
    let mut scene = mesh::import(input.mesh(), input.kind(), limits)?;
    if let Some(labels) = input.labels() {
        let labels = mesh::import::parse_labels(labels, scene.face_count());
        scene.labels = Some(labels.map_err(UnwrapError::Labels)?);
    }
    for (code, message) in &scene.warnings {
        run.warn(code, message.clone());
    }
    Ok(scene)
}

fn unwrap_scene(
    scene: &Scene,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
    mut clock: Clock,
) -> Result<Unwrapped, UnwrapError> {
    parts::check_memory(scene, options)?;
    let found = parts::find(scene, options, device, run, &mut clock)?;
    if options.stop_after == Some(StopAfter::Segmentation) {
        return report::segmentation_only(scene, &found, device, run, clock);
    }
    let charting::Cut { charts, joint_seams } =
        charting::charts(&found, options, device, run, &mut clock)?;
    let untrained = options.stop_after == Some(StopAfter::Charts);
    let mapped = if untrained {
        maps::untrained(charts)
    } else {
        maps::trained(&found, charts, options, device, run, &mut clock)?
    };
    let finished = finish::pack_and_certify(&found, mapped, options, run, &mut clock)?;
    let finished = Finished { joint_seams, ..finished };
    report::whole(scene, &found, &finished, options, device, run, clock)
}
