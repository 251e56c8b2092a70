//! What a program makes of a telling, and how it compares with what it made of the first.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use serde::{Deserialize, Serialize};

use super::mesh::PlainMesh;
use super::variants::Variant;
use crate::cli::bench::stages::spelled_out;
use crate::cli::bench::{by_name, program};
use crate::contract::{Limits, MeshKind};
use crate::mesh::{self, Document, NONE};
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
    parts: Vec<u32>,
    charts: Option<Vec<u32>>,
}

/// Unwrap a telling by a program.
pub fn unwrap(program: &Path, told: &PlainMesh, options: &[String], folder: &Path) -> Result<Told> {
    let file = folder.join("telling.obj");
    std::fs::write(&file, told.obj())
        .with_context(|| format!("cannot write {}", file.display()))?;
    let ran = program::unwrap(program, &file, options, folder)?;
    let model = std::fs::read(folder.join(program::MODEL))?;
    let scene = mesh::import(&model, MeshKind::Glb, &Limits::default())?;
    let Some(Document::Gltf { json, .. }) = &scene.source else {
        return Err(anyhow!("the model has no document"));
    };
    let of_face =
        |key: &str| spelled_out(&json["asset"]["extras"]["uvsegnet"][key], told.triangles.len());
    Ok(Told {
        figures: Figures {
            valid: ran.is_valid(),
            parts: ran.list("/parts").len(),
            charts: ran.at("/atlas/charts").unwrap_or(0.0) as u32,
            seam: ran.at("/atlas/seam_length/per_sqrt_area"),
            symmetric_dirichlet: ran.at("/atlas/symmetric_dirichlet"),
            seam_jaggedness: ran.at("/atlas/seam_jaggedness"),
            packing: ran.at("/atlas/packing_efficiency/covered").unwrap_or(0.0),
            seconds: ran.seconds,
            rand: None,
            adjusted_rand: None,
            same: None,
        },
        parts: of_face("face_parts")?,
        // A job that ends with its parts has none.
        charts: of_face("face_charts").ok(),
    })
}

impl Told {
    /// Compare it with what was made of the first telling.
    pub fn compare(&mut self, mesh: &PlainMesh, first: &Self) {
        let faces: Vec<(usize, usize)> =
            (0..mesh.triangles.len()).filter_map(|f| Some((f, mesh.source[f]? as usize))).collect();
        let label = |part: u32| if part == NONE { -1 } else { part as i32 };
        let own: Vec<i32> = faces.iter().map(|f| label(self.parts[f.0])).collect();
        let before: Vec<i32> = faces.iter().map(|f| label(first.parts[f.1])).collect();
        let area: Vec<f64> = faces.iter().map(|f| mesh.area(f.0)).collect();
        let parts = agreement(&before, &own, &area);
        self.figures.rand = Some(parts.rand);
        self.figures.adjusted_rand = Some(parts.adjusted_rand);
        if let (Some(own), Some(before)) = (&self.charts, &first.charts) {
            let pairs = faces.iter().map(|&(f, s)| (before[s], own[f]));
            let pairs: Vec<(u32, u32)> = pairs.filter(|p| p.0 != NONE && p.1 != NONE).collect();
            self.figures.same = Some(is_one_to_one(&pairs));
        }
    }
}

/// Whether each first stands with one second and the other way round.
fn is_one_to_one(pairs: &[(u32, u32)]) -> bool {
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
