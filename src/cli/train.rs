//! `uvsegnet train`: train the segmentation network.

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use crate::contract::Run;
use crate::device::{DeviceChoice, choose};
use crate::segmentation::Network;
use crate::segmentation::point_mae::{ModelSize, PointMae, load, save};
use crate::synth::SynthKind;
use crate::training::{self, Data, Event, Recipe, Task};

/// Arguments of `uvsegnet train`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Pre-train the encoder without labels, as a masked autoencoder.
    Pretrain(RunArgs),
    /// Learn parts and names from labelled objects.
    Finetune(RunArgs),
    /// Train the boundary classifier: with a network that is trained, between which regions parts end.
    Joins(Joins),
}

/// How to train the boundary classifier.
#[derive(Debug, clap::Args)]
struct Joins {
    /// The trained network.
    #[arg(long)]
    weights: PathBuf,
    /// Which network it is.
    #[arg(long, value_enum, default_value = "small")]
    size: ModelSize,
    /// Where the whole is written, as safetensors.
    #[arg(short, long)]
    output: PathBuf,
    /// Folders with labelled meshes.
    #[arg(long = "data")]
    folders: Vec<PathBuf>,
    /// Procedural objects of each kind; half of them fused.
    #[arg(long, default_value_t = 8)]
    procedural: usize,
    /// Beginnings of the licences under which objects of the folders may be used.
    #[arg(long = "licence", default_values_t = ["MIT".to_owned(), "CC-BY-4.0".to_owned(), "CC0".to_owned()])]
    licences: Vec<String>,
    /// Use objects of any licence. Weights trained so may not be passed on.
    #[arg(long, conflicts_with = "licences")]
    any_licence: bool,
    /// Per cent of the families that are held out, as in the network's own training.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(0..=90))]
    held_out_percent: u32,
    /// Seed, as in the network's own training.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where to run the network.
    #[arg(long, default_value_t)]
    device: DeviceChoice,
}

/// Train the boundary classifier.
fn joins(args: Joins) -> Result<()> {
    let (run, device) = (Run::quiet(), choose(&args.device)?);
    let config = args.size.config();
    let mut model = PointMae::new(&config, args.seed, &device.burn());
    load(&mut model, &config, &args.weights)?;
    let spare = |family: &str| training::held_out(family, args.seed, args.held_out_percent);
    let licences = if args.any_licence { Vec::new() } else { args.licences };
    let (mut meshes, mut left_out) = (Vec::new(), 0);
    for folder in &args.folders {
        let (own, left) = training::load_meshes(folder, &licences, spare, &run)?;
        meshes.extend(own);
        left_out += left;
    }
    let real = meshes.len();
    let made: Vec<(SynthKind, u64)> = SynthKind::ALL
        .into_iter()
        .flat_map(|kind| (0..args.procedural as u64).map(move |i| (kind, i)))
        .collect();
    // Seeds that the network has not seen.
    let make = |&(kind, i): &(SynthKind, u64)| {
        let seed = (1 << 62) + (args.seed << 20) + i;
        training::procedural_mesh(kind, seed, i % 2 == 0, &run)
    };
    let procedural: Result<Vec<_>, _> = made.par_iter().map(make).collect();
    meshes.extend(procedural?);
    eprintln!(
        "{} objects, {real} of them real; {left_out} left out for their licence",
        meshes.len()
    );
    let network = Network::new(model, config, &device);
    let known = training::know(meshes, &network, args.seed, &run)?;
    let head = training::train_joins(&known, args.seed, &device, &run, |round, pairs, loss| {
        eprintln!("round {}: {pairs} pairs, loss {loss:.4}", round + 1);
    })?;
    save(&PointMae { pairs: head, ..network.model }, &args.output, true)?;
    eprintln!("written to {}", args.output.display());
    Ok(())
}

