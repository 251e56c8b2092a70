//! The first stages: condition, sample, segment. They end in two values: what the result indexes, and
//! what the solvers see.

use std::sync::Arc;

use super::densities::densities;
use super::engine::Engine;
use super::error::Cause;
use super::regions::{self, Regions};
use super::sheets;
use crate::contract::{DoubleSided, GaveUp, Run, Scarce, SegmentationSource, Stage, UnwrapOptions};
use crate::mesh::{self, Scene, Surface};
use crate::sampling::{self, PointCloud, SampleCounts};
use crate::segmentation::{self, PartLabels, SegmentOptions};

/// What the result indexes: the surface face for face, and its parts.
pub struct Found {
    /// The conditioned surface.
    pub surface: Arc<Surface>,
    /// Its parts.
    pub parts: PartLabels,
    /// SHA-256 of the network's weights, where it was asked for the parts.
    pub weights: Option<String>,
    /// For each face the face whose UVs it carries (itself but for shared sheets).
    pub sources: Vec<u32>,
    /// Texel density of each part relative to the others.
    pub densities: Vec<f64>,
}

/// What the solvers see: the surface that is cut and flattened, its samples, and what charts may not
/// cross on it.
pub struct Solvers {
    /// The surface.
    pub surface: Arc<Surface>,
    /// The dense cloud on it.
    pub cloud: PointCloud,
    /// Part of each face, or [`NONE`](mesh::NONE).
    pub part_of: Vec<u32>,
    /// What charts may not cross.
    pub regions: Regions,
}

/// Condition, sample, segment.
pub fn find(
    scene: &Scene,
    options: &UnwrapOptions,
    engine: &Engine,
    run: &Run,
) -> Result<(Found, Solvers), Cause> {
    run.stage(Stage::Condition)?;
    let surface = Arc::new(mesh::condition(scene, run)?);
    run.stage(Stage::Sample)?;
    let counts = SampleCounts::dense(surface.face_count());
    let cloud = sampling::sample(&surface, counts, options.seed.0, run)?;
    run.stage(Stage::Segment)?;
    let asked = SegmentOptions::from(options);
    let how = affordable(asked, &surface, run);
    let parts =
        segmentation::segment(&surface, &cloud, &how, &engine.weights, &engine.device, run)?;
    let sources = match options.double_sided {
        DoubleSided::Separate => (0..surface.face_count() as u32).collect(),
        DoubleSided::Share => sheets::sources(&surface),
    };
    let found = Found {
        weights: how.hears_network(&surface).then(|| engine.weights.digest().to_owned()),
        densities: densities(&parts.parts, options)?,
        surface: surface.clone(),
        parts,
        sources,
    };
    let regions = regions::divide(&found, options.atlas);
    let part_of = found.parts.labels.clone();
    run.parts(0, found.parts.parts.len() as u32);
    Ok((found, Solvers { surface, cloud, part_of, regions }))
}

/// The segmentation that there is time for: without the network parts are the file's own.
fn affordable(asked: SegmentOptions, surface: &Surface, run: &Run) -> SegmentOptions {
    if !asked.hears_network(surface) || !run.is_late(Stage::Sample) {
        return asked;
    }
    run.give_up(Stage::Segment, GaveUp::Network, Scarce::Time);
    SegmentOptions { source: SegmentationSource::Authored, ..asked }
}
