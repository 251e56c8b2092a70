//! Labelled meshes to agglomerate: those of folders, and procedural ones in every way that an object may
//! stand in a file.

use std::path::PathBuf;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::folder::{self, LabelledMesh};
use super::procedural::{STRETCH, stretch_parts};
use super::structure::{Structure, scene};
use super::trainer::TrainError;
use super::weather::weather;
use crate::contract::Run;
use crate::mesh;
use crate::synth::{self, SynthKind};

/// Labelled meshes of folders, without the held-out families if those are to be spared.
pub fn meshes_of(
    folders: &[PathBuf],
    licences: &[String],
    spare: impl Fn(&str) -> bool + Sync,
    run: &Run,
) -> Result<Vec<LabelledMesh>, TrainError> {
    let mut all = Vec::new();
    for folder in folders {
        let files = folder::meshes(folder)?;
        let one = |file: &PathBuf| -> Result<Option<LabelledMesh>, TrainError> {
            if !folder::is_allowed(file, licences)? {
                return Ok(None);
            }
            let mesh = folder::read(file, run)?;
            Ok((!spare(&mesh.family)).then_some(mesh))
        };
        let read: Result<Vec<Option<LabelledMesh>>, TrainError> =
            files.par_iter().map(one).collect();
        all.extend(read?.into_iter().flatten());
    }
    Ok(all)
}

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
        let split = if structure == Structure::Soup { Structure::Soup } else { Structure::Solids };
        let mut object = synth::fused(object, rng.random_range(2000..9000));
        if let Some(body) = &mut object.fused {
            weather(body, &mut rng);
        }
        (object, split)
    } else {
        (object, structure)
    };
    let surface = mesh::condition(&scene(&object, structure), run)?;
    let parts: Vec<i32> = object.labels().iter().map(|&l| l as i32).collect();
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
