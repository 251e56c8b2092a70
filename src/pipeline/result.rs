//! What the pipeline returns: the metrics and the named files, the same for every caller.

use crate::contract::{ArtifactKind, Cost, Metrics};

/// One file of a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Artifact {
    /// Which one.
    pub kind: ArtifactKind,
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
    pub fn artifact(&self, kind: ArtifactKind) -> Option<&[u8]> {
        self.artifacts.iter().find(|a| a.kind == kind).map(|a| a.bytes.as_slice())
    }

    /// The files in which two results differ. The metrics are compared less their `cost`:
    /// it tells of the run and not of the result.
    pub fn differences(&self, other: &Self) -> Vec<ArtifactKind> {
        let less_cost = |m: &Metrics| Metrics { cost: Cost::default(), ..m.clone() };
        let same = |a: &Artifact, b: &Artifact| match a.kind {
            // As text, for there two numbers that differ look different, and NaN looks the same.
            ArtifactKind::Metrics => {
                let text = |m: &Metrics| serde_json::to_string(&less_cost(m)).ok();
                text(&self.metrics) == text(&other.metrics)
            }
            _ => a.bytes == b.bytes,
        };
        let missing = |of: &Self, kind| of.artifact(kind).is_none();
        let differs = |a: &&Artifact| {
            let twin = other.artifacts.iter().find(|b| b.kind == a.kind);
            twin.is_none_or(|b| !same(a, b))
        };
        let own = self.artifacts.iter().filter(differs);
        let foreign = other.artifacts.iter().filter(|b| missing(self, b.kind));
        own.chain(foreign).map(|a| a.kind).collect()
    }

    /// The result in a sentence or two.
    pub fn summary(&self) -> String {
        let m = &self.metrics;
        let number = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.4}"));
        if m.atlas.charts == 0 && m.charts.is_empty() && !m.parts.is_empty() {
            let names: Vec<&str> = m.parts.iter().take(12).map(|p| p.name.as_str()).collect();
            let more = if m.parts.len() > 12 { ", …" } else { "" };
            let seconds = m.cost.wall_s;
            return format!("{} parts: {}{more}; {seconds:.1} s", m.parts.len(), names.join(", "));
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{AtlasMetrics, Repairs, Units};

    /// A result with two files, one of them its metrics.
    fn result() -> Unwrapped {
        let artifact = |kind, bytes: &[u8]| Artifact { kind, bytes: bytes.to_vec() };
        let artifacts =
            vec![artifact(ArtifactKind::Model, b"glTF"), artifact(ArtifactKind::Metrics, b"{}")];
        let metrics = Metrics {
            schema: 1,
            deterministic: true,
            degraded: Vec::new(),
            units: Units::default(),
            atlas: AtlasMetrics::default(),
            parts: Vec::new(),
            part_joins: Vec::new(),
            charts: Vec::new(),
            repairs: Repairs::default(),
            engine: String::new(),
            weights: None,
            device: String::new(),
            cost: Cost::default(),
        };
        Unwrapped { metrics, artifacts }
    }

    #[test]
    fn one_byte_one_figure_or_one_file_is_a_difference_and_the_cost_is_none() {
        let (one, mut two) = (result(), result());
        two.metrics.cost.wall_s = 1.0;
        assert!(one.differences(&two).is_empty());
        two.metrics.atlas.charts = 1;
        assert_eq!(one.differences(&two), [ArtifactKind::Metrics]);
        two.artifacts[0].bytes[3] ^= 1;
        assert_eq!(one.differences(&two), [ArtifactKind::Model, ArtifactKind::Metrics]);
        let mut less = result();
        less.artifacts.remove(0);
        assert_eq!(one.differences(&less), [ArtifactKind::Model]);
        assert_eq!(less.differences(&one), [ArtifactKind::Model]);
    }
}
