//! `uvsegnet bench segmentation`: how well each source finds the parts of a folder of labelled objects,
//! next to connected components and to one part.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use rayon::prelude::*;
use serde::Serialize;

use super::super::weights::WeightFlags;
use super::files::{Shard, guarded, named, stem, write_rows};
use crate::contract::{Run, SegmentationSource};
use crate::device::{DeviceChoice, choose};
use crate::mesh::Surface;
use crate::sampling::{SampleCounts, sample};
use crate::segmentation::Seen;
use crate::segmentation::agreement::{Agreement, agreement};
use crate::segmentation::borders::border_agreement;
use crate::segmentation::fusion::{CUT, fuse};
use crate::segmentation::regions::{Heard, gather};
use crate::segmentation::{self, Network, PartLabels, SegmentOptions, Weights};
use crate::synth::SynthKind;
use crate::training::{LabelledMesh, held_out, read_labelled};

/// Arguments of `uvsegnet bench segmentation`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder: meshes X.glb, X.obj or the like, with X.labels.txt or X.inst.txt beside each.
    pub dir: PathBuf,
    /// Which weights the network has.
    #[command(flatten)]
    pub weights: WeightFlags,
    /// One share of the objects, by size: I/N.
    #[arg(long, default_value_t)]
    pub shard: Shard,
    /// Only the objects that this list names, one a line.
    #[arg(long)]
    pub names: Option<PathBuf>,
    /// Seeds of the sampling; figures are means over them.
    #[arg(long, value_delimiter = ',', default_values_t = [0])]
    pub seeds: Vec<u64>,
    /// Seed with which the network was trained: it tells the held-out families.
    #[arg(long, default_value_t = 1)]
    pub training_seed: u64,
    /// Per cent of the families that were held out.
    #[arg(long, default_value_t = 20)]
    pub held_out_percent: u32,
    /// Where the network runs.
    #[arg(long, default_value_t)]
    pub device: DeviceChoice,
    /// Write one JSON line an object here.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// What is compared: the two baselines, each source alone, all together.
const ARMS: [&str; 7] =
    ["one part", "components", "authored", "geometric", "learned", "shape", "auto"];

/// Borders are compared within this share of the diagonal.
const REACH: f64 = 0.01;

/// Figures of one way to find parts: means over the seeds.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct Figures {
    miou: f64,
    rand: f64,
    border_f1: f64,
    parts: f64,
}

/// One object's figures.
#[derive(Debug, Clone, Serialize)]
struct Row {
    id: String,
    set: String,
    category: String,
    family: String,
    triangles: usize,
    parts: usize,
    arms: BTreeMap<&'static str, Figures>,
    seconds: f64,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let files = match &args.names {
        Some(list) => named(&args.dir, list)?,
        None => args.shard.of(&args.dir)?,
    };
    let device = choose(&args.device)?;
    let weights = args.weights.weights()?;
    let network = weights.network(&device)?;
    let one = |file: &PathBuf| {
        let row = guarded(|| object(file, &weights, &network, &args.seeds));
        if let Err(error) = &row {
            eprintln!("{}: {error:#}", stem(file));
        }
        row.ok()
    };
    let rows: Vec<Row> = files.par_iter().filter_map(one).collect();
    if let Some(path) = &args.output {
        write_rows(path, &rows)?;
    }
    print(&rows, &args);
    Ok(())
}