/// How to train.
#[derive(Debug, clap::Args)]
struct RunArgs {
    /// Folder of the run: checkpoints, weights, curves. A run that stands there is taken up again.
    #[arg(short, long)]
    output: PathBuf,
    /// Folders to learn from: labelled meshes (X.glb, X.obj or the like, X.labels.txt or X.inst.txt,
    /// X.parts.json), PartNet's hierarchies (ID/result_after_merging.json) or ShapeNet-part
    /// (synsetoffset2category.txt).
    #[arg(long = "data")]
    folders: Vec<PathBuf>,
    /// Procedural objects to learn from.
    #[arg(long, default_value_t = 3000)]
    procedural: usize,
    /// Beginnings of the licences under which objects of the folders may be used.
    #[arg(long = "licence", default_values_t = ["MIT".to_owned(), "CC-BY-4.0".to_owned(), "CC0".to_owned()])]
    licences: Vec<String>,
    /// Use objects of any licence. Weights trained so may not be passed on.
    #[arg(long, conflicts_with = "licences")]
    any_licence: bool,
    /// Per cent of each batch that come from the folders.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u32).range(0..=100))]
    real_percent: u32,
    /// Per cent of the families that are held out for validation.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(0..=90))]
    held_out_percent: u32,
    /// Which network.
    #[arg(long, value_enum, default_value = "small")]
    size: ModelSize,
    /// Optimizer steps.
    #[arg(long, default_value_t = 6000, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Objects a step.
    #[arg(long, default_value_t = 8)]
    batch: usize,
    /// Highest learning rate.
    #[arg(long, default_value_t = 1e-3)]
    rate: f64,
    /// Seed of weights, data and order.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Weights to start from: safetensors, or a Point-MAE checkpoint of PyTorch.
    #[arg(long)]
    start: Option<PathBuf>,
    /// Steps between validations and checkpoints.
    #[arg(long, default_value_t = 250, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Where to train: cpu, gpu, gpu:N, auto.
    #[arg(long, default_value_t)]
    device: DeviceChoice,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let (task, run) = match args.what {
        What::Pretrain(run) => (Task::Pretrain, run),
        What::Finetune(run) => (Task::Finetune, run),
        What::Joins(args) => return joins(args),
    };
    let recipe = Recipe {
        task,
        size: run.size,
        data: Data {
            procedural: run.procedural,
            folders: run.folders,
            licences: if run.any_licence { Vec::new() } else { run.licences },
            real_percent: run.real_percent,
            held_out_percent: run.held_out_percent,
        },
        steps: run.steps,
        batch: run.batch.max(1),
        rate: run.rate,
        seed: run.seed,
        start: run.start,
        every: run.every,
    };
    let device = choose(&run.device)?;
    eprintln!("training on {}", device.description());
    let bar = ProgressBar::new(u64::from(recipe.steps)).with_style(ProgressStyle::with_template(
        "{bar:30} {pos}/{len} steps, {elapsed} gone, {eta} to go, loss {msg}",
    )?);
    let mut smooth = f64::NAN;
    let report = training::train(&recipe, &run.output, &device, &Run::quiet(), &mut |event| {
        match event {
            Event::Data(learned, real, held_out, left_out) => bar.suspend(|| {
                eprintln!(
                    "{learned} examples ({real} of them real), {held_out} held out, {left_out} left \
                     out for their licence"
                );
            }),
            Event::Step(step, loss) => {
                smooth = if smooth.is_nan() { loss } else { 0.98 * smooth + 0.02 * loss };
                bar.set_message(format!("{smooth:.4}"));
                bar.set_position(u64::from(step));
            }
            Event::Score(step, s) => bar.suspend(|| {
                eprintln!(
                    "step {step}: loss {smooth:.4}, held-out mIoU {:.3}, Rand {:.3}, names {:.3}",
                    s.miou, s.rand, s.names
                );
            }),
        }
    })?;
    bar.finish_and_clear();
    eprintln!(
        "{} steps in {:.0} s, loss {:.4}; weights in {}",
        report.steps,
        report.seconds,
        report.loss,
        run.output.join("model.safetensors").display()
    );
    Ok(())
}
