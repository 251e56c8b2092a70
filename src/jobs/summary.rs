//! The figures that stand in the job itself; the whole is the artifact `metrics.json`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::Metrics;

/// A result at a glance. The names and definitions are those of `metrics.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
pub struct MetricsSummary {
    /// Whether the atlas is valid: `atlas.certificate.valid`.
    pub valid: bool,
    /// Faces whose UV orientation is wrong: `atlas.certificate.flipped`.
    pub flipped: u64,
    /// Pairs of faces that overlap: `atlas.certificate.overlapping_pairs`.
    pub overlapping_pairs: u64,
    /// How many parts.
    pub parts: u64,
    /// How many charts.
    pub charts: u64,
    /// `atlas.symmetric_dirichlet_chart`: 1 is isometric.
    #[schema(required)]
    pub symmetric_dirichlet_chart: Option<f64>,
    /// `atlas.quasi_conformal.mean`: 1 is conformal.
    #[schema(required)]
    pub quasi_conformal: Option<f64>,
    /// `atlas.seam_length.per_sqrt_area`.
    #[schema(required)]
    pub seam_length: Option<f64>,
    /// `atlas.packing_efficiency.covered`.
    pub packing_efficiency: f64,
    /// Whether the result is a function of its input alone.
    pub deterministic: bool,
    /// Wall-clock seconds of the pipeline: `cost.wall_s`.
    pub wall_s: f64,
}

impl From<&Metrics> for MetricsSummary {
    fn from(metrics: &Metrics) -> Self {
        let atlas = &metrics.atlas;
        Self {
            valid: atlas.certificate.valid,
            flipped: atlas.certificate.flipped,
            overlapping_pairs: atlas.certificate.overlapping_pairs,
            parts: metrics.parts.len() as u64,
            charts: metrics.charts.len() as u64,
            symmetric_dirichlet_chart: atlas.figures.symmetric_dirichlet_chart,
            quasi_conformal: atlas.figures.quasi_conformal.map(|stats| stats.mean),
            seam_length: atlas.figures.seam_length.map(|length| length.per_sqrt_area),
            packing_efficiency: atlas.packing_efficiency.covered,
            deterministic: metrics.deterministic,
            wall_s: metrics.cost.wall_s,
        }
    }
}
