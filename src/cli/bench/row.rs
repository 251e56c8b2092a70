//! A line of the quality benchmark: what was measured of one object, as it stands in the file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::contract::{BoundaryAlignment, Metrics, Stage};

/// Counts as equal, of seam lengths and distortions that were summed in another order.
pub const ROUNDING: f64 = 1e-5;

/// One object.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Row {
    /// Its name: the path within the folder.
    pub object: String,
    /// Why there are no figures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// What was measured.
    #[serde(flatten)]
    pub measured: Option<Measured>,
}

/// What was measured of one object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measured {
    /// Triangles of the conditioned surface.
    pub triangles: usize,
    /// Faces that had a twin with the opposite winding.
    pub double_sided: u64,
    /// With the options that were given.
    pub ours: ResultFigures,
    /// At no more distortion than the peer.
    #[serde(default)]
    pub matched: Option<ResultFigures>,
    /// Along the labels that lie beside the object.
    #[serde(default)]
    pub along_labels: Option<ResultFigures>,
    /// The peer; `None` where it refuses the mesh.
    pub peer: Option<PeerFigures>,
    /// What the independent measure said, in its own words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent: Option<Value>,
}

/// The figures of a result that the table asks for.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct ResultFigures {
    pub valid: bool,
    pub min_gutter_texels: Option<f64>,
    pub parts: usize,
    pub charts: u32,
    /// Seam length over √area.
    pub seam: Option<f64>,
    pub symmetric_dirichlet: Option<f64>,
    /// σ1/σ2 − 1.
    pub angular: Option<f64>,
    /// Area distortion − 1.
    pub area: Option<f64>,
    pub packing: f64,
    pub avoidable: Option<f64>,
    pub alignment: Option<BoundaryAlignment>,
    /// Share of the area that is developable.
    pub developable: Option<f64>,
    /// Charts that a network was trained for.
    pub trained: usize,
    /// Greatest gain of training over the classical map.
    pub gain: Option<f64>,
    pub degraded: Vec<String>,
    /// Without the pictures.
    pub seconds: f64,
    /// Seconds of each stage.
    pub stages: BTreeMap<String, f64>,
    pub peak_memory_mib: Option<f64>,
}

/// What the peer reaches.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PeerFigures {
    /// On the conditioned sheets.
    pub charts: u32,
    /// On the mesh as it came.
    pub raw_charts: u32,
    /// Seam length over √area.
    pub seam: f64,
    /// At one scale.
    pub symmetric_dirichlet: f64,
    pub seconds: f64,
}

impl ResultFigures {
    /// Of a result.
    pub fn of(m: &Metrics) -> Self {
        let (f, c) = (&m.atlas.figures, &m.atlas.certificate);
        let preview = m.cost.stages.iter().find(|s| s.name == Stage::Preview.as_str());
        let gains = m.charts.iter().filter_map(|c| c.neural_gain.and_then(|g| g.gain));
        Self {
            valid: c.valid,
            min_gutter_texels: c.min_gutter_texels,
            parts: m.parts.len(),
            charts: m.atlas.charts,
            seam: f.seam_length.map(|s| s.per_sqrt_area),
            symmetric_dirichlet: f.symmetric_dirichlet,
            angular: f.quasi_conformal.map(|q| q.mean - 1.0),
            area: f.area_distortion.map(|a| a.mean - 1.0),
            packing: m.atlas.packing_efficiency.covered,
            avoidable: f.avoidable_seam,
            alignment: f.boundary_alignment,
            developable: m.atlas.developable,
            trained: m.charts.iter().filter(|c| c.steps > 0).count(),
            gain: gains.reduce(f64::max),
            degraded: m.degraded.clone(),
            seconds: m.cost.wall_s - preview.map_or(0.0, |s| s.wall_s),
            stages: m.cost.stages.iter().map(|s| (s.name.clone(), s.wall_s)).collect(),
            peak_memory_mib: m.cost.peak_memory_mib,
        }
    }

    /// Whether there are fewer charts than the peer's (or as few as can be: one), no longer seams and no
    /// more distortion.
    pub fn dominates(&self, peer: &PeerFigures) -> bool {
        let at_most = |ours: Option<f64>, theirs: f64| ours.is_some_and(|x| x <= theirs + ROUNDING);
        at_most(self.symmetric_dirichlet, peer.symmetric_dirichlet)
            && (self.charts < peer.charts || self.charts == 1)
            && at_most(self.seam, peer.seam)
    }
}
