//! `uvsegnet bench names`: how often the network's names of parts are right, by how sure it is of them. The
//! calibration is fitted anew on all families but those that it is then tried on.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;

use super::super::ending;
use super::super::weights::WeightFlags;
use super::files::{Shard, guarded, stem, write_rows};
use crate::contract::{ArtifactKind, Run};
use crate::device::{DeviceChoice, choose};
use crate::preview::{Curve, curves_png};
use crate::sampling::{SampleCounts, sample};
use crate::segmentation::Seen;
use crate::segmentation::fusion::{CUT, fuse};
use crate::segmentation::naming::{Naming, Platt};
use crate::segmentation::regions::{Heard, gather};
use crate::segmentation::{self, Network};
use crate::training::read_labelled;

/// Arguments of `uvsegnet bench names`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder: meshes X.glb, X.obj or the like, with X.labels.txt and X.parts.json beside each.
    pub dir: PathBuf,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: WeightFlags,
    /// One share of the objects, by size: I/N.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Where the network runs.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Write one JSON line a part here.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
    /// Draw the reliability here (PNG).
    #[arg(long, value_parser = ending::of(vec![ArtifactKind::Preview]))]
    pub plot: Option<PathBuf>,
}

/// Families are divided into so many groups; each is left out once.
const FOLDS: usize = 5;

/// Bins of confidence.
const BINS: usize = 10;

/// Least share of a part's area that one known name must have for the part to be counted.
const PURE: f64 = 0.5;

/// A part that was found, whose true name is known.
#[derive(Debug, Clone, Serialize)]
struct Row {
    object: String,
    family: String,
    /// Mean probability of the network's name.
    share: f64,
    right: bool,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let files = args.shard.of(&args.dir)?;
    let device = choose(&args.device)?;
    let network = args.weights.weights()?.network(&device)?;
    let one = |file: &PathBuf| {
        let rows = guarded(|| object(file, &network));
        if let Err(error) = &rows {
            eprintln!("{}: {error:#}", stem(file));
        }
        rows.unwrap_or_default()
    };
    let rows: Vec<Row> = files.par_iter().flat_map_iter(one).collect();
    if let Some(path) = &args.output {
        write_rows(path, &rows)?;
    }
    let families: BTreeSet<&str> = rows.iter().map(|r| r.family.as_str()).collect();
    let fold: BTreeMap<&str, usize> =
        families.iter().enumerate().map(|(i, family)| (*family, i % FOLDS)).collect();
    let fitted: Vec<Platt> = (0..FOLDS)
        .map(|left_out| {
            let others = rows.iter().filter(|r| fold[r.family.as_str()] != left_out);
            Platt::fit(&others.map(|r| (r.share, r.right)).collect::<Vec<_>>())
        })
        .collect();
    let all = Platt::fit(&rows.iter().map(|r| (r.share, r.right)).collect::<Vec<_>>());
    let (parts, right) = (rows.len(), rows.iter().filter(|r| r.right).count());
    println!(
        "{parts} parts of {} families with a known name, {right} named rightly",
        families.len()
    );
    println!("fitted on all: slope {:.4}, offset {:.4}", all.slope, all.offset);
    let ways: [(&str, Vec<(f64, bool)>); 3] = [
        ("as the network gives it", rows.iter().map(|r| (r.share, r.right)).collect()),
        (
            "calibrated, families left out",
            rows.iter()
                .map(|r| (fitted[fold[r.family.as_str()]].confidence(r.share), r.right))
                .collect(),
        ),
        ("as it ships", rows.iter().map(|r| (Platt::SHIPS.confidence(r.share), r.right)).collect()),
    ];
    let mut curves = vec![Curve { name: "ideal".into(), points: vec![(0.0, 0.0), (1.0, 1.0)] }];
    for (name, pairs) in ways {
        let bins = reliability(&pairs);
        let n = pairs.len().max(1) as f64;
        let error: f64 = bins.iter().map(|b| b.count as f64 / n * (b.mean - b.right).abs()).sum();
        println!("\n{name}: mean error {error:.3}\nconfidence  parts  right");
        for bin in bins.iter().filter(|b| b.count > 0) {
            println!("{:>10.2} {:>6} {:>6.2}", bin.mean, bin.count, bin.right);
        }
        let points = bins.iter().filter(|b| b.count > 0).map(|b| (b.mean, b.right)).collect();
        curves.push(Curve { name: name.into(), points });
    }
    if let Some(path) = &args.plot {
        let panel = ("named rightly".to_owned(), curves);
        std::fs::write(path, curves_png(&[panel], "(confidence)")?)
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Parts of about one confidence.
struct Bin {
    count: usize,
    mean: f64,
    right: f64,
}

fn reliability(pairs: &[(f64, bool)]) -> Vec<Bin> {
    let bin = |k: usize| {
        let own = |p: &&(f64, bool)| ((p.0 * BINS as f64) as usize).min(BINS - 1) == k;
        let own: Vec<&(f64, bool)> = pairs.iter().filter(own).collect();
        let n = own.len().max(1) as f64;
        Bin {
            count: own.len(),
            mean: own.iter().map(|p| p.0).sum::<f64>() / n,
            right: own.iter().filter(|p| p.1).count() as f64 / n,
        }
    };
    (0..BINS).map(bin).collect()
}

/// The parts of one object whose true name is known.
fn object(file: &Path, network: &Network) -> Result<Vec<Row>> {
    let run = Run::quiet();
    let mesh = read_labelled(file, &run)?;
    if mesh.names.iter().all(|&name| name < 0) {
        return Ok(Vec::new());
    }
    let surface = &mesh.surface;
    let cloud = sample(surface, SampleCounts::dense(surface.face_count()), 0, &run)?;
    let seen = Seen { surface, cloud: &cloud };
    let evidence = gather(seen, Some(network), &run)?;
    let scores = fuse(seen, &evidence, &network.classifier, Heard::ALL, CUT, &run)?;
    let found = segmentation::settle(surface, &cloud, &scores, &run)?;
    let names = network_names(&evidence.names, surface.face_count());
    let mut rows = Vec::new();
    for part in &found.parts {
        let faces = (0..surface.face_count()).filter(|&f| found.labels[f] == part.id);
        let (mut sums, mut truth, mut area) = (Vec::new(), BTreeMap::new(), 0.0);
        for f in faces {
            let own = names(f);
            sums.resize(own.len(), 0.0);
            sums.iter_mut().zip(own).for_each(|(s, n)| *s += surface.areas[f] * f64::from(*n));
            *truth.entry(mesh.names[f]).or_insert(0.0) += surface.areas[f];
            area += surface.areas[f];
        }
        let known = truth.iter().max_by(|a, b| f64::total_cmp(a.1, b.1));
        let known = known.filter(|(name, own)| **name >= 0 && **own > PURE * area);
        if let (Some(naming), Some((&name, _))) = (Naming::of(&sums), known) {
            rows.push(Row {
                object: mesh.id.clone(),
                family: mesh.family.clone(),
                share: naming.share,
                right: naming.name as i32 == name,
            });
        }
    }
    Ok(rows)
}

/// The network's probabilities on each face of the mesh.
fn network_names<'a>(names: &'a [f32], faces: usize) -> impl Fn(usize) -> &'a [f32] {
    let width = names.len() / faces.max(1);
    move |face| &names[face * width..(face + 1) * width]
}
