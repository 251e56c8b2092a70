//! The loop of pre-training and of fine-tuning. Everything a step draws comes from the seed and the
//! step's number, so a run that is taken up again goes on as if it had never stopped.

use std::path::Path;
use std::time::Instant;

use burn::grad_clipping::GradientClippingConfig;
use burn::module::Module;
use burn::optim::{AdamWConfig, GradientsParams, ModuleOptimizer};
use burn::tensor::Tensor;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::augment::{View, augmented};
use super::checkpoint::{Folder, State};
use super::data_sets::load_examples;
use super::example::Example;
use super::folder::FolderError;
use super::loss::{Targets, loss};
use super::procedural::{ProceduralStyle, example};
use super::recipe::{Recipe, Task};
use super::validation::{Score, score};
use crate::contract::{Canceled, Run};
use crate::device::{Device, Seeded};
use crate::segmentation::point_mae::{
    Autoencoder, Decoder, Loaded, PointMae, PointMaeConfig, WeightsError, load,
};

/// Why a training run ended.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TrainError {
    /// It was asked to.
    #[error(transparent)]
    Canceled(#[from] Canceled),
    /// A labelled folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// Weights to start from.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A file of the run.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The run's folder holds another run.
    #[error("{0} is of another recipe: give the same arguments, or another folder")]
    OtherRecipe(String),
    /// Nothing to learn from.
    #[error("there are no examples: give --procedural or a folder with labelled meshes")]
    NoExamples,
    /// The loss is no number any more.
    #[error("the loss is no number at step {0}: lower --rate")]
    Diverged(u32),
}

/// How a run went.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Steps taken.
    pub steps: u32,
    /// Mean loss of the last hundredth of the steps.
    pub loss: f64,
    /// The last score, of fine-tuning with held-out families.
    pub score: Option<Score>,
    /// Seconds, over all the times it was taken up.
    pub seconds: f64,
}

/// What a watcher is told.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// The data are there: examples to learn from, of them real, held out, left out for their licence.
    Data(usize, usize, usize, usize),
    /// A step is done: its number, its loss.
    Step(u32, f64),
    /// A validation: after that many steps.
    Score(u32, Score),
}

/// Examples to learn from, and those held out.
struct Examples {
    procedural: Vec<Example>,
    real: Vec<Example>,
    held_out: Vec<Example>,
    left_out: usize,
}

/// Train by a recipe in a folder; a run that stands there is taken up again.
pub fn train(
    recipe: &Recipe,
    folder: &Path,
    device: &Device,
    run: &Run,
    watch: &mut dyn FnMut(Event),
) -> Result<Report, TrainError> {
    let (folder, state) = Folder::open(folder, recipe)?;
    let examples = gather(recipe, run)?;
    if examples.procedural.is_empty() && examples.real.is_empty() {
        return Err(TrainError::NoExamples);
    }
    let learned = examples.procedural.len() + examples.real.len();
    watch(Event::Data(learned, examples.real.len(), examples.held_out.len(), examples.left_out));
    let config = recipe.size.config();
    let tensors = device.autodiff();
    let mut network = PointMae::new(&config, recipe.seed, &tensors);
    if let Some(start) = &recipe.start {
        let found = load(&mut network, &config, start)?;
        tracing::info!(from = %start.display(), whole = found == Loaded::Whole, "weights loaded");
    }
    let session = Session { recipe, config, folder, device, run, examples };
    match recipe.task {
        Task::Finetune => session.go(network, state, watch, Session::parts_loss, |s, m| {
            Some(score(&m.valid(), &s.config, &s.examples.held_out, s.device))
        }),
        Task::Pretrain => {
            let decoder = Decoder::new(&config, recipe.seed.wrapping_add(1), &tensors);
            let whole = Autoencoder { encoder: network.encoder, decoder };
            session.go(whole, state, watch, Session::hidden_loss, |_, _| None)
        }
    }
}

/// Make and read the examples.
fn gather(recipe: &Recipe, run: &Run) -> Result<Examples, TrainError> {
    let data = &recipe.data;
    let styles = ProceduralStyle::series(data.procedural, recipe.seed << 32);
    let made: Result<Vec<Example>, Canceled> =
        styles.par_iter().map(|style| example(*style, run)).collect();
    let mut procedural = made?;
    let (mut real, mut left_out) = (Vec::new(), 0);
    for folder in &data.folders {
        let (examples, left) = load_examples(folder, &data.licences, recipe.seed, run)?;
        real.extend(examples);
        left_out += left;
    }
    let is_held_out = |e: &Example| held_out(&e.family, recipe.seed, data.held_out_percent);
    let (out, real) = real.into_iter().partition(is_held_out);
    let mut held_out: Vec<Example> = out;
    if data.folders.is_empty() {
        let (out, learned) = procedural.into_iter().partition(is_held_out);
        (held_out, procedural) = (out, learned);
        // Validation is not to take longer than training.
        held_out.truncate(64);
    }
    Ok(Examples { procedural, real, held_out, left_out })
}

