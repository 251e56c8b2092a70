//! `uvsegnet synth`: make labelled objects: one file, or a folder to train on or to measure with; or
//! one closed body of any size, without parts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Error, Result, ensure};
use rayon::prelude::*;
use serde_json::json;

use super::ending;
use crate::contract::ArtifactKind;
use crate::synth::{self, BodyKind, BodyStyle, NoiseKind};
use crate::synth::{SynthKind, SynthObject, SynthStyle, SynthVariant};

/// Arguments of `uvsegnet synth`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What to make; several kinds, in turn, with --count.
    #[arg(value_enum, required_unless_present = "body")]
    pub kinds: Vec<SynthKind>,
    /// Make a closed manifold body instead: one mesh, without parts.
    #[arg(long, value_enum, conflicts_with_all = ["kinds", "variant", "labels", "count"])]
    pub body: Option<BodyKind>,
    /// Which one: the same seed always gives the same object. With --body, the seed of the noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How the parts stand in the file.
    #[arg(long, value_enum, default_value_t)]
    pub variant: SynthVariant,
    /// About how many triangles, 200 to 200,000; 1,000 by default. With --body, 5,000 to 2,000,000,
    /// never exceeded; 20,000 by default.
    #[arg(long, value_parser = clap::value_parser!(u32).range(200..=2_000_000))]
    pub triangles: Option<u32>,
    // Required and forbidden both: clap waives what is required where that would be refused.
    /// Roughen the body: the standard deviation of Gaussian noise, in mean edge lengths.
    #[arg(long, default_value_t = 0.0, requires = "body", conflicts_with = "kinds")]
    pub noise: f64,
    /// Which way the noise moves a vertex.
    #[arg(long, value_enum, default_value_t, requires = "body", conflicts_with = "kinds")]
    pub noise_kind: NoiseKind,
    /// How many of the body stand side by side in the mesh; they share the triangles.
    #[arg(long, default_value_t = 1, requires = "body", conflicts_with = "kinds")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=500))]
    pub copies: u32,
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

/// Most triangles of an object.
const MOST: u32 = 200_000;
/// Fewest triangles of a body.
const FEWEST: u32 = 5_000;
/// Most noise, in mean edge lengths: beyond it nothing is left of the surface.
const LOUDEST: f64 = 2.0;

/// Run it.
pub fn run(args: Args) -> Result<()> {
    if let Some(kind) = args.body {
        return write_body(kind, args);
    }
    let triangles = args.triangles.unwrap_or(1000);
    ensure!(
        triangles <= MOST,
        "--triangles {triangles} is above {MOST}: give fewer, or make a --body, which takes more"
    );
    let style = SynthStyle { variant: args.variant, triangles: triangles as usize };
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

fn write_body(kind: BodyKind, args: Args) -> Result<()> {
    let (triangles, copies, noise) = (args.triangles.unwrap_or(20_000), args.copies, args.noise);
    ensure!(
        triangles >= FEWEST,
        "--triangles {triangles} is below {FEWEST}, the fewest that show the shape of a body"
    );
    let fewest = kind.fewest();
    ensure!(
        (triangles / copies) as usize >= fewest,
        "{copies} copies share {triangles} triangles, but each needs {fewest}: \
         give more --triangles or fewer --copies"
    );
    ensure!(
        (0.0..=LOUDEST).contains(&noise),
        "--noise {noise} is not between 0 and {LOUDEST} mean edge lengths"
    );
    let style = BodyStyle {
        triangles: triangles as usize,
        noise,
        noise_kind: args.noise_kind,
        seed: args.seed,
        copies: copies as usize,
    };
    let name = kind.as_str();
    let output = args.output.unwrap_or_else(|| format!("{name}.glb").into());
    let output = ending::checked(output, &[ArtifactKind::Model]).map_err(Error::msg)?;
    let body = synth::body::make(kind, style);
    write(&output, &body.glb(name))?;
    let triangles = body.triangles.len();
    let bodies = if copies == 1 { "body" } else { "bodies" };
    eprintln!("{}: {triangles} triangles, {copies} {bodies}", output.display());
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

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn ran(line: &str) -> Result<(), String> {
        let words = std::iter::once("synth").chain(line.split_whitespace());
        let line = <Line as clap::Parser>::try_parse_from(words).map_err(|e| e.to_string())?;
        run(line.args).map_err(|e| e.to_string())
    }

    #[test]
    fn a_body_and_an_object_do_not_mix() {
        for (line, says) in [
            ("", "required"),
            ("chair --body hand", "cannot be used with"),
            ("chair --noise 0.1", "cannot be used with"),
            ("chair --copies 2", "cannot be used with"),
            ("--body hand --count 3", "cannot be used with"),
            ("--body hand --variant fused", "cannot be used with"),
            ("--body hand --triangles 4999", "below 5000"),
            ("--body hand --triangles 5000 --copies 5", "each needs 1500"),
            ("--body hand --noise nan", "not between"),
            ("chair --triangles 200001", "above 200000"),
        ] {
            let refused = ran(line).unwrap_err();
            assert!(refused.contains(says), "{line}: {refused}");
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("body.glb");
        ran(&format!("--body genus3 --noise 0.1 --copies 2 -o {}", file.display())).unwrap();
        assert!(gltf::Gltf::from_slice(&std::fs::read(&file).unwrap()).is_ok());
    }

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
