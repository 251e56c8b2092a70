//! Procedural objects as labelled meshes, in every way that an object may stand in a file.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::folder::LabelledMesh;
use super::procedural::{STRETCH, stretch_parts};
use super::structure::{Structure, scene};
use super::trainer::TrainError;
use super::weather::weather;
use crate::contract::{Run, Winding};
use crate::mesh;
use crate::synth::{self, SynthKind};

/// A procedural object as a labelled mesh: its parts joined to one body where `fused`, standing in the
/// file in one of the ways that there are.
pub fn procedural_mesh(
    kind: SynthKind,
    seed: u64,
    fused: bool,
    run: &Run,
) -> Result<LabelledMesh, TrainError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let stretch = std::array::from_fn(|_| STRETCH.powf(rng.random_range(-1.0..1.0)));
    let mut object = synth::embellished(kind, seed);
    stretch_parts(&mut object, stretch.into());
    let structure = Structure::ALL[rng.random_range(0..Structure::ALL.len())];
    let (object, structure) = if fused {
        // A body that was scanned or printed has no hard edges to be split at.
        let split =
            if structure == Structure::Soup { Structure::Soup } else { Structure::Components };
        let mut object = synth::fused(object, rng.random_range(2000..9000));
        if let Some(body) = &mut object.fused {
            weather(body, &mut rng);
        }
        (object, split)
    } else {
        (object, structure)
    };
    let surface = mesh::condition(&scene(&object, structure), Winding::Surface, run)?.surface;
    let parts: Vec<i32> = object.labels().iter().map(|&l| l as i32).collect();
    let parts = surface.from_file_order(&parts);
    let id = format!("{}_{seed}", kind.as_str());
    Ok(LabelledMesh {
        family: id.clone(),
        id,
        category: kind.as_str().to_owned(),
        source: "procedural".to_owned(),
        surface,
        names: vec![-1; parts.len()],
        parts,
    })
}