/// Whether a family is held out: by a hash of its name, so that adding objects moves no other.
pub fn held_out(family: &str, seed: u64, percent: u32) -> bool {
    use sha2::{Digest, Sha256};
    let digest = Sha256::digest(format!("{seed} {family}").as_bytes());
    let number = digest.iter().take(4).fold(0u32, |n, b| n << 8 | u32::from(*b));
    u64::from(number) * 100 < u64::from(percent) << 32
}

/// A run under way.
struct Session<'a> {
    recipe: &'a Recipe,
    config: PointMaeConfig,
    folder: Folder,
    device: &'a Device,
    run: &'a Run,
    examples: Examples,
}

impl Session<'_> {
    /// The loop: views, loss, step, and now and then a validation and a checkpoint.
    fn go<M: Module>(
        self,
        mut model: M,
        state: Option<State>,
        watch: &mut dyn FnMut(Event),
        loss_of: impl Fn(&Self, &M, &[View], u32) -> Tensor<1>,
        score_of: impl Fn(&Self, &M) -> Option<Score>,
    ) -> Result<Report, TrainError> {
        let mut optimizer = self.optimizer();
        let mut state = match state {
            Some(state) if state.step > 0 => {
                optimizer = self.folder.restore(&mut model, optimizer)?;
                state
            }
            _ => State::default(),
        };
        let (before, start) = (state.seconds, Instant::now());
        while state.step < self.recipe.steps {
            self.run.cancel.check()?;
            let step = state.step;
            let loss = loss_of(&self, &model, &self.views(step), step);
            let value = f64::from(loss.clone().into_scalar::<f32>());
            if !value.is_finite() {
                return Err(TrainError::Diverged(step));
            }
            let gradients = GradientsParams::from_grads(loss.backward(), &model);
            model = optimizer.step(self.recipe.rate_at(step), model, gradients);
            state.step += 1;
            state.losses.push(value);
            watch(Event::Step(state.step, value));
            if state.step.is_multiple_of(self.recipe.every) || state.step == self.recipe.steps {
                let score = score_of(&self, &model);
                let merit = score.map_or(-recent(&state.losses), |s| s.miou);
                let is_best = state.best.is_none_or(|best| merit > best);
                if is_best {
                    state.best = Some(merit);
                }
                if let Some(score) = score {
                    state.scores.push((state.step, score));
                    watch(Event::Score(state.step, score));
                }
                state.seconds = before + start.elapsed().as_secs_f64();
                self.folder.save(&model, &optimizer, &state, is_best)?;
            }
        }
        let score = state.scores.last().map(|s| s.1);
        let (steps, seconds) = (state.step, state.seconds);
        Ok(Report { steps, loss: recent(&state.losses), score, seconds })
    }

    fn optimizer(&self) -> ModuleOptimizer {
        AdamWConfig::new()
            .with_weight_decay(0.05)
            .with_grad_clipping(Some(GradientClippingConfig::Norm(1.0)))
            .init()
    }

    /// The views of a step.
    fn views(&self, step: u32) -> Vec<View> {
        let Data { procedural, real } = Data::of(&self.examples);
        let mut rng = ChaCha8Rng::seed_from_u64(self.recipe.seed);
        rng.set_stream(1 + u64::from(step));
        let share = f64::from(self.recipe.data.real_percent) / 100.0;
        let pick = |rng: &mut ChaCha8Rng| {
            let from_real = procedural.is_empty() || (!real.is_empty() && rng.random_bool(share));
            let from = if from_real { real } else { procedural };
            &from[rng.random_range(0..from.len())]
        };
        (0..self.recipe.batch)
            .map(|_| {
                let example = pick(&mut rng);
                augmented(example, &mut rng)
            })
            .collect()
    }

    fn parts_loss(&self, model: &PointMae, views: &[View], _: u32) -> Tensor<1> {
        let tensors = self.device.autodiff();
        let clouds: Vec<_> = views.iter().map(|v| v.cloud.clone()).collect();
        let features = model.forward(&self.config, &clouds, &clouds, self.device, &tensors);
        loss(&features, &Targets::new(views, &tensors))
    }

    fn hidden_loss(&self, model: &Autoencoder, views: &[View], step: u32) -> Tensor<1> {
        let clouds: Vec<_> = views.iter().map(|v| v.cloud.clone()).collect();
        let mut rng = Seeded::new(self.recipe.seed, (1 << 40) + u64::from(step));
        model.loss(&self.config, &clouds, &mut rng, self.device, &self.device.autodiff())
    }
}

/// What is learned from.
struct Data<'a> {
    procedural: &'a [Example],
    real: &'a [Example],
}

impl<'a> Data<'a> {
    fn of(examples: &'a Examples) -> Self {
        Self { procedural: &examples.procedural, real: &examples.real }
    }
}

/// Mean of the last hundredth.
fn recent(losses: &[f64]) -> f64 {
    let count = (losses.len() / 100).max(1).min(losses.len());
    losses[losses.len() - count..].iter().sum::<f64>() / count.max(1) as f64
}
