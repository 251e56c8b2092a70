//! `uvsegnet synth`: make labelled objects: one file, or a folder to train on or to measure with.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, ensure};
use rayon::prelude::*;
use serde_json::json;

use super::ending;
use crate::contract::ArtifactKind;
use crate::synth::{self, SynthKind, SynthObject, SynthStyle, SynthVariant};

/// Arguments of `uvsegnet synth`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What to make; several kinds, in turn, with --count.
    #[arg(value_enum, required = true)]
    pub kinds: Vec<SynthKind>,
    /// Which one: the same seed always gives the same object.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How the parts stand in the file.
    #[arg(long, value_enum, default_value_t)]
    pub variant: SynthVariant,
    /// About how many triangles.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(200..=200_000))]
    pub triangles: u32,
    /// The GLB file to write; <KIND>.glb by default. With --count, the folder.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Write the part of each face here, one number a line.
    #[arg(long, conflicts_with = "count", value_parser = ending::of(vec![ArtifactKind::Labels]))]
    pub labels: Option<PathBuf>,
    /// Make this many, from --seed on, as a labelled folder: X.glb, X.labels.txt, X.parts.json each.
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub count: Option<u64>,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let style = SynthStyle { variant: args.variant, triangles: args.triangles as usize };
    if let Some(count) = args.count {
        let folder = args.output.unwrap_or_else(|| "synth".into());
        return write_folder(&folder, &args.kinds, args.seed, count, style);
    }
    ensure!(args.kinds.len() == 1, "one kind makes one file: give --count for a folder of several");
    let kind = args.kinds[0];
    let output = args.output.unwrap_or_else(|| format!("{}.glb", kind.as_str()).into());
    let output = ending::checked(output, &[ArtifactKind::Model]).map_err(Error::msg)?;
    let object = synth::make(kind, args.seed, style);
    write(&output, &object.glb())?;
    if let Some(labels) = &args.labels {
        write(labels, object.labels_text().as_bytes())?;
    }
    let (triangles, parts) = (object.triangle_count(), object.parts.len());
    eprintln!("{}: {triangles} triangles, {parts} parts", output.display());
    Ok(())
}

fn write_folder(
    folder: &Path,
    kinds: &[SynthKind],
    seed: u64,
    count: u64,
    style: SynthStyle,
) -> Result<()> {
    let last = seed.checked_add(count - 1);
    ensure!(
        last.is_some(),
        "--seed {seed} and {count} more is above {}: give a smaller seed",
        u64::MAX
    );
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    (0..count).into_par_iter().try_for_each(|i| {
        let (kind, seed) = (kinds[(i % kinds.len() as u64) as usize], seed + i);
        let object = synth::make(kind, seed, style);
        let stem = folder.join(format!("{}_{seed}", kind.as_str()));
        write(&stem.with_extension("glb"), &object.glb())?;
        write(&stem.with_extension("labels.txt"), object.labels_text().as_bytes())?;
        write(&stem.with_extension("parts.json"), about(&object, seed).as_bytes())
    })?;
    eprintln!("{count} objects in {}", folder.display());
    Ok(())
}

/// What stands beside a labelled mesh.
fn about(object: &SynthObject, seed: u64) -> String {
    let names: BTreeMap<String, &str> =
        (0..).zip(&object.parts).map(|(i, p)| (i.to_string(), p.coarse_name())).collect();
    let kind = object.kind.as_str();
    json!({
        "category": kind,
        "family": format!("{kind}_{seed}"),
        "source": concat!("uvsegnet synth ", env!("CARGO_PKG_VERSION")),
        "licence": "CC0-1.0",
        "labels": names,
    })
    .to_string()
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::Run;
    use crate::training::load_meshes;

    #[test]
    fn a_folder_of_objects_can_be_learned_from() {
        let folder = tempfile::tempdir().unwrap();
        let style = SynthStyle { variant: SynthVariant::SingleMesh, triangles: 400 };
        write_folder(folder.path(), &[SynthKind::Mug, SynthKind::Knife], 5, 3, style).unwrap();
        let licences = ["CC0".to_owned()];
        let (meshes, _) = load_meshes(folder.path(), &licences, |_| false, &Run::quiet()).unwrap();
        let families: Vec<&str> = meshes.iter().map(|m| m.family.as_str()).collect();
        assert_eq!(families, ["knife_6", "mug_5", "mug_7"]);
        for mesh in meshes {
            let parts: std::collections::BTreeSet<i32> = mesh.parts.iter().copied().collect();
            assert!(parts.len() > 1 && mesh.names.iter().any(|n| *n >= 0), "{}", mesh.id);
        }
    }
}
