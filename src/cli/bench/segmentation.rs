//! `uvsegnet bench segmentation`: how well each source finds the parts of a folder of labelled objects,
//! next to connected components and to one part.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::Serialize;

use super::super::weights::Weights;
use super::files::{Shard, guarded, named, stem};
use crate::contract::{Run, SegmentationSource};
use crate::device::{DeviceChoice, choose};
use crate::mesh::Surface;
use crate::sampling::{PointCloud, SampleCounts, sample};
use crate::segmentation::agreement::{Agreement, agreement};
use crate::segmentation::fusion::{CUT, fuse};
use crate::segmentation::regions::{Evidence, Heard, gather};
use crate::segmentation::{self, Network, PartLabels, network};
use crate::training::{LabelledMesh, held_out, read_labelled};

/// Arguments of `uvsegnet bench segmentation`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder: X.obj or X.glb, with X.labels.txt or X.inst.txt beside it.
    pub dir: PathBuf,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: Weights,
    /// One share of the objects, by size: I/N.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Only the objects that this list names, one a line.
    #[arg(long)]
    pub names: Option<PathBuf>,
    /// Seeds of the sampling; figures are means over them.
    #[arg(long, value_delimiter = ',', default_values_t = [0])]
    pub seeds: Vec<u64>,
    /// Where the network runs.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Write one JSON line an object here.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// What is compared.
const ARMS: [&str; 9] = [
    "one part",
    "components",
    "geometric",
    "learned",
    "shape",
    "auto",
    "auto .65",
    "auto .8",
    "auto .9",
];

/// One object's figures.
#[derive(Debug, Clone, Serialize)]
struct Row {
    id: String,
    set: String,
    category: String,
    family: String,
    triangles: usize,
    parts: usize,
    /// mIoU, Rand and parts of each arm.
    arms: BTreeMap<&'static str, (f64, f64, f64)>,
    seconds: f64,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let files = match &args.names {
        Some(list) => named(&args.dir, list)?,
        None => args.shard.of(&args.dir)?,
    };
    let device = choose(&args.device)?;
    args.weights.apply();
    let network = network(&device)?;
    let one = |file: &PathBuf| {
        let row = guarded(|| object(file, &network, &args.seeds));
        if let Err(error) = &row {
            eprintln!("{}: {error:#}", stem(file));
        }
        row.ok()
    };
    let rows: Vec<Row> = files.par_iter().filter_map(one).collect();
    if let Some(path) = &args.output {
        let mut out = std::fs::File::create(path)
            .with_context(|| format!("cannot write {}", path.display()))?;
        for row in &rows {
            writeln!(out, "{}", serde_json::to_string(row)?)?;
        }
    }
    print(&rows);
    Ok(())
}

fn object(file: &Path, network: &Network, seeds: &[u64]) -> Result<Row> {
    let run = Run::quiet();
    let mesh = read_labelled(file, &run)?;
    let surface = &mesh.surface;
    let mut arms: BTreeMap<&'static str, (f64, f64, f64)> = BTreeMap::new();
    let mut seconds = 0.0;
    for &seed in seeds {
        let start = Instant::now();
        let cloud = sample(surface, SampleCounts::dense(surface.face_count()), seed, &run)?;
        let evidence = gather(surface, &cloud, Some(network), &run)?;
        let fused = |heard, cut| fused(surface, &cloud, &evidence, network, (heard, cut));
        let auto = fused(Heard::ALL, CUT)?;
        seconds += start.elapsed().as_secs_f64() / seeds.len() as f64;
        let found = [
            ("one part", vec![0; surface.face_count()]),
            ("components", components(surface)),
            (
                "geometric",
                labels(&segmentation::segment(
                    surface,
                    &cloud,
                    SegmentationSource::Geometric,
                    &network.device,
                    &run,
                )?)?,
            ),
            ("learned", fused(Heard::LEARNED, CUT)?),
            ("shape", fused(Heard::SHAPE, CUT)?),
            ("auto", auto),
            ("auto .65", fused(Heard::ALL, 0.65)?),
            ("auto .8", fused(Heard::ALL, 0.8)?),
            ("auto .9", fused(Heard::ALL, 0.9)?),
        ];
        for (name, labels) in found {
            let Agreement { miou, rand } = agreement(&mesh.parts, &labels, &surface.areas);
            let mut parts = labels.clone();
            parts.sort_unstable();
            parts.dedup();
            let sum = arms.entry(name).or_default();
            let share = 1.0 / seeds.len() as f64;
            *sum = (sum.0 + share * miou, sum.1 + share * rand, sum.2 + share * parts.len() as f64);
        }
    }
    let mut truth = mesh.parts.clone();
    truth.sort_unstable();
    truth.dedup();
    let triangles = surface.face_count();
    let LabelledMesh { id, category, family, source, .. } = mesh;
    let set = source.split([' ', '-']).take(2).collect::<Vec<_>>().join(" ");
    Ok(Row { id, set, category, family, triangles, parts: truth.len(), arms, seconds })
}

fn fused(
    surface: &Surface,
    cloud: &PointCloud,
    evidence: &Evidence,
    network: &Network,
    how: (Heard, f64),
) -> Result<Vec<i32>> {
    let run = Run::quiet();
    let scores = fuse(surface, cloud, evidence, &network.judge, how, &run)?;
    labels(&segmentation::settle(surface, cloud, &scores, &run)?)
}

fn labels(parts: &PartLabels) -> Result<Vec<i32>> {
    Ok(parts.labels.iter().map(|&l| l as i32).collect())
}

fn components(surface: &Surface) -> Vec<i32> {
    segmentation::regions::contact::bodies(surface).iter().map(|&b| b as i32).collect()
}

fn print(rows: &[Row]) {
    let mut sets: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    rows.iter().for_each(|r| sets.entry(&r.set).or_default().push(r));
    let held: Vec<&Row> = rows.iter().filter(|r| held_out(&r.family, 1, 20)).collect();
    let mut groups: Vec<(String, Vec<&Row>)> =
        sets.into_iter().map(|(name, rows)| (name.to_owned(), rows)).collect();
    groups.push(("held-out families".into(), held));
    print!("{:<28}{:>4}{:>7}", "set", "n", "s");
    ARMS.iter().for_each(|arm| print!("{arm:>22}"));
    println!();
    for (name, rows) in groups {
        let n = rows.len().max(1) as f64;
        let seconds = rows.iter().map(|r| r.seconds).sum::<f64>() / n;
        print!("{name:<28}{:>4}{seconds:>7.2}", rows.len());
        for arm in ARMS {
            let mean = |of: fn(&(f64, f64, f64)) -> f64| {
                rows.iter().filter_map(|r| r.arms.get(arm)).map(of).sum::<f64>() / n
            };
            let (miou, rand, parts) = (mean(|a| a.0), mean(|a| a.1), mean(|a| a.2));
            print!("{:>22}", format!("{miou:.3}/{rand:.3} ({parts:.1})"));
        }
        println!();
    }
}
