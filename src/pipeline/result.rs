//! What the pipeline returns: the metrics and the named files, the same for every caller.

use crate::contract::{ArtifactKind, Metrics};

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
        let same = |a: &Artifact, b: &Artifact| match a.kind {
            // As text, for there two numbers that differ look different, and NaN looks the same.
            ArtifactKind::Metrics => {
                let text = |m: &Metrics| serde_json::to_string(&m.without_cost()).ok();
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

    /// The result in a few lines: what it is, and what the user should know of it.
    pub fn summary(&self) -> String {
        let m = &self.metrics;
        let s = &m.summary;
        if m.atlas.charts == 0 {
            let names: Vec<&str> = m.parts.iter().take(12).map(|p| p.name.as_str()).collect();
            let more = if m.parts.len() > 12 { ", …" } else { "" };
            return format!(
                "{}: {}{more}; {:.1} s",
                counted(s.parts, "part"),
                names.join(", "),
                s.seconds
            );
        }
        let number = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.4}"));
        let mut text = format!(
            "{}, {}, {}; seam length {} × √area, symmetric Dirichlet {}, {:.0} % of {} used; {:.1} s",
            counted(s.parts, "part"),
            counted(s.charts, "chart"),
            if s.valid == Some(true) { "valid" } else { "NOT VALID: see the certificate" },
            s.seam_length.map_or("–".to_owned(), |length| format!("{length:.2}")),
            number(s.symmetric_dirichlet),
            100.0 * s.packing,
            counted(s.pages, "page"),
            s.seconds,
        );
        if let Some(variation) = s.density_variation {
            let percent = 100.0 * variation;
            text += &format!("\ntexel densities differ as asked: by {percent:.0} % of their mean");
        }
        if s.charts_of_network > 0 {
            text +=
                &format!("\nthe network's map ships in {}", counted(s.charts_of_network, "chart"));
        }
        if !m.degraded.is_empty() {
            text += &format!("\ngiven up: {}", m.degraded.join("; "));
        }
        text
    }
}

/// A number of things, in words.
fn counted(count: u32, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::{AtlasMetrics, Cost, Repairs, Summary, Units};

    /// A result with two files, one of them its metrics.
    fn result() -> Unwrapped {
        let artifact = |kind, bytes: &[u8]| Artifact { kind, bytes: bytes.to_vec() };
        let artifacts =
            vec![artifact(ArtifactKind::Model, b"glTF"), artifact(ArtifactKind::Metrics, b"{}")];
        let metrics = Metrics {
            schema: 2,
            summary: Summary::default(),
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
    fn the_summary_says_what_is_so() {
        let mut result = result();
        let m = &mut result.metrics;
        m.atlas.charts = 3;
        m.summary = Summary {
            valid: Some(true),
            parts: 1,
            charts: 3,
            pages: 1,
            seam_length: Some(2.5),
            symmetric_dirichlet: Some(1.25),
            packing: 0.5,
            seconds: 2.0,
            ..Summary::default()
        };
        m.atlas.figures.symmetric_dirichlet = Some(1.4);
        let line = "1 part, 3 charts, valid; seam length 2.50 × √area, symmetric Dirichlet 1.2500, \
            50 % of 1 page used; 2.0 s";
        assert_eq!(result.summary(), line);
        let m = &mut result.metrics;
        m.summary.density_variation = Some(0.3);
        m.summary.charts_of_network = 1;
        m.degraded = vec!["train: too little time".into(), "preview: too little memory".into()];
        let lines = format!(
            "{line}\ntexel densities differ as asked: by 30 % of their mean\nthe network's map ships in 1 \
             chart\ngiven up: train: too little time; preview: too little memory"
        );
        assert_eq!(result.summary(), lines);
        result.metrics.summary.valid = Some(false);
        assert!(result.summary().contains("NOT VALID"));
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
