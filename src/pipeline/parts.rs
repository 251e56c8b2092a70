//! The first stages: condition, sample, segment.

use super::clock::Clock;
use super::error::UnwrapError;
use super::regions;
use super::sheets;
use super::weights::weights;
use crate::contract::{DoubleSided, Run, Stage, UnwrapOptions};
use crate::device::Device;
use crate::mesh::{self, Scene, Surface};
use crate::sampling::{self, PointCloud, SampleCounts};
use crate::segmentation::{self, PartLabels};

/// Bytes that the pipeline holds for each face, measured on large objects with room to spare.
const BYTES_PER_FACE: u64 = 3_000;

/// The surface and its parts.
pub struct Found {
    /// The conditioned surface.
    pub surface: Surface,
    /// The dense cloud.
    pub cloud: PointCloud,
    /// Its parts.
    pub parts: PartLabels,
    /// For each face the face whose UVs it carries (itself but for shared sheets).
    pub sources: Vec<u32>,
    /// Texel density of each part relative to the others.
    pub weights: Vec<f64>,
    /// What charts may not cross, for each face: its part, or part and material where each material
    /// has an atlas; [`NONE`](mesh::NONE) for faces that get no chart of their own.
    pub region_of: Vec<u32>,
    /// Part of each region.
    pub part_of_region: Vec<u32>,
    /// Atlas page of each region.
    pub page_of_region: Vec<u32>,
}

/// Refuse a scene that cannot fit the job's memory, before it is tried.
pub fn check_memory(scene: &Scene, options: &UnwrapOptions) -> Result<(), UnwrapError> {
    let faces = scene.face_count() as u64;
    let need = (faces * BYTES_PER_FACE) >> 20;
    if need > options.budget_mib {
        return Err(UnwrapError::OutOfMemory(format!(
            "{faces} triangles need about {need} MiB and the job may use {} MiB: raise budget_mib, \
             or send a mesh with fewer triangles",
            options.budget_mib
        )));
    }
    Ok(())
}

/// Condition, sample, segment.
pub fn find(
    scene: &Scene,
    options: &UnwrapOptions,
    device: &Device,
    run: &Run,
    clock: &mut Clock,
) -> Result<Found, UnwrapError> {
    clock.stage(Stage::Condition, run)?;
    let surface = mesh::condition(scene, run)?;
    clock.stage(Stage::Sample, run)?;
    let counts = SampleCounts::dense(surface.face_count());
    let cloud = sampling::sample(&surface, counts, options.seed.0, run)?;
    clock.stage(Stage::Segment, run)?;
    let parts = segmentation::segment(
        &surface,
        &cloud,
        options.segmentation,
        options.part_boundary,
        device,
        run,
    )?;
    let weights = weights(&parts.parts, options)?;
    let sources = match options.double_sided {
        DoubleSided::Separate => (0..surface.face_count() as u32).collect(),
        DoubleSided::Share => sheets::sources(&surface),
    };
    let mut found = Found {
        surface,
        cloud,
        parts,
        sources,
        weights,
        region_of: Vec::new(),
        part_of_region: Vec::new(),
        page_of_region: Vec::new(),
    };
    regions::divide(&mut found, options.atlas);
    Ok(found)
}
