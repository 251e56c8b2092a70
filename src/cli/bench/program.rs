//! An unwrap by a program of its own: this build, or another one beside it.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde_json::Value;

/// What came of it.
pub struct Ran {
    /// Of the whole process.
    pub seconds: f64,
    /// Its metrics; another build's may lack what this one's have.
    pub metrics: Value,
}

/// Name of the model in the folder of a run.
pub const MODEL: &str = "model.glb";

/// Unwrap a mesh. Model, preview and metrics go to `folder`.
pub fn unwrap(program: &Path, mesh: &Path, options: &[String], folder: &Path) -> Result<Ran> {
    let metrics = folder.join("metrics.json");
    let _ = std::fs::remove_file(&metrics);
    let mut command = Command::new(program);
    command.arg("unwrap").arg(mesh).arg("--quiet").args(options);
    command.arg("--output").arg(folder.join(MODEL));
    command.arg("--preview").arg(folder.join("preview.png")).arg("--metrics").arg(&metrics);
    let began = Instant::now();
    let output = command.output().with_context(|| format!("cannot run {}", program.display()))?;
    let seconds = began.elapsed().as_secs_f64();
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{}: {}", output.status, said.lines().last().unwrap_or_default());
    }
    Ok(Ran { seconds, metrics: serde_json::from_slice(&std::fs::read(&metrics)?)? })
}

impl Ran {
    /// A number of the metrics.
    pub fn at(&self, place: &str) -> Option<f64> {
        self.metrics.pointer(place).and_then(Value::as_f64)
    }

    /// A list of the metrics, empty where there is none.
    pub fn list(&self, place: &str) -> &[Value] {
        self.metrics.pointer(place).and_then(Value::as_array).map_or(&[], |list| list)
    }

    /// Whether the atlas is valid.
    pub fn is_valid(&self) -> bool {
        self.metrics.pointer("/atlas/certificate/valid") == Some(&Value::Bool(true))
    }
}
