//! What a program makes of a telling, and how it compares with what it made of the first.

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::mesh::PlainMesh;
use super::variants::Variant;
use crate::contract::{Limits, MeshKind};
use crate::mesh::{self, Document};
use crate::segmentation::agreement::agreement;

/// A telling of an object by one program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub object: String,
    #[serde(with = "by_name")]
    pub variant: Variant,
    /// `this` or `beside`.
    pub program: String,
    /// Why there are no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Figures>,
}

/// Names of the command line in the file.
mod by_name {
    use super::{ValueEnum, Variant};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(value: &Variant, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&value.name())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Variant, D::Error> {
        Variant::from_str(&String::deserialize(from)?, false).map_err(D::Error::custom)
    }
}

/// Figures of a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    pub valid: bool,
    pub parts: usize,
    pub charts: u32,
    /// Seam length over √area.
    pub seam: Option<f64>,
    pub symmetric_dirichlet: Option<f64>,
    pub seam_jaggedness: Option<f64>,
    pub packing: f64,
    /// Of the whole process.
    pub seconds: f64,
    /// Rand index of its parts against those of the first telling, by area.
    pub rand: Option<f64>,
    /// The same, adjusted for chance.
    pub adjusted_rand: Option<f64>,
    /// Whether its charts divide the faces as those of the first telling do.
    pub same: Option<bool>,
}

/// A result: figures, and part and chart of each face.
pub struct Told {
    pub figures: Figures,
    parts: Vec<i32>,
    charts: Vec<i32>,
}

/// Unwrap a telling by a program.
pub fn unwrap(program: &Path, told: &PlainMesh, options: &[String], folder: &Path) -> Result<Told> {
    let (file, model) = (folder.join("telling.obj"), folder.join("model.glb"));
    let metrics = folder.join("metrics.json");
    std::fs::write(&file, told.obj())
        .with_context(|| format!("cannot write {}", file.display()))?;
    let mut command = Command::new(program);
    command.arg("unwrap").arg(&file).arg("--quiet").args(options);
    command.arg("--output").arg(&model).arg("--metrics").arg(&metrics);
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
    let scene = mesh::import(&std::fs::read(&model)?, MeshKind::Glb, &Limits::default())?;
    let Some(Document::Gltf { json, .. }) = &scene.source else {
        return Err(anyhow!("the model has no document"));
    };
    let of_face = |key: &str| spelled_out(&json["asset"]["extras"]["uvsegnet"][key]);
    Ok(Told {
        figures: Figures {
            valid: m.pointer("/atlas/certificate/valid") == Some(&Value::Bool(true)),
            parts: m["parts"].as_array().map_or(0, Vec::len),
            charts: at("/atlas/charts").unwrap_or(0.0) as u32,
            seam: at("/atlas/seam_length/per_sqrt_area"),
            symmetric_dirichlet: at("/atlas/symmetric_dirichlet"),
            seam_jaggedness: at("/atlas/seam_jaggedness"),
            packing: at("/atlas/packing_efficiency/covered").unwrap_or(0.0),
            seconds,
            rand: None,
            adjusted_rand: None,
            same: None,
        },
        parts: of_face("face_parts"),
        charts: of_face("face_charts"),
    })
}

fn spelled_out(runs: &Value) -> Vec<i32> {
    let run = |run: &Value| Some((run.get(0)?.as_u64()? as usize, run.get(1)?.as_i64()? as i32));
    let runs = runs.as_array().into_iter().flatten().filter_map(run);
    runs.flat_map(|(count, value)| std::iter::repeat_n(value, count)).collect()
}

impl Told {
    /// Compare it with what was made of the first telling.
    pub fn compare(&mut self, mesh: &PlainMesh, first: &Self) {
        let faces: Vec<(usize, usize)> = (0..mesh.triangles.len())
            .filter_map(|f| Some((f, mesh.source[f]? as usize)))
            .filter(|&(f, s)| f < self.parts.len() && s < first.parts.len())
            .collect();
        let own = |values: &[i32]| faces.iter().map(|f| values[f.0]).collect::<Vec<i32>>();
        let before = |values: &[i32]| faces.iter().map(|f| values[f.1]).collect::<Vec<i32>>();
        let area: Vec<f64> = faces.iter().map(|f| mesh.area(f.0)).collect();
        let parts = agreement(&before(&first.parts), &own(&self.parts), &area);
        self.figures.rand = Some(parts.rand);
        self.figures.adjusted_rand = Some(parts.adjusted_rand);
        if self.charts.len() >= mesh.triangles.len() {
            let pairs = before(&first.charts).into_iter().zip(own(&self.charts));
            let pairs: Vec<(i32, i32)> = pairs.filter(|(a, b)| *a >= 0 && *b >= 0).collect();
            self.figures.same = Some(is_one_to_one(&pairs));
        }
    }
}

/// Whether each first stands with one second and the other way round.
fn is_one_to_one(pairs: &[(i32, i32)]) -> bool {
    let (mut there, mut back) = (HashMap::new(), HashMap::new());
    pairs
        .iter()
        .all(|&(a, b)| *there.entry(a).or_insert(b) == b && *back.entry(b).or_insert(a) == a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_division_is_the_same_under_other_numbers() {
        assert!(is_one_to_one(&[(0, 2), (1, 0), (0, 2)]));
        assert!(!is_one_to_one(&[(0, 2), (1, 2)]) && !is_one_to_one(&[(0, 2), (0, 1)]));
    }

    #[test]
    fn a_line_is_read_as_it_was_written() {
        let row = Row {
            object: "chair".into(),
            variant: Variant::TJunctions,
            program: "this".into(),
            error: Some("x".into()),
            figures: None,
        };
        let line = serde_json::to_string(&row).unwrap();
        assert!(line.contains("\"t_junctions\""), "{line}");
        assert_eq!(serde_json::from_str::<Row>(&line).unwrap(), row);
    }
}
