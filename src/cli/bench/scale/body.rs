//! One mesh of the scale benchmark: which, how it is made, and what programs make of it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::synth::body::{self, BodyStyle};
use crate::synth::{BodyKind, NoiseKind};

/// A mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Case {
    #[serde(with = "by_name")]
    pub body: BodyKind,
    /// At most; at least 97 % of it.
    pub triangles: u32,
    /// Mean edge lengths.
    pub noise: f64,
    #[serde(with = "by_name")]
    pub noise_kind: NoiseKind,
    pub copies: u32,
}

/// Names of the command line in the file.
mod by_name {
    use clap::ValueEnum;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<T: ValueEnum, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        let name = value.to_possible_value();
        to.serialize_str(name.as_ref().map_or("", |name| name.get_name()))
    }

    pub fn deserialize<'de, T: ValueEnum, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
        T::from_str(&String::deserialize(from)?, false).map_err(D::Error::custom)
    }
}

/// What one program made of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    #[serde(flatten)]
    pub case: Case,
    /// `this` or `beside`.
    pub program: String,
    /// Why there are no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Figures>,
}

/// Figures of the run with the median of the seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Triangles of the mesh.
    pub triangles: u64,
    /// Of the whole process.
    pub seconds: f64,
    /// Seconds of each stage, in order.
    pub stages: Vec<(String, f64)>,
    pub peak_memory_mib: Option<f64>,
    pub valid: bool,
    pub parts: usize,
    pub charts: u32,
    /// Seam length over √area.
    pub seam: Option<f64>,
    pub symmetric_dirichlet: Option<f64>,
    pub packing: f64,
    pub small_charts: Option<u32>,
    pub seam_jaggedness: Option<f64>,
}

/// Read the lines of a file.
pub fn read(path: &Path) -> Result<Vec<Row>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty());
    let row = |(i, line)| {
        let place = || format!("{} line {}: not a line of this benchmark", path.display(), i + 1);
        serde_json::from_str(line).with_context(place)
    };
    lines.map(row).collect()
}

impl Case {
    /// Write the mesh.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        let style = BodyStyle {
            triangles: self.triangles as usize,
            noise: self.noise,
            noise_kind: self.noise_kind,
            seed: 1,
            copies: self.copies as usize,
        };
        let path = folder.join("mesh.glb");
        let body = body::make(self.body, style);
        std::fs::write(&path, body.glb(self.body.as_str()))
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }
}

/// Unwrap a mesh by each program, in turn so that what else the machine does falls on both.
pub fn measure(
    case: &Case,
    programs: &[(&str, &PathBuf)],
    mesh: &Path,
    repeat: u32,
    options: &[String],
    folder: &Path,
) -> Result<Vec<Row>> {
    let mut runs: Vec<Result<Vec<Figures>>> = programs.iter().map(|_| Ok(Vec::new())).collect();
    for _ in 0..repeat {
        for ((_, program), done) in programs.iter().zip(&mut runs) {
            if let Ok(figures) = done {
                match unwrap(program, mesh, options, folder) {
                    Ok(new) => figures.push(new),
                    Err(error) => *done = Err(error),
                }
            }
        }
    }
    let row = |((name, _), runs): (&(&str, &PathBuf), Result<Vec<Figures>>)| {
        let (figures, error) = match runs {
            Ok(mut runs) => {
                runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
                let median = runs.len() / 2;
                (runs.into_iter().nth(median), None)
            }
            Err(error) => (None, Some(format!("{error:#}"))),
        };
        Row { case: *case, program: (*name).to_owned(), error, figures }
    };
    Ok(programs.iter().zip(runs).map(row).collect())
}

fn unwrap(program: &Path, mesh: &Path, options: &[String], folder: &Path) -> Result<Figures> {
    let metrics = folder.join("metrics.json");
    let _ = std::fs::remove_file(&metrics);
    let mut command = Command::new(program);
    command.arg("unwrap").arg(mesh).arg("--quiet").args(options);
    command.arg("--output").arg(folder.join("model.glb"));
    command.arg("--preview").arg(folder.join("preview.png")).arg("--metrics").arg(&metrics);
    let began = Instant::now();
    let output = command.output().with_context(|| format!("cannot run {}", program.display()))?;
    let seconds = began.elapsed().as_secs_f64();
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{}: {}", output.status, said.lines().last().unwrap_or_default());
    }
    // Another build's metrics may lack what this one's have.
    let m: Value = serde_json::from_slice(&std::fs::read(&metrics)?)?;
    let at = |place: &str| m.pointer(place).and_then(Value::as_f64);
    let list = |place: &str| m.pointer(place).and_then(Value::as_array).map_or(&[][..], |l| l);
    let stage = |s: &Value| Some((s["name"].as_str()?.to_owned(), s["wall_s"].as_f64()?));
    Ok(Figures {
        triangles: list("/parts").iter().filter_map(|part| part["faces"].as_u64()).sum::<u64>(),
        seconds,
        stages: list("/cost/stages").iter().filter_map(stage).collect(),
        peak_memory_mib: at("/cost/peak_memory_mib"),
        valid: m.pointer("/atlas/certificate/valid") == Some(&Value::Bool(true)),
        parts: list("/parts").len(),
        charts: at("/atlas/charts").unwrap_or(0.0) as u32,
        seam: at("/atlas/seam_length/per_sqrt_area"),
        symmetric_dirichlet: at("/atlas/symmetric_dirichlet"),
        packing: at("/atlas/packing_efficiency/covered").unwrap_or(0.0),
        small_charts: at("/atlas/small_charts").map(|n| n as u32),
        seam_jaggedness: at("/atlas/seam_jaggedness"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let case = Case {
            body: BodyKind::FusedChair,
            triangles: 20_000,
            noise: 1.0 / 6.0,
            noise_kind: NoiseKind::Isotropic,
            copies: 3,
        };
        let row = Row { case, program: "this".into(), error: Some("x".into()), figures: None };
        let line = serde_json::to_string(&row).unwrap();
        assert!(line.contains("\"fused_chair\"") && line.contains("\"isotropic\""), "{line}");
        assert_eq!(serde_json::from_str::<Row>(&line).unwrap(), row);
    }
}