fn object(file: &Path, weights: &Weights, network: &Network, seeds: &[u64]) -> Result<Row> {
    let run = Run::quiet();
    let mesh = read_labelled(file, &run)?;
    let surface = &mesh.surface;
    let mut arms: BTreeMap<&'static str, Figures> = BTreeMap::new();
    let mut seconds = 0.0;
    for &seed in seeds {
        let start = Instant::now();
        let cloud = sample(surface, SampleCounts::dense(surface.face_count()), seed, &run)?;
        let seen = Seen { surface, cloud: &cloud };
        let evidence = gather(seen, Some(network), &run)?;
        let fused = |heard| -> Result<Vec<i32>> {
            let scores = fuse(seen, &evidence, &network.classifier, heard, CUT, &run)?;
            Ok(labels(&segmentation::settle(surface, &cloud, &scores, &run)?))
        };
        let auto = fused(Heard::ALL)?;
        seconds += start.elapsed().as_secs_f64() / seeds.len() as f64;
        let source = |source| -> Result<Vec<i32>> {
            let options = SegmentOptions { source, cut: CUT };
            let device = &network.device;
            let parts = segmentation::segment(surface, &cloud, &options, weights, device, &run)?;
            Ok(labels(&parts))
        };
        let found = [
            ("one part", vec![0; surface.face_count()]),
            ("components", components(surface)),
            ("authored", source(SegmentationSource::Authored)?),
            ("geometric", source(SegmentationSource::Geometric)?),
            ("learned", fused(Heard::LEARNED)?),
            ("shape", fused(Heard::SHAPE)?),
            ("auto", auto),
        ];
        for (name, labels) in found {
            let Agreement { miou, rand, .. } = agreement(&mesh.parts, &labels, &surface.areas);
            let reach = REACH * surface.diagonal;
            let border_f1 = border_agreement(surface, &mesh.parts, &labels, reach).f1;
            let parts: BTreeSet<i32> = labels.into_iter().filter(|l| *l >= 0).collect();
            let (sum, share) = (arms.entry(name).or_default(), 1.0 / seeds.len() as f64);
            sum.miou += share * miou;
            sum.rand += share * rand;
            sum.border_f1 += share * border_f1;
            sum.parts += share * parts.len() as f64;
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

fn labels(parts: &PartLabels) -> Vec<i32> {
    parts.labels.iter().map(|&l| l as i32).collect()
}

fn components(surface: &Surface) -> Vec<i32> {
    segmentation::regions::components::welded(surface).iter().map(|&b| b as i32).collect()
}

/// Print the table: sets, then what was held out of the training with the defaults, then categories
/// that the procedural generator makes or the training folders hold, and those that neither does.
fn print(rows: &[Row], args: &Args) {
    let mut groups: Vec<(String, Vec<&Row>)> = Vec::new();
    let sets: BTreeSet<&str> = rows.iter().map(|r| r.set.as_str()).collect();
    for set in sets {
        groups.push((set.to_owned(), rows.iter().filter(|r| r.set == set).collect()));
    }
    let free = |r: &&Row| r.set.starts_with("IKEA");
    let spared = |r: &&Row| held_out(&r.family, args.training_seed, args.held_out_percent);
    let learned = rows.iter().filter(free).filter(|r| !spared(r)).collect();
    groups.push(("IKEA, families learned from".into(), learned));
    groups.push((
        "IKEA, families held out".into(),
        rows.iter().filter(free).filter(spared).collect(),
    ));
    let seen = |r: &&Row| is_seen(&r.category);
    let others = || rows.iter().filter(|r| !free(r));
    groups.push(("other, categories seen".into(), others().filter(seen).collect()));
    groups.push(("other, unseen".into(), others().filter(|r| !seen(r)).collect()));
    groups.push(("all".into(), rows.iter().collect()));

    println!("mIoU / Rand / border F1 at 1 % (parts), means over objects; seeds {:?}", args.seeds);
    print!("{:<29}{:>4}{:>6}", "set", "n", "s");
    ARMS.iter().for_each(|arm| print!("{arm:>23}"));
    println!();
    for (name, rows) in groups.into_iter().filter(|g| !g.1.is_empty()) {
        let n = rows.len() as f64;
        let seconds = rows.iter().map(|r| r.seconds).sum::<f64>() / n;
        print!("{name:<29}{:>4}{seconds:>6.2}", rows.len());
        for arm in ARMS {
            let mean = |of: fn(&Figures) -> f64| {
                rows.iter().filter_map(|r| r.arms.get(arm)).map(of).sum::<f64>() / n
            };
            let (miou, rand) = (mean(|a| a.miou), mean(|a| a.rand));
            let (f1, parts) = (mean(|a| a.border_f1), mean(|a| a.parts));
            print!("{:>23}", format!("{miou:.3}/{rand:.3}/{f1:.2} ({parts:.0})"));
        }
        println!();
    }
}

/// Whether the procedural generator makes such objects.
fn is_seen(category: &str) -> bool {
    let category = category.to_ascii_lowercase();
    let alias = match category.as_str() {
        "cup" => "mug",
        "storagefurniture" | "cabinet" | "bookcase" | "shelf" | "tvunit" => "storage",
        "safe" | "dishwasher" => "appliance",
        "desk" => "table",
        "bench" => "chair",
        other => other,
    };
    SynthKind::ALL.iter().any(|kind| kind.as_str() == alias)
}
