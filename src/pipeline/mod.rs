//! The stages in order, and every loop that goes back, since only this module sees both ends: a
//! chart that fails its certificate is divided and goes round again. A pure library: it knows no
//! HTTP and no database. The command line, the worker, the benchmarks and the tests call it.
//!
//! A stage is a function of its inputs, the options and the [`Run`] (which holds clock, cancellation,
//! budget and progress) that returns its output whole.

mod caps;
mod certify;
mod charting;
mod choice;
mod delivery;
mod dense_components;
mod densities;
mod effort;
mod engine;
mod error;
mod extras;
mod faces;
mod finish;
mod input;
mod instances;
mod joint;
mod json;
mod maps;
mod membership;
mod neural;
mod parts;
mod pictures;
mod regions;
mod report;
mod result;
#[cfg(test)]
mod scenes;
mod soft_borders;
mod summary;
mod ways;

pub use crate::segmentation::Weights;
pub use effort::required_bytes;
pub use engine::Engine;
pub use error::{Cause, UnwrapError};
pub use input::{Input, InputFile};
pub use result::{Artifact, Unwrapped};
pub use ways::{Ways, ways};

use crate::contract::{Limits, Progress, Run, Stage, StopAfter, UnwrapOptions, WarningCode};
use crate::mesh::{self, Scene};

/// Bytes of stack that a thread needs which calls the pipeline: walks over large meshes may recurse.
pub const STACK: usize = 64 << 20;

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
    run.count(scene.face_count());
    for warning in &scene.warnings {
        run.tell(Progress::Warning(warning.clone()));
    }
    Ok(scene)
}

/// Tell that textures no longer fit, where the coordinates that they are drawn through are replaced.
fn warn_of_textures(scene: &Scene, options: &UnwrapOptions, run: &Run) {
    let set = options.uv_channel;
    let ends_before = options.stop_after == Some(StopAfter::Segmentation);
    if !ends_before && scene.texture_sets.contains(&u64::from(set)) {
        let message = format!(
            "textures are drawn through TEXCOORD_{set}, which is replaced: they stay as they are and no \
             longer fit. Another `uv_channel` leaves them as they were"
        );
        run.warn(WarningCode::Textured, message);
    }
}

/// Everything behind the import.
fn stages(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<Unwrapped, Cause> {
    effort::admit(scene, options, run)?;
    warn_of_textures(scene, options, run);
    let (found, solvers) = parts::find(scene, options, engine, run)?;
    if options.stop_after == Some(StopAfter::Segmentation) {
        return report::segmentation_only(scene, &found, options, engine, run);
    }
    let made = choice::atlas(&found, &solvers, options, engine, run)?;
    maps::tell_parts(&made.found, &made.atlas.charts, run);
    report::whole(scene, &made.found, &made.atlas, made.joint_seams, options, engine, run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::ArtifactKind;

    #[test]
    fn what_is_not_to_be_drawn_is_not_and_nothing_else_differs() {
        let scene = scenes::scene(scenes::CUBE);
        for stop_after in [None, Some(StopAfter::Segmentation)] {
            let of = |preview| {
                let options = UnwrapOptions { preview, stop_after, ..scenes::options() };
                unwrap(&scene, &options, &scenes::engine(), &Run::quiet()).unwrap()
            };
            let (drawn, plain) = (of(true), of(false));
            let pictures = [ArtifactKind::Layout, ArtifactKind::Preview];
            assert!(pictures.iter().all(|&kind| plain.artifact(kind).is_none()));
            assert!(drawn.artifact(ArtifactKind::Preview).is_some());
            assert!(plain.metrics.degraded.is_empty(), "nothing was given up");
            let model = ArtifactKind::Model;
            assert_eq!(plain.artifact(model), drawn.artifact(model));
        }
    }

    #[test]
    fn textures_are_warned_of_where_their_coordinates_are_replaced_and_nowhere_else() {
        let scene = Scene { texture_sets: vec![0, 2], ..Default::default() };
        let told = |uv_channel, stop_after| {
            let (run, told) = scenes::watched();
            let options = UnwrapOptions { uv_channel, stop_after, ..Default::default() };
            warn_of_textures(&scene, &options, &run);
            told.lock().unwrap().len()
        };
        assert_eq!([0, 1, 2, 3].map(|channel| told(channel, None)), [1, 0, 1, 0]);
        assert_eq!(told(0, Some(StopAfter::Charts)), 1);
        assert_eq!(told(0, Some(StopAfter::Segmentation)), 0, "no coordinates are written");
    }
}
