//! Learning to judge pairs of regions (`segmentation::regions`): objects whose parts are known are
//! agglomerated with the judge as it stands; every pair it would join is an example, and where the
//! truth says no, it is not joined (Nunez-Iglesias et al. 2013, doi:10.1371/journal.pone.0071715, "active
//! learning" of agglomeration). After each round the judge is trained on all rounds' examples.

use std::collections::HashMap;

use burn::module::Module;
use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::activation::log_sigmoid;
use burn::tensor::{Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::folder::LabelledMesh;
use super::trainer::TrainError;
use crate::contract::{Canceled, Run};
use crate::device::Device;
use crate::sampling::{PointCloud, SampleCounts, sample};
use crate::segmentation::Network;
use crate::segmentation::point_mae::PairHead;
use crate::segmentation::regions::{
    Evidence, FEATURES, Heard, Judge, LEARNED, Opinion, Region, RegionGraph, agglomerate,
    features::{at, features},
    gather, prepare,
};
use crate::segmentation::sheets::Outside;

/// Rounds of agglomeration and training.
const ROUNDS: usize = 3;

/// Optimizer steps of a round.
const STEPS: usize = 1500;

/// Pairs a step.
const BATCH: usize = 2048;

/// Learning rate at first.
const RATE: f64 = 3e-3;

/// How often a kind of evidence is withheld, so that each can do without the others.
const DEAF: f64 = 0.12;

/// How often the network's evidence is that of another pair: on what it has not seen it errs, and the
/// judge, who meets it on what it was trained on, is not to believe it blindly.
const CONFUSED: f64 = 0.03;

/// How often a single number is withheld: no judgement is to hang on one.
const DROPPED: f64 = 0.1;

/// How far the judge goes astray while it learns: up to this probability that a part ends.
const ASTRAY: f64 = 0.5;

/// A refused pair is an example again when the smaller region has grown so much.
const GROWN: f64 = 1.5;

/// An object with its evidence, and its parts.
pub struct Known {
    mesh: LabelledMesh,
    evidence: Evidence,
    cloud: PointCloud,
}

/// A pair that was judged.
#[derive(Debug, Clone, Copy)]
struct Pair {
    features: [f32; FEATURES],
    is_boundary: bool,
    /// How often it is drawn.
    weight: f64,
}

/// Gather the evidence of objects with a trained network.
pub fn know(
    meshes: Vec<LabelledMesh>,
    network: &Network,
    seed: u64,
    run: &Run,
) -> Result<Vec<Known>, Canceled> {
    let one = |mut mesh: LabelledMesh| {
        let seen = Outside::of_surface(&mesh.surface).surface.into_owned();
        mesh.surface = seen;
        let counts = SampleCounts::dense(mesh.surface.face_count());
        let cloud = sample(&mesh.surface, counts, seed, run)?;
        let evidence = gather(&Outside::of(&mesh.surface, &cloud), Some(network), run)?;
        Ok(Known { mesh, evidence, cloud })
    };
    meshes.into_par_iter().map(one).collect()
}

/// Train a judge on these objects; `watch` is told each round's pairs and loss.
pub fn train_joins(
    known: &[Known],
    seed: u64,
    device: &Device,
    run: &Run,
    mut watch: impl FnMut(usize, usize, f64),
) -> Result<PairHead, TrainError> {
    let mut head = PairHead::seeded(seed, &device.autodiff());
    let mut pairs: Vec<Pair> = Vec::new();
    for round in 0..ROUNDS {
        let judge = (round > 0).then(|| Judge::new(&head.valid()));
        let found: Result<Vec<Vec<Pair>>, Canceled> =
            known.par_iter().map(|k| judged(k, judge.as_ref(), false, run)).collect();
        pairs.extend(found?.into_iter().flatten());
        if judge.is_some() {
            let found: Result<Vec<Vec<Pair>>, Canceled> =
                known.par_iter().map(|k| judged(k, judge.as_ref(), true, run)).collect();
            pairs.extend(found?.into_iter().flatten());
        }
        let (trained, loss) = fit(head, &pairs, seed + round as u64, device, run)?;
        head = trained;
        watch(round, pairs.len(), loss);
    }
    Ok(head.valid())
}

/// The pairs that are met when an object is agglomerated without a wrong join; or, `astray`, with those
/// that the judge makes, up to where it would stop and once around what is left.
fn judged(
    known: &Known,
    judge: Option<&Judge>,
    astray: bool,
    run: &Run,
) -> Result<Vec<Pair>, Canceled> {
    let truth = Some(known.mesh.parts.as_slice());
    let prepared = prepare(&known.mesh.surface, &known.cloud, &known.evidence, truth, run)?;
    let mut graph = prepared.graph;
    let mut pairs = Vec::new();
    let areas = part_areas(&graph);
    // A pair that was refused comes up again whenever one of the two grows; it counts again once the
    // smaller has grown by half.
    let mut refused: HashMap<(u32, u32), f64> = HashMap::new();
    // Before there is a judge: steps of the embedding, bays, shells, and small borders last.
    let first = |x: &[f32; FEATURES]| {
        let speaks = [at::APART, at::STEP, at::BAY, at::ACROSS_SHELLS].map(|i| x[i]);
        f64::from(speaks.iter().sum::<f32>()) + 0.1 * f64::from(x[at::SMALL])
    };
    let boundary = |x: &[f32; FEATURES]| match judge {
        Some(judge) => judge.boundary(x, Heard::ALL),
        None => first(x),
    };
    let until = if astray { ASTRAY } else { f64::INFINITY };
    agglomerate(&mut graph, &boundary, until, run, |graph, a, b, x| {
        let (Some(r), Some(s)) = (graph.region(a), graph.region(b)) else { return false };
        let Some((is_boundary, weight)) = lesson(&areas, r, s) else { return true };
        if is_boundary {
            let last = refused.entry((a, b)).or_default();
            let smaller = r.area.min(s.area);
            if smaller < GROWN * *last {
                return false;
            }
            *last = smaller;
        }
        pairs.push(Pair { features: *x, is_boundary, weight });
        !is_boundary || astray
    })?;
    if astray {
        let left = (0u32..).zip(&graph.borders);
        for (a, b, border) in left.flat_map(|(a, n)| n.range(a..).map(move |(&b, x)| (a, b, x))) {
            let (Some(r), Some(s)) = (graph.region(a), graph.region(b)) else { continue };
            let Some((is_boundary, weight)) = lesson(&areas, r, s) else { continue };
            pairs.push(Pair { features: features(&graph, r, s, border), is_boundary, weight });
        }
    }
    Ok(pairs)
}

/// Area of each true part.
fn part_areas(graph: &RegionGraph) -> HashMap<i32, f64> {
    let mut areas = HashMap::new();
    for (&part, area) in graph.regions.iter().flatten().flat_map(|r| &r.truth) {
        *areas.entry(part).or_default() += area;
    }
    areas
}

/// Whether a part ends between two regions, and how much it matters: joining them wrongly, or not,
/// spoils their parts in the share that the smaller has of its own, whatever the size of that part. The
/// root, for much of it lies in few pairs.
fn lesson(areas: &HashMap<i32, f64>, r: &Region, s: &Region) -> Option<(bool, f64)> {
    let (p, q) = (r.majority()?, s.majority()?);
    let (small, part) = if r.area <= s.area { (r.area, p.0) } else { (s.area, q.0) };
    let of_part = small / areas.get(&part).copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
    // A region of two parts teaches little.
    let clear = (p.1.min(q.1) * 2.0 - 1.0).max(0.0);
    Some((p.0 != q.0, clear * of_part.min(1.0).sqrt()))
}

/// Descend the cross entropy of pairs drawn by their weight.
fn fit(
    mut head: PairHead,
    pairs: &[Pair],
    seed: u64,
    device: &Device,
    run: &Run,
) -> Result<(PairHead, f64), TrainError> {
    let tensors = device.autodiff();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut optimizer = AdamWConfig::new().with_weight_decay(1e-3).init();
    let mut recent = f64::NAN;
    let sums: Vec<f64> = pairs
        .iter()
        .scan(0.0, |sum, p| {
            *sum += p.weight;
            Some(*sum)
        })
        .collect();
    let total = sums.last().copied().filter(|t| *t > 0.0).ok_or(TrainError::NoExamples)?;
    for step in 0..STEPS {
        run.cancel.check()?;
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for _ in 0..BATCH {
            let mut draw = || {
                let at = rng.random_range(0.0..1.0) * total;
                pairs[sums.partition_point(|&s| s <= at).min(pairs.len() - 1)]
            };
            let (pair, other) = (draw(), draw());
            let mut features = pair.features;
            if rng.random_bool(CONFUSED) {
                features[LEARNED].copy_from_slice(&other.features[LEARNED]);
            }
            let mut hears = || !rng.random_bool(DEAF);
            let heard = Heard { learned: hears(), authored: hears(), shape: hears() };
            heard.mask(&mut features);
            for value in &mut features {
                if rng.random_bool(DROPPED) {
                    *value = 0.0;
                }
            }
            x.extend(features);
            y.push(if pair.is_boundary { 1.0_f32 } else { -1.0 });
        }
        let signs = Tensor::from_data(TensorData::new(y, [1, BATCH, 1]), &tensors);
        let x = Tensor::from_data(TensorData::new(x, [1, BATCH, FEATURES]), &tensors);
        // −log σ(±logit): the sign is that of a pair's kind.
        let loss = -log_sigmoid(head.forward(x, device) * signs).mean();
        let value = f64::from(loss.clone().into_scalar::<f32>());
        recent = if recent.is_nan() { value } else { 0.98 * recent + 0.02 * value };
        let gradients = GradientsParams::from_grads(loss.backward(), &head);
        let rate = RATE * 0.5 * (1.0 + (std::f64::consts::PI * step as f64 / STEPS as f64).cos());
        head = optimizer.step(rate.max(1e-5), head, gradients);
    }
    Ok((head, recent))
}
