//! What the pipeline returns: the metrics and the named files, the same for every caller.

use crate::contract::Metrics;

/// One file of a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Artifact {
    /// Its name: model.glb, metrics.json, uv_layout.svg or preview.png; or labels.txt.
    pub name: &'static str,
    /// Its media type.
    pub media_type: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// A finished job.
#[derive(Debug, Clone)]
pub struct Unwrapped {
    /// What was measured.
    pub metrics: Metrics,
    pub(super) artifacts: Vec<Artifact>,
}

impl Unwrapped {
    /// The files.
    pub fn artifacts(&self) -> &[Artifact] {
        &self.artifacts
    }

    /// One of the files.
    pub fn artifact(&self, name: &str) -> Option<&[u8]> {
        self.artifacts.iter().find(|a| a.name == name).map(|a| a.bytes.as_slice())
    }

    /// The result in a sentence or two.
    pub fn summary(&self) -> String {
        let m = &self.metrics;
        let number = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.4}"));
        let trained = m.charts.iter().filter(|c| c.steps > 0).count();
        format!(
            "{} parts, {} charts ({trained} trained on {}), {}; seam length {} × √area, \
             symmetric Dirichlet {}, packing {:.0} %; {:.1} s",
            m.parts.len(),
            m.atlas.charts,
            m.device,
            if m.atlas.certificate.valid { "valid" } else { "NOT VALID: see the certificate" },
            m.atlas
                .figures
                .seam_length
                .map_or("–".to_owned(), |s| format!("{:.2}", s.per_sqrt_area)),
            number(m.atlas.figures.symmetric_dirichlet),
            100.0 * m.atlas.packing_efficiency.covered,
            m.cost.wall_s,
        )
    }
}
