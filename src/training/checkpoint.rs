//! A run's folder: `recipe.json`, `model.safetensors` and `optimizer.bin` as of the last checkpoint,
//! `state.json` with the step and the curves, `best.safetensors`, `curves.png`. A run that was ended goes
//! on from there; each file is written beside and moved into place.

use std::path::{Path, PathBuf};

use burn::module::Module;
use burn::optim::ModuleOptimizer;
use burn::store::{ModuleSnapshot, SafetensorsStore};
use serde::{Deserialize, Serialize};

use super::recipe::Recipe;
use super::trainer::TrainError;
use super::validation::Score;
use crate::preview::{Curve, curves_png};

/// Where a run stands.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Steps taken.
    pub step: u32,
    /// Loss of each step.
    pub losses: Vec<f64>,
    /// Scores, each after that many steps.
    pub scores: Vec<(u32, Score)>,
    /// The best score's mIoU (pre-training: minus the loss).
    pub best: Option<f64>,
    /// Seconds, over all the times it was taken up.
    pub seconds: f64,
}

/// The folder of a run.
#[derive(Debug, Clone)]
pub struct Folder(PathBuf);

impl Folder {
    /// Open the folder of a run, or make it. A folder of another recipe is an error.
    pub fn open(path: &Path, recipe: &Recipe) -> Result<(Self, Option<State>), TrainError> {
        std::fs::create_dir_all(path).map_err(|e| fault(path, e))?;
        let folder = Self(path.to_path_buf());
        let file = folder.file("recipe.json");
        let text = serde_json::to_string_pretty(recipe).map_err(|e| fault(&file, e))?;
        if file.exists() {
            let there = std::fs::read_to_string(&file).map_err(|e| fault(&file, e))?;
            if there != text {
                return Err(TrainError::OtherRecipe(file.display().to_string()));
            }
        } else {
            folder.write("recipe.json", text.as_bytes())?;
        }
        let file = folder.file("state.json");
        let state = if file.exists() {
            let text = std::fs::read(&file).map_err(|e| fault(&file, e))?;
            Some(serde_json::from_slice(&text).map_err(|e| fault(&file, e))?)
        } else {
            None
        };
        Ok((folder, state))
    }

    /// A file of the folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), TrainError> {
        let (part, whole) = (self.file(&format!("{name}.part")), self.file(name));
        std::fs::write(&part, bytes).map_err(|e| fault(&part, e))?;
        std::fs::rename(&part, &whole).map_err(|e| fault(&whole, e))
    }

    /// Write a checkpoint; the state last, so that a run never goes on from half of one.
    pub fn save<M: Module>(
        &self,
        model: &M,
        optimizer: &ModuleOptimizer,
        state: &State,
        is_best: bool,
    ) -> Result<(), TrainError> {
        // Of several entries the order would differ from run to run.
        let mut store = SafetensorsStore::from_bytes(None).clear_metadata();
        model.save_into(&mut store).map_err(|e| fault(&self.0, e))?;
        let bytes = store.get_bytes().map_err(|e| fault(&self.0, e))?;
        self.write("model.safetensors", &bytes)?;
        if is_best {
            self.write("best.safetensors", &bytes)?;
        }
        let moments = optimizer.into_bytes().map_err(|e| fault(&self.0, e))?;
        self.write("optimizer.bin", &moments)?;
        let text = serde_json::to_vec(state).map_err(|e| fault(&self.0, e))?;
        self.write("state.json", &text)?;
        let picture = curves_png(&panels(state), "steps").map_err(|e| fault(&self.0, e))?;
        self.write("curves.png", &picture)
    }

    /// Go on from the last checkpoint.
    pub fn restore<M: Module>(
        &self,
        model: &mut M,
        optimizer: ModuleOptimizer,
    ) -> Result<ModuleOptimizer, TrainError> {
        let file = self.file("model.safetensors");
        let mut store = SafetensorsStore::from_file(&file);
        model.load_from(&mut store).map_err(|e| fault(&file, e))?;
        let file = self.file("optimizer.bin");
        let bytes = std::fs::read(&file).map_err(|e| fault(&file, e))?;
        let bytes = burn::tensor::Bytes::from_bytes_vec(bytes);
        optimizer.from_bytes(bytes).map_err(|e| fault(&file, e))
    }
}

fn fault(path: &Path, reason: impl std::fmt::Display) -> TrainError {
    TrainError::File { file: path.display().to_string(), reason: reason.to_string() }
}

/// The loss smoothed over some steps, and the scores.
fn panels(state: &State) -> Vec<(String, Vec<Curve>)> {
    let width = (state.losses.len() / 100).max(1);
    let mean = |(i, chunk): (usize, &[f64])| {
        let step = (i * width + chunk.len()) as f64;
        (step, chunk.iter().sum::<f64>() / chunk.len() as f64)
    };
    let points = state.losses.chunks(width).enumerate().map(mean).collect();
    let loss = Curve { name: format!("mean of {width}"), points };
    let of = |name: &str, value: fn(&Score) -> f64| Curve {
        name: name.to_owned(),
        points: state.scores.iter().map(|(step, s)| (f64::from(*step), value(s))).collect(),
    };
    let mut panels = vec![("loss".to_owned(), vec![loss])];
    if !state.scores.is_empty() {
        let scores = vec![of("mIoU", |s| s.miou), of("Rand", |s| s.rand), of("names", |s| s.names)];
        panels.push(("held-out families".to_owned(), scores));
    }
    panels
}
