//! Examples from the procedural generator: the shape drawn, stretched, roughened, half of them as one
//! body whose parts have no walls between them.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::example::{Example, Labels, POINTS};
use super::names::name_index;
use super::structure::{Structure, scene};
use super::union;
use crate::contract::{Canceled, Run, Winding};
use crate::mesh;
use crate::mesh::rays::Rays;
use crate::sampling::{self, SampleCounts};
use crate::synth::{self, SynthKind, SynthObject};

/// Most that an axis is stretched or squeezed.
pub const STRETCH: f64 = 1.35;

/// Which object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ProceduralStyle {
    /// What it is.
    pub kind: SynthKind,
    /// Which one.
    pub seed: u64,
}

impl ProceduralStyle {
    /// `count` objects, every kind in turn.
    pub fn series(count: usize, seed: u64) -> Vec<Self> {
        let kind = |i: usize| SynthKind::ALL[i % SynthKind::ALL.len()];
        (0..count).map(|i| Self { kind: kind(i), seed: seed.wrapping_add(i as u64) }).collect()
    }
}

/// The example of an object. Three in five are one body: points inside other parts are gone.
pub fn example(style: ProceduralStyle, run: &Run) -> Result<Example, Canceled> {
    let mut rng = ChaCha8Rng::seed_from_u64(style.seed ^ 0x5eed_0000_0000_0000);
    let fused = rng.random_bool(0.6);
    let stretch: DVec3 = std::array::from_fn(|_| STRETCH.powf(rng.random_range(-1.0..1.0))).into();
    let mut object = synth::embellished(style.kind, style.seed);
    stretch_parts(&mut object, stretch);
    let scene = scene(&object, Structure::Nodes);
    let surface = mesh::condition(&scene, Winding::Surface, run)?.surface;
    let parts: Vec<i32> = object.labels().iter().map(|&l| l as i32).collect();
    let parts = surface.from_file_order(&parts);
    let of_part: Vec<i32> =
        object.parts.iter().map(|p| name_index(p.coarse_name()).map_or(-1, |i| i as i32)).collect();
    let names: Vec<i32> = parts.iter().map(|&p| of_part[p as usize]).collect();
    let labels = Labels { parts: &parts, names: &names };
    let mut example = if fused {
        let counts = SampleCounts { base: 3 * POINTS, extra: 0.1 };
        let cloud = sampling::sample(&surface, counts, style.seed, run)?;
        let rays = Rays::new(&surface);
        let cloud = union::outside(&surface, &rays, &cloud);
        Example::of_cloud(&cloud, &labels, |c| union::thickness(&surface, &rays, c), run)?
    } else {
        Example::of_surface(&surface, &labels, style.seed, run)?
    };
    example.category = style.kind.as_str().to_owned();
    example.id = format!("{}_{}", example.category, style.seed);
    example.family = example.id.clone();
    Ok(example)
}

/// Stretch an object.
pub fn stretch_parts(object: &mut SynthObject, by: DVec3) {
    for part in &mut object.parts {
        part.positions.iter_mut().for_each(|p| *p *= by);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_gives_an_example_with_its_parts() {
        for kind in SynthKind::ALL {
            for seed in 0..2 {
                let example = example(ProceduralStyle { kind, seed }, &Run::quiet()).unwrap();
                let parts: std::collections::BTreeSet<i32> = example.part.iter().copied().collect();
                assert!(parts.len() > 1, "{kind:?} {seed}: {parts:?}");
                assert!(example.len() > POINTS / 2, "{kind:?} {seed}: {} points", example.len());
                let known = example.name.iter().filter(|n| **n >= 0).count();
                assert!(2 * known > example.len(), "{kind:?} {seed}: {known} points named");
                let thick = example.cloud.thickness.iter().filter(|t| **t > 0.0).count();
                assert!(2 * thick > example.len(), "{kind:?} {seed}: {thick} thick");
            }
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_example() {
        let style = ProceduralStyle { kind: SynthKind::Lamp, seed: 3 };
        let make = || example(style, &Run::quiet()).unwrap();
        assert_eq!(make(), make());
    }
}
