//! What the result says of itself inside the file: part and chart of each face, under
//! `asset.extras.uvsegnet`, run-length encoded as `[count, value]` pairs in face order.

use serde_json::{Value, json};

use super::parts::Found;
use crate::mesh::NONE;

/// The block for a result; `chart_of` is empty where there are no charts.
pub fn block(found: &Found, chart_of: &[u32]) -> Value {
    let parts: Vec<Value> = found
        .parts
        .parts
        .iter()
        .map(
            |p| json!({"id": p.id, "name": p.name, "source": p.source, "confidence": p.confidence}),
        )
        .collect();
    json!({
        "engine": env!("CARGO_PKG_VERSION"),
        "parts": parts,
        "face_parts": runs(&found.parts.labels),
        "face_charts": runs(chart_of),
    })
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
