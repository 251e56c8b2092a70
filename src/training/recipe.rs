//! What is trained, on what, for how long: all that a run depends on. The same recipe on the same data
//! and device gives the same weights.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::segmentation::point_mae::ModelSize;

/// What is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Task {
    /// The encoder, without labels (masked autoencoder).
    Pretrain,
    /// Parts and names.
    Finetune,
}

/// Where examples come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Data {
    /// Procedural objects.
    pub procedural: usize,
    /// Labelled folders.
    pub folders: Vec<PathBuf>,
    /// Beginnings of the licences under which objects of the folders may be used; none for all.
    pub licences: Vec<String>,
    /// How many per cent of a batch come from the folders.
    pub real_percent: u32,
    /// How many per cent of the families are held out for validation.
    pub held_out_percent: u32,
}

/// A training run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// What is learned.
    pub task: Task,
    /// Which network.
    pub size: ModelSize,
    /// On what.
    pub data: Data,
    /// Optimizer steps.
    pub steps: u32,
    /// Objects a step.
    pub batch: usize,
    /// Learning rate after the warm-up; it falls along half a cosine.
    pub rate: f64,
    /// Seed of weights, data and order.
    pub seed: u64,
    /// Weights to start from.
    pub start: Option<PathBuf>,
    /// Steps between validations and checkpoints.
    pub every: u32,
}

/// Share of the steps in which the rate rises.
const WARM_UP: f64 = 0.04;

/// The rate at the last step over the highest.
const LAST: f64 = 0.01;

impl Recipe {
    /// The learning rate of a step.
    pub fn rate_at(&self, step: u32) -> f64 {
        let steps = f64::from(self.steps.max(1));
        let warm = (WARM_UP * steps).max(1.0);
        let step = f64::from(step);
        if step < warm {
            return self.rate * (step + 1.0) / warm;
        }
        let progress = ((step - warm) / (steps - warm).max(1.0)).min(1.0);
        let cosine = 0.5 * (1.0 + (std::f64::consts::PI * progress).cos());
        self.rate * (LAST + (1.0 - LAST) * cosine)
    }
}
