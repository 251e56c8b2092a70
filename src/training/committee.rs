//! Fitting the boundary classifier to pairs of regions: a committee of small networks, each of which sees
//! the objects in shares of its own (bagging, Breiman 1996, doi:10.1007/BF00058655), and whose logits are averaged. One
//! network alone learns the procedural objects' own ways: trained twice, it scored up to 0.1 apart.

use burn::module::Module;
use burn::optim::{AdamWConfig, GradientsParams};
use burn::tensor::activation::log_sigmoid;
use burn::tensor::{Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::trainer::TrainError;
use crate::contract::Run;
use crate::device::Device;
use crate::segmentation::point_mae::{PAIR_HIDDEN, PairHead};
use crate::segmentation::regions::{FEATURES, Heard, LEARNED};

/// Networks of the committee; together they have [`PAIR_HIDDEN`] units a layer.
const MEMBERS: usize = 4;

/// Optimizer steps of each.
const STEPS: usize = 2000;

/// Pairs a step.
const BATCH: usize = 2048;

/// Learning rate at first.
const RATE: f64 = 3e-3;

/// How often a kind of evidence is withheld, so that each can do without the others.
const DEAF: f64 = 0.12;

/// How often the network's evidence is that of another pair: on what it has not seen it errs, and the
/// classifier, which meets it on what it was trained on, is not to believe it blindly.
const CONFUSED: f64 = 0.03;

/// How often a single number is withheld: no answer is to hang on one.
const DROPPED: f64 = 0.1;

/// An object is seen up to so many times as often as it comes; in the mean once.
const MOST_SHARES: f64 = 2.0;

/// A pair of regions of which the truth is known.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// What speaks for and against a boundary.
    pub features: [f32; FEATURES],
    /// Whether a part ends there.
    pub is_boundary: bool,
    /// How often it is drawn.
    pub weight: f64,
    /// Number of its object.
    pub object: u32,
}

/// Train a committee on pairs of so many objects. Returns it as one head, and its members' mean loss.
pub fn fit(
    pairs: &[Pair],
    objects: usize,
    seed: u64,
    device: &Device,
    run: &Run,
) -> Result<(PairHead, f64), TrainError> {
    let train = |k: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(k as u64);
        member(pairs, objects, rng, device, run)
    };
    let members: Result<Vec<(PairHead, f64)>, TrainError> =
        (0..MEMBERS).into_par_iter().map(train).collect();
    let (heads, losses): (Vec<PairHead>, Vec<f64>) = members?.into_iter().unzip();
    let loss = losses.iter().sum::<f64>() / MEMBERS as f64;
    Ok((PairHead::committee(&heads, &device.burn()), loss))
}

/// Descend the cross entropy of pairs drawn by their weight and by their object's share.
fn member(
    pairs: &[Pair],
    objects: usize,
    mut rng: ChaCha8Rng,
    device: &Device,
    run: &Run,
) -> Result<(PairHead, f64), TrainError> {
    let tensors = device.autodiff();
    let shares: Vec<f64> = (0..objects).map(|_| rng.random_range(0.0..MOST_SHARES)).collect();
    let mut head = PairHead::seeded(rng.random(), PAIR_HIDDEN / MEMBERS, &tensors);
    let mut optimizer = AdamWConfig::new().with_weight_decay(1e-3).init();
    let mut recent = f64::NAN;
    let sums: Vec<f64> = pairs
        .iter()
        .scan(0.0, |sum, p| {
            *sum += p.weight * shares[p.object as usize];
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
    Ok((head.valid(), recent))
}
