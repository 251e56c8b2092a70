//! The stages in order, and every loop that goes back, since only this module sees both ends: a
//! chart that fails its certificate is divided and goes round again. A pure library: it knows no
//! HTTP and no database. The command line, the worker, the benchmarks and the tests call it.
//!
//! A stage is a function of its inputs, the options and the [`Run`] (which holds clock, cancellation,
//! budget and progress) that returns its output whole.

mod certify;
mod charting;
mod densities;
mod effort;
mod engine;
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
#[cfg(test)]
mod scenes;
mod sheets;

pub use crate::segmentation::Weights;
pub use effort::required_bytes;
pub use engine::Engine;
pub use error::{Cause, UnwrapError};
pub use input::{Input, InputFile};
pub use result::{Artifact, Unwrapped};

use crate::contract::{Limits, Progress, Run, Stage, StopAfter, UnwrapOptions};
use crate::mesh::{self, Scene};

/// Import and unwrap.
pub fn unwrap_input(
    input: &Input,
    options: &UnwrapOptions,
    limits: &Limits,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, UnwrapError> {
    let whole = || {
        options.validate().map_err(Cause::Options)?;
        run.stage(Stage::Import)?;
        stages(&import(input, limits, run)?, options, engine, run)
    };
    whole().map_err(|cause| cause.of(run))
}

/// Unwrap a scene.
pub fn unwrap(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, UnwrapError> {
    let whole = || {
        options.validate().map_err(Cause::Options)?;
        stages(scene, options, engine, run)
    };
    whole().map_err(|cause| cause.of(run))
}

fn import(input: &Input, limits: &Limits, run: &Run) -> Result<Scene, Cause> {
    let mut scene = mesh::import(input.mesh(), input.kind(), limits)?;
    if let Some(labels) = input.labels() {
        let labels = mesh::import::parse_labels(labels, scene.face_count());
        scene.labels = Some(labels.map_err(Cause::Labels)?);
    }
    for warning in &scene.warnings {
        run.tell(Progress::Warning(warning.clone()));
    }
    Ok(scene)
}

/// Everything behind the import.
fn stages(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, Cause> {
    effort::admit(scene, options, run)?;
    let (found, solvers) = parts::find(scene, options, engine, run)?;
    if options.stop_after == Some(StopAfter::Segmentation) {
        return report::segmentation_only(scene, &found, engine, run);
    }
    let cut = charting::cut(&solvers, options, engine, run)?;
    let mapped = match options.stop_after {
        Some(StopAfter::Charts) => maps::untrained(cut.charts),
        _ => maps::trained(&found, &solvers, cut.charts, options, engine, run)?,
    };
    let finished = finish::pack_and_certify(&found, &solvers, mapped, options, run)?;
    report::whole(scene, &found, &solvers, &finished, cut.joint_seams, options, engine, run)
}
