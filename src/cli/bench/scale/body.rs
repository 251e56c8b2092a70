//! One mesh of the scale benchmark: which, how it is made, and what programs make of it.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::cli::bench::{by_name, program};
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
    let ran = program::unwrap(program, mesh, options, folder)?;
    let stage = |s: &Value| Some((s["name"].as_str()?.to_owned(), s["wall_s"].as_f64()?));
    Ok(Figures {
        triangles: ran.list("/parts").iter().filter_map(|part| part["faces"].as_u64()).sum::<u64>(),
        seconds: ran.seconds,
        stages: ran.list("/cost/stages").iter().filter_map(stage).collect(),
        peak_memory_mib: ran.at("/cost/peak_memory_mib"),
        valid: ran.is_valid(),
        parts: ran.list("/parts").len(),
        charts: ran.at("/atlas/charts").unwrap_or(0.0) as u32,
        seam: ran.at("/atlas/seam_length/per_sqrt_area"),
        symmetric_dirichlet: ran.at("/atlas/symmetric_dirichlet"),
        packing: ran.at("/atlas/packing_efficiency/covered").unwrap_or(0.0),
        small_charts: ran.at("/atlas/small_charts").map(|n| n as u32),
        seam_jaggedness: ran.at("/atlas/seam_jaggedness"),
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
