//! What the result says of itself inside the file: part and chart of each face, under
//! `asset.extras.uvsegnet`, run-length encoded as `[count, value]` pairs in face order.

use serde::Serialize;

use super::parts::Found;
use crate::contract::SegmentationSource;
use crate::mesh::NONE;

/// The block.
#[derive(Debug, Serialize)]
pub struct Extras<'a> {
    engine: &'static str,
    parts: Vec<PartExtras<'a>>,
    /// Part of each face, −1 for a face without area.
    face_parts: Vec<[i64; 2]>,
    /// Chart of each face; empty where there are no charts.
    face_charts: Vec<[i64; 2]>,
}

#[derive(Debug, Serialize)]
struct PartExtras<'a> {
    id: u32,
    name: &'a str,
    source: SegmentationSource,
    confidence: f64,
}

/// The block for a result; `chart_of` is empty where there are no charts.
pub fn block<'a>(found: &'a Found, chart_of: &[u32]) -> Extras<'a> {
    let parts = found.parts.parts.iter().map(|part| PartExtras {
        id: part.id,
        name: &part.name,
        source: part.source,
        confidence: part.confidence,
    });
    Extras {
        engine: env!("CARGO_PKG_VERSION"),
        parts: parts.collect(),
        face_parts: runs(&found.telling.in_file_order(&found.parts.labels, NONE)),
        face_charts: match chart_of.is_empty() {
            true => Vec::new(),
            false => runs(&found.telling.in_file_order(chart_of, NONE)),
        },
    }
}

fn runs(values: &[u32]) -> Vec<[i64; 2]> {
    let value = |v: u32| if v == NONE { -1 } else { i64::from(v) };
    values.chunk_by(|a, b| a == b).map(|run| [run.len() as i64, value(run[0])]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_add_up() {
        assert_eq!(runs(&[0, 0, 3, NONE, NONE]), [[2, 0], [1, 3], [2, -1]]);
        assert!(runs(&[]).is_empty());
    }
}
